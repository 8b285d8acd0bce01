"""A parameter over a coordinate from a file: a line of names, then numbers."""

from __future__ import annotations

import csv
import io
import math

from pgimp.errors import CaseError, explain
from pgimp.schema.messages import shorten, unknown
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
        text = read_plain(name, _LARGEST).decode("utf-8-sig")
    except OSError as error:
        raise CaseError(f"cannot read the table {name}: {explain(error)}") from None
    except UnicodeDecodeError:
        raise CaseError(f"cannot read the table {name}: it is no text in UTF-8") from None
    rows: list[tuple[float, float]] = []
    head: list[str] | None = None
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        words = [word.strip() for word in next(csv.reader(io.StringIO(line)))]
        where = f"the table {name}, line {number}"
        if head is None:
            head = words
            for wanted in (over, column):
                if wanted not in head:
                    raise CaseError(f"{where}: {unknown('column', wanted, head, 'there are')}")
            continue
        if len(words) != len(head):
            raise CaseError(f"{where}: {len(words)} values, expected {len(head)}")
        pair = []
        for wanted in (over, column):
            word = words[head.index(wanted)]
            try:
                value = float(word) if "_" not in word else math.nan  # Python takes 1_0 for 10
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                text = f"'{shorten(word, 40)}' is no finite number"
                raise CaseError(f"{where}, column {wanted}: {text}")
            pair.append(value)
        if rows and not pair[0] > rows[-1][0]:
            text = f"{pair[0]:g} follows {rows[-1][0]:g}"
            raise CaseError(f"{where}, column {over}: the coordinates must increase, but {text}")
        rows.append((pair[0], pair[1]))
    if not rows:
        raise CaseError(f"the table {name} has no row of numbers below a line of names")
    return tuple(rows)
