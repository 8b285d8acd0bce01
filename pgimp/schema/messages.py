"""Errors from pydantic, reworded for authors of case files."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from itertools import islice
from typing import Any

from pydantic import BaseModel
from pydantic_core import ErrorDetails, ValidationError

from pgimp.schema.pages import page
from pgimp.schema.problems import ABSENT, KIND, MOST_PROBLEMS, Problem
from pgimp.schema.words import lookalikes
from pgimp.schema.words.renamed import FORMER
from pgimp.schema.words.trades import beyond, meant_by

_NUMBER_LIKE = re.compile(r"[-+]?(\d[\d_]*(\.\d*)?|\.\d+)([eEdD][-+]?\d+)?")
_COMMA = re.compile(r"([-+]?\d+),(\d+([eE][-+]?\d+)?)")
_DIGITS = re.compile(r"\d+([eE][-+]?\d+)?")
_COLON = re.compile(r"([A-Za-z][A-Za-z0-9_-]*):(\S.*)")


def describe(value: object) -> str:
    """Describe a value of a case: ``the text 'abc'``, ``a list of 3``, ``nothing``."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return _number(value)
    if isinstance(value, str):
        return f"the text '{shorten(value)}'"
    if isinstance(value, Mapping):
        return f"a mapping with the keys {_listed(value)}" if value else "{}"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}" if value else "an empty list"
    return f"a value of type {type(value).__name__}"


def _number(value: float) -> str:
    if isinstance(value, int) and abs(value) >= 10**17:
        return f"about 1e{len(str(abs(value))) - 1}" if abs(value) < 10**300 else "a huge number"
    return f"{value:.15g}"


def shorten(text: str, width: int = 60) -> str:
    """Return `text` on one printable line of at most `width` characters."""
    line = "".join(
        c
        if c.isprintable()
        else " "
        if c.isspace()
        else c.encode("unicode_escape", "backslashreplace").decode()
        for c in text[: 4 * width]
    )
    return line if len(line) <= width else line[: width - 3] + "..."


def dotted(path: Iterable[str | int]) -> str:
    """Return keys and list indices joined by dots, on one printable line."""
    return ".".join(shorten(str(part)) for part in path)


def _listed(names: Iterable[object], most: int = 30) -> str:
    """Return names joined by commas, at most `most`."""
    shown = [shorten(str(name)) for name in islice(names, most + 1)]
    return ", ".join(shown[:most]) + (", ..." if len(shown) > most else "")


def got(value: object) -> str:
    """Describe a wrong value, with a hint at the usual mistakes."""
    text = f"got {describe(value)}"
    if isinstance(value, str):
        usual = lookalikes.plain(value)
        if usual != value and _NUMBER_LIKE.fullmatch(usual):
            strange = lookalikes.named(lookalikes.within(value))
            text += f", which has {strange}; write the number as {shorten(usual)}"
        elif _NUMBER_LIKE.fullmatch(value):
            plain = re.sub("[dD]", "e", value.replace("_", ""))
            text += f"; write the number as {shorten(_exponent(plain))}, without quotes"
        elif match := _COMMA.fullmatch(value):
            text += f"; a decimal point, not a comma: {shorten(f'{match[1]}.{match[2]}')}"
        elif match := _COLON.fullmatch(value):
            parts = f"{shorten(match[1])}: {shorten(match[2])}"
            text += f"; a space is missing after the colon: '{parts}'"
    return text


