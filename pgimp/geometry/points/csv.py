"""Particles from CSV: a line of names, `x,y,z,volume,velocity-x,...`, then a line each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.points.block import PAIRS, STRESS, Block, States
from pgimp.schema.messages import shorten
from pgimp.storage.delimited import Columns, encoding_of

Reals = NDArray[np.float64]

#: Bytes of text per block.
_TEXT = 8_000_000

_AXES = "xyz"


#: Prefix of the names of state variable groups.
_STATE = "state "


def _groups(D: int, states: States) -> dict[str, list[str]]:
    """Names of the columns by group, in the order of a `Block`."""
    axes, pairs = _AXES[:D], PAIRS[: STRESS[D]]
    groups = {
        "position": list(axes),
        "volume": ["volume"],
        "velocity": [f"velocity-{axis}" for axis in axes],
        "stress": [f"stress-{pair}" for pair in pairs],
        "gradient": [f"velocity-gradient-{a}{b}" for a in axes for b in axes],
    }
    used = {key for keys in groups.values() for key in keys}
    for name, tensor in states.items():
        keys = [f"{name}-{pair}" for pair in pairs] if tensor else [name]
        if used.isdisjoint(keys):
            groups[_STATE + name] = keys
    return groups


def read_csv(name: str, D: int, states: States) -> Iterator[Block]:
    """Yield the particles of a file; see `pgimp.geometry.points.file.blocks`."""
    groups = _groups(D, states)
    columns: Columns | None = None
    first = 0
    for line, text in _text(name):
        lines = text.split("\n")
        kept = [
            (line + i, row) for i, row in enumerate(lines) if row.strip() and row.lstrip()[0] != "#"
        ]
        if columns is None and kept:
            columns = Columns(kept[0][1])
            columns.names = [word.lower() for word in columns.names]
            if problem := _misnamed(columns.names, D, states):
                raise CaseError(f"line {kept[0][0]}, the names of its columns: {problem}")
            kept = kept[1:]
        if not kept or columns is None:
            continue
        values = _numbers(kept, columns)
        column = {key: values[:, i] for i, key in enumerate(columns.names)}
        table = {
            group: np.stack([column[key] for key in keys], axis=1) if keys[0] in column else None
            for group, keys in groups.items()
        }
        position = table["position"]
        assert position is not None
        own = {
            group.removeprefix(_STATE): values
            for group, values in table.items()
            if group.startswith(_STATE) and values is not None
        }
        given = table["velocity"], table["stress"], table["gradient"], own
        yield Block(
            first, position, column["volume"], *given, lambda row, kept=kept: f"line {kept[row][0]}"
        )
        first += len(values)
    if columns is None:
        raise CaseError("it has no line of names, such as x,y,z,volume")
    columns.finish()


def _misnamed(head: list[str], D: int, states: States) -> str:
    """Describe errors in the names of the columns; empty if there are none."""
    groups = _groups(D, states)
    known = [key for keys in groups.values() for key in keys]
    spatial = {key for keys in _groups(3, states).values() for key in keys}
    needed = groups["position"] + groups["volume"]
    missing = [
        key
        for group, keys in groups.items()
        for key in keys
        if key not in head and (group in ("position", "volume") or any(key in head for key in keys))
    ]
    strange = [key for key in dict.fromkeys(head) if key not in known]
    beyond = [key for key in strange if key in spatial]
    unknown = [f"'{shorten(key, 40)}'" for key in strange if key not in spatial]
    twice = [f"'{shorten(key, 40)}'" for key, number in Counter(head).items() if number > 1]
    texts = []
    if missing:
        texts.append(f"missing {', '.join(missing)}")
    if beyond:
        texts.append(f"{', '.join(beyond)}, which a case in {D}D does not have: leave them out")
    if unknown:
        more = f" and {len(unknown) - 10} more" if len(unknown) > 10 else ""
        texts.append(f"unknown {', '.join(unknown[:10])}{more}")
    if twice:
        texts.append(f"{', '.join(twice[:10])} more than once")
    if not texts:
        return ""
    optional = "; ".join(
        ",".join(keys) for group, keys in groups.items() if group not in ("position", "volume")
    )
    return f"{'; '.join(texts)}. Expected {','.join(needed)} and, if wanted, {optional}"


def _text(name: str) -> Iterator[tuple[int, str]]:
    """Yield whole lines of a file, some megabytes at a time, with the first line's number."""
    with open(name, "rb") as begin:
        encoding = encoding_of(begin.read(4096))
    line, rest = 1, ""
    with open(name, encoding=encoding) as file:
        while part := file.read(_TEXT):
            whole, newline, rest_of_part = (rest + part).rpartition("\n")
            if not newline:
                rest += part
                if len(rest) > _TEXT:
                    raise CaseError(f"line {line} is longer than {_TEXT:,} characters: no CSV file")
                continue
            rest = rest_of_part
            yield line, whole
            line += whole.count("\n") + 1
    if rest:
        yield line, rest


def _numbers(kept: list[tuple[int, str]], columns: Columns) -> Reals:
    """Numbers of lines, (n, columns)."""
    values = columns.block([row for _, row in kept])
    if values is not None:
        return values
    found = []
    for number, row in kept:
        try:
            words = columns.words(row)
        except ValueError as error:
            raise CaseError(f"line {number}: {error}") from None
        for column, word in zip(columns.names, words, strict=True):
            try:
                found.append(columns.number(word))
            except ValueError as error:
                text = f"line {number}, column {column}: '{shorten(word, 40)}' {error}"
                raise CaseError(text) from None
    return np.array(found).reshape(len(kept), -1)
