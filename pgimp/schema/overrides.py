"""Overrides of single values of a case: ``--set time.end=3.0``, in Python ``{"time.end": 3.0}``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any

from pydantic import BaseModel

from pgimp.errors import CaseError
from pgimp.schema.dispatch import given
from pgimp.schema.document import DEEPEST, Document, Path, parse
from pgimp.schema.messages import describe, dotted, shorten
from pgimp.schema.words.renamed import new_path
from pgimp.schema.words.renew import renew

Overrides = Sequence[str] | Mapping[str, object]
"""``["time.end=3.0"]``, as on the command line, or ``{"time.end": 3.0}``."""


def apply(document: Document, overrides: Overrides) -> None:
    """Write every override into `document`, in order; later ones take precedence.

    Missing keys are created; validation refuses unknown ones.

    Parameters
    ----------
    document : Document
        The case; changed in place.
    overrides : sequence of str, or mapping
        Each ``key.path=value``: keys and list indices (from 0) joined by dots, and YAML. Or values
        by such paths.

    Raises
    ------
    CaseError
        When an override has no key or value, or its path leads nowhere.
    """
    if isinstance(overrides, str):
        raise CaseError(f"expected a list or a mapping of overrides, got the text '{overrides}'")
    if isinstance(overrides, Mapping):
        for key, value in overrides.items():
            path = str(key).strip().split(".")
            label = f"override of {shorten(str(key))}"
            if not all(path):
                raise CaseError(f"{label}: expected a path of keys, such as time.end")
            change(document, path, as_data(value, label), label)
        return
    for override in overrides:
        label = f"--set {shorten(override)}"
        written, equals, text = override.partition("=")
        path = written.strip().split(".")
        if not equals or not all(path):
            raise CaseError(f"{label}: expected KEY.PATH=VALUE, such as --set time.end=3.0")
        change(document, path, parse(text, label).data, label)


def change(document: Document, keys: list[str], value: object, label: str) -> None:
    """Write `value` at the end of the path `keys`; `label` is its location in messages.

    Raises
    ------
    CaseError
        When the path leads nowhere, or deeper than any case.
    """
    if len(keys) > DEEPEST:
        raise CaseError(f"{label}: a path of {len(keys):,} keys is too long (at most {DEEPEST})")
    written = _write(document.data, new_path(keys), value, label)
    for paths in (document.locations, document.old_keys, document.old_values):
        for known in [known for known in paths if known[: len(written)] == written]:
            del paths[known]
    document.locations[written] = label
    renew(document, label)


def _write(data: Any, keys: list[str], value: Any, label: str) -> Path:
    """Write `value` at `keys` and return the path of the topmost new part."""
    path: Path = ()
    new: Path | None = None
    for position, key in enumerate(keys):
        part = _part(data, key, path, label)
        path = (*path, part)
        if position == len(keys) - 1:
            data[part] = value
        else:
            if isinstance(data, dict) and data.get(part) is None:
                data[part] = {}
                new = new or path
            data = data[part]
    return new or path


def _part(data: object, key: str, path: Path, label: str) -> str | int:
    """Return `key` as the key or the list index of `data`."""
    where = dotted(path)
    if isinstance(data, dict):
        return key
    if isinstance(data, list):
        if key.isdecimal() and key.isascii() and len(key) < 10 and int(key) < len(data):
            return int(key)
        last = len(data) - 1
        raise CaseError(
            f"{label}: {where} is a list with the entries 0 to {last}, not '{shorten(key)}'"
        )
    raise CaseError(f"{label}: {where} is {describe(data)} and has no key '{shorten(key)}'")


def as_data(value: object, label: str, depth: int = 0) -> object:
    """Return a Python value in the form of a case file.

    Parameters
    ----------
    value : object
        Numbers, text, lists and mappings, also of NumPy, and parts of a case.
    label : str
        Its location in messages.
    depth : int
        Depth of nesting.

    Raises
    ------
    CaseError
        If it is nested too deeply, or a key is no text.
    """
    if depth > DEEPEST:
        raise CaseError(f"{label}: nested deeper than {DEEPEST} levels")
    if isinstance(value, BaseModel):
        value = given(value)
    elif isinstance(value, PathLike):
        value = fspath(value)
    elif hasattr(value, "tolist"):  # a number or an array of NumPy
        value = value.tolist()
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise CaseError(f"{label}: expected text as the key, got {describe(key)}")
        return {str(key): as_data(part, label, depth + 1) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [as_data(part, label, depth + 1) for part in value]
    return value
