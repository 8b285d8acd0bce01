"""Entries of materials with parameters that vary in space.

The entry of such a material has typical numbers in place of varying ones, so code that does not
depend on position needs no change. At a position the entry is another one with the local numbers
(`Varying.maker`), checked as if a case had them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import (
    ModelWrapValidatorHandler,
    PrivateAttr,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)

from pgimp.errors import UsageError
from pgimp.physics.fields import PREFIX
from pgimp.physics.variation import NoValueError, Path, Places, Variation
from pgimp.physics.variation.find import Variations, names_of, replaced, split, value_at
from pgimp.schema.base import Model
from pgimp.schema.dispatch import plain
from pgimp.schema.problems import Problem, raise_problems

#: Guesses for a parameter from an unread file, to find a valid entry; see `typical_of`.
_GUESSES = (1.0, 0.25, 1e3, 1e6, 1e9, 1e-3, 10.0, 1e-6, 30.0, 0.0)
#: Most attempts to find a valid entry.
_MOST_GUESSES = 2000
#: Most numbers of a table that are validated one by one when a case is read.
_MOST_TRIED = 2000
#: Beginning of a layer that contains everything, in any units.
_FAR_AWAY = -1e140


E = TypeVar("E")


def typical_of(
    data: Mapping[str, object], variations: Variations, make: Callable[[dict[str, object]], E]
) -> E:
    """Return an entry with typical numbers in place of variations; all known values are validated.

    For parameters from an unread file, a guess that gives a valid entry is used.

    Parameters
    ----------
    data : mapping
        The material as in the case.
    variations : dict
        Its variations by key.
    make : callable
        Makes an entry of numbers; raises a ValidationError if they are invalid.

    Raises
    ------
    ValidationError
        For all errors in the material or in the numbers of its variations.
    """
    entry, best = None, None
    guesses = itertools.product(*map(_guesses, variations.values()))
    for guess in itertools.islice(guesses, _MOST_GUESSES):
        typical = dict(zip(variations, guess, strict=True))
        try:
            entry = make(replaced(data, typical))
            break
        except ValidationError as error:
            if best is None or error.error_count() < best.error_count():
                best = error
    if entry is None:
        assert best is not None
        raise best
    problems: list[Problem] = []
    for path, each in variations.items():
        for tail, value in _some(each.known()):
            try:
                make(replaced(data, typical | {path: value}))
            except ValidationError as error:
                problems.append(Problem((*path, *tail), first_text(error)))
    raise_problems("material", problems, data)
    return entry


def _guesses(variation: Variation) -> list[float]:
    """Candidate numbers, the typical one first; another may be valid if it is not."""
    if (typical := variation.typical) is None:
        return [*_GUESSES]
    known = [value for _, value in variation.known()]
    return [typical, *known[:: max(1, len(known) // len(_GUESSES))]]


def _some(known: Sequence[tuple[Path, float]]) -> Iterable[tuple[Path, float]]:
    return known[:: max(1, -(-len(known) // _MOST_TRIED))]


def first_text(error: ValidationError) -> str:
    """First error as one sentence."""
    first = error.errors(include_url=False)[0]
    return first.get("ctx", {}).get("text") or first["msg"]


class Varying(Model):
    """Base of entries of which numbers may vary in space."""

    _variations: Variations = PrivateAttr(default_factory=dict)

    @model_validator(mode="wrap")
    @classmethod
    def _take_variations(cls, data: object, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Replace variations in space by typical numbers, and store the variations."""
        if not isinstance(data, dict) or not any(
            isinstance(value, Mapping | Variation) for value in data.values()
        ):
            return handler(data)
        spelled, variations = split(cls, data)
        if not variations:
            return handler(data)
        entry = typical_of(spelled, variations, handler)
        entry._variations = variations
        return entry

    @model_serializer(mode="wrap")
    def _write(
        self, handler: SerializerFunctionWrapHandler, info: SerializationInfo
    ) -> dict[str, object]:
        """Write variations as in the case."""
        data = handler(self)
        if not self._variations:
            return data
        keys = (lambda path: path) if info.by_alias else partial(names_of, type(self))
        return replaced(data, {keys(path): plain(each) for path, each in self._variations.items()})

    @property
    def variations(self) -> Variations:
        """Variations in space, by key; the entry has typical numbers in their place."""
        return self._variations

    def typical(self, key: str) -> float:
        """Return a number, a typical one if it varies; files should be read before."""
        variation = self._variations.get((key,))
        found = None if variation is None else variation.typical
        return value_at(self, (key,)) if found is None else found

    def maker(self) -> Callable[[Mapping[tuple[str, ...], float]], Self]:
        """Return a function that gives the same material with numbers in place of variations.

        It takes numbers by key; missing ones are typical. It raises a ValidationError if they are
        not allowed.
        """
        typical = {path: value_at(self, path) for path in self._variations}
        data, kind = replaced(self.model_dump(by_alias=True), typical), type(self)
        return lambda values: kind.model_validate(replaced(data, values))

    def uniform(self) -> dict[str, object]:
        """Return the entry with uniform parameters in varying form, a single layer each.

        For particles that still carry columns of varying parameters.
        """
        layers = {}
        for path, variation in self._variations.items():
            typical = variation.typical
            value = value_at(self, path) if typical is None else typical
            layers[path] = {"over": "x", "layers": ((_FAR_AWAY, value),)}
        return replaced(self.model_dump(by_alias=True), layers)

    def at(self, x: ArrayLike) -> Self:
        """Return the material at a position.

        Parameters
        ----------
        x : (D,) array_like of float
            Initial position.

        Raises
        ------
        UsageError
            If a parameter is a column of particles, or has no value at the position.
        """
        position = np.array([x], float)
        values = {}
        for path, variation in self._variations.items():
            key = ".".join(path)
            if columns := [each for part in variation.parts() for each in part.columns]:
                raise UsageError(
                    f"{key} is the column {', '.join(columns)} of particles, and no place "
                    f"has it; give a number, --set materials.NAME.{key}=.."
                )
            problem = next(iter(variation.problems(position.shape[1])), None)
            try:
                if problem:
                    raise UsageError(f"{key}: {problem.text}")
                values[path] = float(variation.values(Places(position, {}))[0])
            except NoValueError as error:
                raise UsageError(f"{key}: the place {error}") from None
        try:
            return self.maker()(values)
        except ValidationError as error:
            raise UsageError(f"at this place {first_text(error)}") from None


def field_of(path: Sequence[str]) -> str:
    """Name of a parameter's field."""
    return PREFIX + "-".join(path).replace("_", "-")
