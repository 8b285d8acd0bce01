"""Writing a case as YAML, with every default."""

from __future__ import annotations

import json
import re
from typing import Any

from pgimp.case.choices.choose import lines
from pgimp.case.schema import Case
from pgimp.schema.document import scalar

WIDTH = 100
"""Characters a line; what does not fit is broken into one line a key."""

SECTIONS = ("materials", "bodies")
"""Written with an entry a line even where all fits on one."""

_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


def dump_case(case: Case) -> str:
    """Return `case` as the text of a case file.

    Every default is written out, and comments say what was chosen and why. The text is itself a
    case file, and reading it gives an equal case with the same bits in every number.
    """
    data = case.model_dump(by_alias=True)
    chosen = "".join(f"# chosen: {line}\n" for line in lines(case))
    return chosen + "".join(_entry(key, value, "") for key, value in data.items())


def _entry(key: str, value: object, indent: str) -> str:
    """Return ``key: value`` on one line, or with its parts on separate lines."""
    start = f"{indent}{_scalar(key)}:"
    line = f"{start} {flow(value)}\n"
    fits = len(line) <= WIDTH + 1 and not (key in SECTIONS and not indent)
    if fits or not value or not isinstance(value, dict | tuple | list):
        return line
    return start + "\n" + _block(value, indent + "  ")


def _block(value: Any, indent: str) -> str:
    if isinstance(value, dict):
        return "".join(_entry(key, item, indent) for key, item in value.items())
    return "".join(f"{indent}- {_item(item, indent)}" for item in value)


def _item(value: object, indent: str) -> str:
    """Return the text of a list item after its dash."""
    line = f"{flow(value)}\n"
    if len(indent) + 2 + len(line) <= WIDTH + 1 or not isinstance(value, dict | tuple | list):
        return line
    return _block(value, indent + "  ").removeprefix(indent + "  ")


def flow(value: object) -> str:
    """Return `value` on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_scalar(k)}: {flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, tuple | list):
        return "[" + ", ".join(map(flow, value)) + "]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    """Return a scalar that reads back as the same value of the same type."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        digits, exponent, power = repr(float(value)).partition("e")
        # In YAML 1.1 1e-05 is text, but 1.0e-05 is a number.
        return digits + (".0" if exponent and "." not in digits else "") + exponent + power
    if isinstance(value, int):
        return str(value)
    if _PLAIN.fullmatch(value) and scalar(value) == value:
        return value
    return _quoted(value)


def _quoted(text: str) -> str:
    """Return `text` in double quotes, with YAML's escapes for unprintable characters."""
    escaped = (
        json.dumps(c, ensure_ascii=False)[1:-1]
        if c.isprintable() or c in "\n\t"
        else f"\\U{ord(c):08x}"
        for c in text
    )
    return '"' + "".join(escaped) + '"'
