"""Results as NumPy arrays, and as tables of pandas on request."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.errors import UsageError
from pgimp.physics.fields import components_of
from pgimp.schema.messages import nearest
from pgimp.schema.words.renamed import new_column
from pgimp.terminal import escape

if TYPE_CHECKING:
    import pandas


class Table(np.ndarray):
    """A structured array, a field for each column: ``table["time"]``, ``table.dtype.names``."""

    #: Returns the units of columns; None where they are not known.
    units_of: Callable[[Sequence[str]], dict[str, str]] | None = None
    #: Returns the estimated errors of a table; None where they are not known.
    errors_of: Callable[[Table], dict[str, np.ndarray]] | None = None

    def __array_finalize__(self, of: object) -> None:
        """Keep units and errors in parts of a table."""
        self.units_of = getattr(of, "units_of", None)
        self.errors_of = getattr(of, "errors_of", None)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column, empty for one without: ``table.units["strain-energy"]``."""
        names = self.dtype.names or ()
        return self.units_of(names) if self.units_of else dict.fromkeys(names, "")

    @property
    def errors(self) -> dict[str, np.ndarray]:
        """Estimated error of each column, (lines,); of a run without companions there are none."""
        return self.errors_of(self) if self.errors_of else {}

    def __getitem__(self, key: Any) -> Any:
        """Return a column by its name; lines are indexed as in any array.

        Raises
        ------
        KeyError
            If there is no such column; the message lists the columns.
        """
        names = self.dtype.names
        if isinstance(key, str) and names is not None:
            key = key if key in names else new_column(key)
            if key not in names:
                raise KeyError(absent(f"column {key!r}", key, names))
            return np.asarray(super().__getitem__(key))
        return super().__getitem__(key)

    def __repr__(self) -> str:
        """Return the number of lines, and each column's name, first and last value."""
        if self.dtype.names is None or self.ndim != 1:
            return repr(np.asarray(self))
        lines = [f"<Table of {len(self)} line{'s' * (len(self) != 1)}>"]
        width = max(map(len, self.dtype.names), default=0)
        for name in self.dtype.names:
            column = self[name]
            ends = f"{column[0]:.6g} ... {column[-1]:.6g}" if len(self) else "-"
            lines.append(f"  {name:<{width}}  {ends}")
        return escape("\n".join(lines))

    __str__ = __repr__

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a pandas.DataFrame.

        Raises
        ------
        UsageError
            If pandas is not installed.
        """
        frame = data_frame({name: np.asarray(self[name]) for name in self.dtype.names or ()})
        if self.units_of is not None:
            frame.attrs["units"] = self.units
        return frame


class Tables(dict[str, Table]):
    """Tables by name; the error of a wrong name lists the names."""

    def __missing__(self, name: object) -> Table:
        """Raise a KeyError that lists the names."""
        raise KeyError(absent(f"probe {name!r}", str(name), self))

    def __repr__(self) -> str:
        """List each table with its name, number of lines and columns."""
        lines = [
            f"  {name}: {len(table)} lines of {', '.join(table.dtype.names or ('nothing',))}"
            for name, table in self.items()
        ]
        return escape("\n".join([f"<{len(self)} probe{'s' * (len(self) != 1)}>", *lines]))


def absent(what: str, name: str, known: Collection[str]) -> str:
    """Message for an unknown name: a similar name, and all names."""
    guess = nearest(name, known)
    hint = f"did you mean {guess!r}? " if guess else ""
    return escape(f"there is no {what}; {hint}there are: {', '.join(known) or 'none'}")


class Fields(dict[str, np.ndarray]):
    """Fields of particles by name, with equal numbers of rows."""

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
        The arrays; several columns become ``stress-xx``, ``stress-yy`` and so on.
    index : str, optional
        The array that is the index of the rows.

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
            parts = components_of(name, values.shape[1])
            columns |= {f"{name}-{part}": values[:, i] for i, part in enumerate(parts)}
    frame = pandas.DataFrame(columns)
    return frame if index is None else frame.set_index(index)
