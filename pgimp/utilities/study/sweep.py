"""Runs of a sweep: every choice of one entry with every choice of the others."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple

from pgimp.case.writer import flow
from pgimp.schema.messages import shorten
from pgimp.utilities.study.schema import CASE, Study, is_named

LONGEST_NAME = 100
"""Characters of a folder's name, with which all file systems can do."""

Path = tuple[str | int, ...]


class Change(NamedTuple):
    """A changed value of the case in a run."""

    key: str
    """Keys and list indices joined by dots."""
    value: object
    path: Path
    """Its path in the study file."""

    @property
    def option(self) -> str:
        """Text for ``--set``."""
        return f"{self.key}={flow(self.value)}"


class Choice(NamedTuple):
    """A choice of an entry."""

    label: str
    changes: tuple[Change, ...]


class Variant(NamedTuple):
    """The changes of one run."""

    name: str
    """Unlike that of any other run, and fit for a folder."""
    choices: tuple[int, ...]
    """Its choice of each entry."""
    labels: tuple[str, ...]
    """The name of each choice."""
    changes: tuple[Change, ...]
    """All changes in their order, those of ``set`` first."""


def variants(study: Study) -> list[Variant]:
    """Return the runs of a study; the choices of the last entry change first."""
    fixed = tuple(Change(key, value, ("set", key)) for key, value in study.set.items())
    entries = [_choices(entry, number) for number, entry in enumerate(study.sweep)]
    found: list[Variant] = []
    taken: set[str] = set()
    for numbers in product(*(range(len(choices)) for choices in entries)):
        chosen = [choices[number] for choices, number in zip(entries, numbers, strict=True)]
        labels = tuple(choice.label for choice in chosen)
        changes = fixed + tuple(change for choice in chosen for change in choice.changes)
        found.append(Variant(_folder(labels, taken), numbers, labels, changes))
    return found


def _choices(entry: Mapping[str, Any], number: int) -> list[Choice]:
    """Return the choices of an entry of the sweep."""
    if is_named(entry):
        return [
            Choice(
                name,
                tuple(Change(k, value, ("sweep", number, name, k)) for k, value in content.items()),
            )
            for name, content in entry.items()
        ]
    count = len(next(iter(entry.values())))
    sets = [
        tuple(Change(key, list_[i], ("sweep", number, key, i)) for key, list_ in entry.items())
        for i in range(count)
    ]
    return [Choice(label, changes) for label, changes in zip(_labels(sets), sets, strict=True)]


def _labels(sets: list[tuple[Change, ...]]) -> list[str]:
    """Labels that distinguish the choices by as few of their values as possible."""
    leaves = [
        {key: text for change in changes for key, text in _leaves(change.key, change.value)}
        for changes in sets
    ]
    keys = list(dict.fromkeys(key for one in leaves for key in one))
    varied = [key for key in keys if len({one.get(key) for one in leaves}) > 1]
    shown: list[str] = []
    labels = [""] * len(sets)
    for key in varied or keys[:1]:
        more = [*shown, key]
        longer = [", ".join(one[k] for k in more if k in one) for one in leaves]
        if len(set(longer)) > len(set(labels)) or not shown:
            shown, labels = more, longer
    twice = len(set(labels)) < len(labels)
    return [f"{label} #{i + 1}" if twice else label for i, label in enumerate(labels)]


def _leaves(key: str, value: object) -> Iterator[tuple[str, str]]:
    """Yield the parts of a value, by key, as short texts."""
    if isinstance(value, dict) and value:
        for name, part in value.items():
            yield from _leaves(f"{key}.{name}", part)
    elif isinstance(value, str):
        text = value.rpartition("/")[2].removesuffix(".yaml") if key == CASE else value
        yield key, shorten(text)
    else:
        yield key, f"{key.rpartition('.')[2]} {short(value)}"


def short(value: object) -> str:
    """Return a value in a short form: 0.5 for [0.5]."""
    if isinstance(value, list | tuple):
        parts = [short(part) for part in value]
        if len(parts) == 1 and not isinstance(value[0], list | tuple):
            return parts[0]
        if not any(isinstance(part, list | tuple | dict) for part in value):
            return "x".join(parts[:1] if len(set(parts)) == 1 else parts)
    if isinstance(value, float):
        return f"{value:.12g}"
    return value if isinstance(value, str) else shorten(flow(value))


def _folder(labels: tuple[str, ...], taken: set[str]) -> str:
    """Return a name for the run's folder, and add it to `taken`."""
    parts = [re.sub(r"[^A-Za-z0-9.+-]+", "-", label).strip("-.") for label in labels]
    name = plain = "_".join(part for part in parts if part)[:LONGEST_NAME].strip("-._") or "run"
    number = 1
    while name.casefold() in taken:
        number += 1
        name = f"{plain}-{number}"
    taken.add(name.casefold())
    return name
