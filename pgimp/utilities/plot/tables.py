"""CSV of a figure's data."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence

import numpy as np

# The tables of a study begin with run,state.
_OWN = re.compile(rb"run,(?!state,)")


class Table:
    """Rows with all digits.

    Parameters
    ----------
    columns : sequence of str
        Names of the columns, the first is `run`.
    """

    def __init__(self, columns: Sequence[str]) -> None:
        self.columns = list(columns)
        self._parts: list[tuple[list[object], list[np.ndarray]]] = []

    def add(self, same: Sequence[object], columns: Sequence[np.ndarray]) -> None:
        """Add rows.

        Parameters
        ----------
        same : sequence
            Values of the first columns, the same in all rows.
        columns : sequence of ndarray, each of shape (n,)
            The other columns.
        """
        self._parts.append((list(same), list(columns)))

    def text(self) -> str:
        """Return the table as CSV."""
        stream = io.StringIO()
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(self.columns)
        for same, columns in self._parts:
            before = [_exact(value) for value in same]
            lists = [[_exact(value) for value in column.tolist()] for column in columns]
            table.writerows([*before, *row] for row in zip(*lists, strict=True))
        return stream.getvalue()

    @staticmethod
    def is_one(beginning: bytes) -> bool:
        """Return whether a file with this beginning is such a table."""
        return bool(_OWN.match(beginning))


def _exact(value: object) -> str:
    return repr(value) if isinstance(value, float) else str(value)
