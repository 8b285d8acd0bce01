"""What a feature of a case is: where a case has it, by key path."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple


class Place(NamedTuple):
    """A place in a case where it has a feature."""

    path: tuple[str | int, ...]
    """Keys down to what asks for it."""
    name: str = ""
    """Of the body, face or other thing that has it, for messages."""
    owner: str = ""
    """The body or face that it is about, where only features of the same one exclude each other."""
    axis: str = ""
    """The direction that it is about, likewise."""
    kind: str = ""
    """Name of a body's law."""


class Feature(NamedTuple):
    """What a case may have: its name in tables, and where a case with these parts has it."""

    words: str
    find: Callable[..., Iterator[Place]]
    """Its parameters are named as the parts of the case that it needs."""

    def places(self, parts: Mapping[str, Any]) -> list[Place]:
        """Return where a case has it; nowhere if the parts that it needs are not all there."""
        needs = _names(self.find)
        return [*self.find(**{n: parts[n] for n in needs})] if needs <= parts.keys() else []


@cache
def _names(find: Callable[..., Any]) -> frozenset[str]:
    """Names of a function's parameters."""
    return frozenset(inspect.signature(find).parameters)


def named(
    words: str,
    section: str,
    key: str = "",
    has: Callable[[Any], Any] = lambda entry: True,
    owner: Callable[[Any], str] | None = None,
) -> Feature:
    """Feature of the entries of a section; an entry's owner is its name, if no other is given."""
    head = "bodies" if section.endswith(("body", "bodies")) else section

    def find(**parts: Any) -> Iterator[Place]:
        for name, entry in parts[section].items():
            if has(entry):
                whose = owner(entry) if owner else name
                axis = name[0] if section == "boundaries" else ""
                yield Place((head, name, key) if key else (head, name), whose, whose, axis)

    return Feature(words, _signed(find, [section]))


def of_bodies(words: str, key: str, has: Callable[[Any, Any], Any]) -> Feature:
    """Feature of bodies of a known material, by body and law; a `material` has its own name."""

    def find(bodies: Any, materials: Any) -> Iterator[Place]:
        for name, body in bodies.items():
            if body.material in materials and has(body, materials[body.material]):
                text = body.material if key == "material" else name
                kind = getattr(materials[body.material], "model", "a law of its own")
                yield Place(("bodies", name, key), text, name, kind=kind)

    return Feature(words, find)


def of_key(words: str, path: str, has: Callable[[Any], Any], axis: str = "") -> Feature:
    """Feature of a part of the case, whose name begins the `path`."""
    keys = path.split(".")
    part = keys[0].replace("-", "_")

    def find(**parts: Any) -> Iterator[Place]:
        if has(value := parts[part]):
            yield Place((*keys,), getattr(value, "name", f"{value}"), axis=axis)

    return Feature(words, _signed(find, [part]))


def _signed(find: Callable[..., Iterator[Place]], names: list[str]) -> Callable[..., Any]:
    """Return a function that says by what names its parameters are."""
    kind = inspect.Parameter.KEYWORD_ONLY
    find.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [inspect.Parameter(name, kind) for name in names]
    )
    return find