def _exponent(number: str) -> str:
    """Return a number as all readers of YAML take it: PyYAML wants a point and a sign."""
    mantissa, letter, exponent = re.split("([eE]|$)", number, maxsplit=1)
    if not letter:
        return number
    point = "" if "." in mantissa else ".0"
    sign = "" if exponent[0] in "+-" else "+"
    return f"{mantissa}{point}{letter}{sign}{exponent}"


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name nearest to `name`; it may be like an older word for it."""
    by_fold = {item.casefold().replace("_", "-"): item for item in known}
    by_fold = {old: new for old, new in FORMER.items() if new in by_fold} | by_fold
    found = difflib.get_close_matches(name[:100].casefold().replace("_", "-"), by_fold, 1, 0.6)
    return by_fold[found[0]] if found else None


def unknown(what: str, name: str, known: Iterable[str], label: str = "known") -> str:
    """Message: `name` is unknown; what is meant, or why there is none, and all known names."""
    names = sorted(known)
    text = f"unknown {what}" if what == "key" else f"unknown {what} '{shorten(name)}'"
    match = _COLON.fullmatch(name)
    if what == "key" and match and match[1] in names:
        return f"{text}; a space is missing after the colon: '{match[1]}: {shorten(match[2])}'"
    if meant := meant_by(name, names):
        text += f"; it is {' or '.join(meant)} here;"
    elif why := beyond(name):
        text += f": not in pgimp, where {why} ({page('limits.md')});"
    elif guess := nearest(name, names):
        text += f"; did you mean '{shorten(guess)}'?"
    else:
        text += ";"
    return f"{text} {label}: {_listed(names) if names else 'none'}"


def keys_of(model: type[BaseModel]) -> dict[str, str]:
    """Return the descriptions of the keys of `model`, by key."""
    return {
        field.alias or name: field.description or "" for name, field in model.model_fields.items()
    }


def explain(model: type[BaseModel], error: ValidationError, value: object) -> list[Problem]:
    """Turn pydantic's errors in a value for `model` into readable problems.

    Parameters
    ----------
    model : type of BaseModel
        The validated model; its fields are the known keys.
    error : ValidationError
        Error of its validation. Problems of nested models have their own text.
    value : Any
        The validated value.
    """
    keys = keys_of(model)
    details = error.errors(include_url=False)[:MOST_PROBLEMS]
    meant = {
        key
        for item in details
        if item["type"] == "extra_forbidden" and len(item["loc"]) == 1
        for name in [str(item["loc"][0])]
        for key in (*meant_by(name, keys), nearest(name, keys))
    }
    own: list[Problem] = []
    foreign: dict[tuple[str | int, ...], list[str]] = {}
    for item in details:
        kind, loc = item["type"], item["loc"]
        absent = kind in ("missing", ABSENT)
        if kind == "missing" and len(loc) == 1 and loc[0] in meant:
            continue
        path = _path(loc, value, absent)
        if kind in (KIND, ABSENT) or absent:
            own.append(Problem(path, _text(item, keys), absent))
        else:
            foreign.setdefault(path, []).append(_text(item, keys))
    # Branches of a union that the value does not begin to fit are no help.
    around = {
        path[:length]
        for path in (*(item.path for item in own), *foreign)
        for length in range(len(path))
    }
    own += [Problem(path, _either(texts)) for path, texts in foreign.items() if path not in around]
    return own


def _either(texts: list[str]) -> str:
    """Join the expectations of a union's branches: ``expected a number or a list, got ...``."""
    parts = [text.partition(", got ") for text in dict.fromkeys(texts)]
    if len(parts) > 1 and all(head.startswith("expected ") for head, _, _ in parts):
        heads = " or ".join(head.removeprefix("expected ") for head, _, _ in parts)
        return f"expected {heads}, got {parts[0][2]}"
    return "; or ".join(dict.fromkeys(texts))


def _path(loc: tuple[str | int, ...], value: Any, absent: bool) -> tuple[str | int, ...]:
    """Return the keys and indices of `loc` without pydantic's additions: branches of unions.

    With `absent`, the last part may be a missing key.
    """
    path: list[str | int] = []
    for position, part in enumerate(loc):
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            if absent and position == len(loc) - 1:
                path.append(part)
        else:
            path.append(part)
    return tuple(path)


def _text(item: ErrorDetails, keys: Mapping[str, str]) -> str:
    """Return the sentence for one error; `keys` are the keys of its model."""
    kind, loc, value, context = item["type"], item["loc"], item["input"], item.get("ctx", {})
    if kind in (KIND, ABSENT):
        return context["text"]
    if kind == "extra_forbidden":
        if value is None and _DIGITS.fullmatch(str(loc[-1])):
            return (
                f"unknown key '{shorten(str(loc[-1]))}'; a number takes a decimal point, not a "
                f"comma: 0.{shorten(str(loc[-1]))}, where 0 stands for what is before the comma"
            )
        return unknown("key", str(loc[-1]), keys, "allowed")
    if kind == "missing":
        meaning = keys.get(str(loc[-1]), "").rstrip(".") if len(loc) == 1 else ""
        return f"missing ({meaning})" if meaning else "missing"
    if kind in ("value_error", "assertion_error"):
        return str(context.get("error", item["msg"]))
    if kind in _BOUNDS:
        relation, key = _BOUNDS[kind]
        return f"must be {relation} {_plain(context[key])}, {got(value)}"
    if kind in ("too_short", "too_long"):
        least = kind == "too_short"
        limit = context["min_length" if least else "max_length"]
        entries = "entry" if limit == 1 else "entries"
        text = f"expected at {'least' if least else 'most'} {limit} {entries}, {got(value)}"
        if not least and all(isinstance(entry, int) for entry in value):
            text += "; are there decimal commas? Numbers take a point, 0.5"
        return text
    if kind == "string_too_short":
        return "expected text, got none"
    if kind == "string_too_long":
        return f"expected at most {context['max_length']} characters, got {len(value):,}"
    if kind == "string_type" and isinstance(value, bool | int | float):
        return f"expected text, got {describe(value)}; text that looks like this needs quotes"
    if kind in _EXPECTED:
        return f"expected {_EXPECTED[kind]}, {got(value)}"
    if kind in ("literal_error", "enum"):
        expected = context["expected"].replace(" or ", ", ")
        if isinstance(value, str):
            return unknown("value", value, [name.strip("'") for name in expected.split(", ")])
        return f"expected one of {expected}, {got(value)}"
    if kind == "string_pattern_mismatch":
        rule = "a name starts with a letter; up to 99 letters, digits, - and _ may follow"
        return f"{rule}; got {describe(value)}"
    return f"not a value that may stand here, {got(value)}"


def _plain(limit: object) -> str:
    return f"{limit:g}" if isinstance(limit, float) else str(limit)


_BOUNDS = {
    "greater_than": ("above", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("below", "lt"),
    "less_than_equal": ("at most", "le"),
}

_EXPECTED = {
    "float_type": "a number",
    "float_parsing": "a number",
    "finite_number": "a finite number",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing_size": "a whole number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "string_type": "text",
    "none_required": "nothing",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "model_attributes_type": "a mapping of keys to values",
}
