"""A parameter over a coordinate from a file: a line of names, then numbers."""

from __future__ import annotations

import math

from pgimp.errors import CaseError, explain
from pgimp.schema.messages import shorten, unknown
from pgimp.storage.delimited import Columns, decoded
from pgimp.storage.plain import read_plain

#: Bytes of a file; a profile is a few thousand.
_LARGEST = 4_000_000


def read_profile(name: str, over: str, column: str) -> tuple[tuple[float, float], ...]:
    """Read two columns of a .csv file; empty lines and those that begin with # do not count.

    Parameters
    ----------
    name : str
        The file.
    over, column : str
        Names of the columns of the coordinate and of the values.

    Returns
    -------
    tuple of (float, float)
        Rows (coordinate, value), the coordinates increasing.

    Raises
    ------
    CaseError
        With the file, the line and the problem.
    """
    try:
        text = decoded(read_plain(name, _LARGEST))
    except OSError as error:
        raise CaseError(f"cannot read the table {name}: {explain(error)}") from None
    except CaseError as error:
        raise CaseError(f"cannot read the table {name}: {error}") from None
    rows: list[tuple[float, float]] = []
    columns: Columns | None = None
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        where = f"the table {name}, line {number}"
        try:
            words = columns.words(line) if columns else []
            columns = columns or Columns(line)
        except ValueError as error:
            raise CaseError(f"{where}: {error}") from None
        if not words:
            for wanted in (over, column):
                if wanted not in columns.names:
                    known = unknown("column", wanted, columns.names, "there are")
                    raise CaseError(f"{where}: {known}")
                if columns.names.count(wanted) > 1:
                    text = f"there is more than one column '{shorten(wanted, 40)}'"
                    raise CaseError(f"{where}: {text}; rename or remove all but one")
            continue
        pair = []
        for wanted in (over, column):
            word = words[columns.names.index(wanted)]
            try:
                value = columns.number(word)
                if not math.isfinite(value):
                    raise ValueError("is no finite number")
            except ValueError as error:
                text = f"'{shorten(word, 40)}' {error}"
                raise CaseError(f"{where}, column {wanted}: {text}") from None
            pair.append(value)
        if rows and not pair[0] > rows[-1][0]:
            text = f"{pair[0]:g} follows {rows[-1][0]:g}"
            raise CaseError(f"{where}, column {over}: the coordinates must increase, but {text}")
        rows.append((pair[0], pair[1]))
    if columns is None or not rows:
        raise CaseError(f"the table {name} has no row of numbers below a line of names")
    try:
        columns.finish()
    except ValueError as error:
        raise CaseError(f"the table {name}: {error}") from None
    return tuple(rows)
