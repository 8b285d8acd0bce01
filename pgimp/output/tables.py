"""Results as NumPy arrays that pandas takes over, if it is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pgimp.errors import UsageError
from pgimp.output.fields import EVERY

if TYPE_CHECKING:
    import pandas


class Table(np.ndarray):
    """A structured array, a field for each column: ``table["time"]``, ``table.dtype.names``."""

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a pandas.DataFrame.

        Raises
        ------
        UsageError
            If pandas is not installed.
        """
        return data_frame({name: np.asarray(self[name]) for name in self.dtype.names or ()})


class Fields(dict[str, np.ndarray]):
    """Fields of particles by name, with as many rows each."""

    def to_pandas(self) -> pandas.DataFrame:
        """Return the fields as a pandas.DataFrame, components as columns of their own.

        Raises
        ------
        UsageError
            If pandas is not installed.
        """
        return data_frame(self)


def data_frame(fields: Mapping[str, np.ndarray], index: str | None = None) -> pandas.DataFrame:
    """Return arrays as a pandas.DataFrame.

    Parameters
    ----------
    fields : mapping of str to ndarray, each of shape (n,) or (n, k)
        The arrays; one of several columns gives ``stress-xx``, ``stress-yy`` and so on.
    index : str, optional
        The one that names the rows.

    Raises
    ------
    UsageError
        If pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise UsageError(
            "to_pandas needs pandas, which pgimp does without otherwise: pip install pandas"
        ) from None
    columns = {}
    for name, values in fields.items():
        if values.ndim == 1:
            columns[name] = values
        else:
            columns |= {f"{name}-{part}": values[:, i] for i, part in enumerate(_parts(name))}
    frame = pandas.DataFrame(columns)
    return frame if index is None else frame.set_index(index)


def _parts(name: str) -> list[str]:
    """Names of the components of a field."""
    return EVERY[name].components.split()
