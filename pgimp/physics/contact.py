"""Contact of bodies: the entries in the case, and the law of each pair."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from pgimp.jit.kernel import kernel
from pgimp.schema.base import Model, Name, Number
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems

#: Laws, as kernels number them.
LAWS = ("ignore", "tied", "friction")
IGNORE, TIED, FRICTION = range(3)

Coefficient = Annotated[Number, Field(ge=0.0)]
Strength = Annotated[Number, Field(ge=0.0)]


class Friction(Model):
    """Coulomb friction whose coefficient falls once surfaces slide."""

    static: Coefficient = Field(description="coefficient until surfaces slide [1]")
    kinetic: Coefficient = Field(description="coefficient while they do, at most the static [1]")

    @model_validator(mode="after")
    def _check_order(self) -> Friction:
        if self.kinetic > self.static:
            text = f"is above the static coefficient, {self.static:.15g}"
            raise_problems("friction", [Problem(("kinetic",), text)])
        return self


AnyFriction = Annotated[
    float | Friction,
    Either("a coefficient or {static: ..., kinetic: ...}", {float: Coefficient, dict: Friction}),
]


@kernel
def sliding_part(static, kinetic, cohesion, pressed, sticking):
    """Part of the tangential impulse of sticking that Coulomb's law transmits; 1 where it sticks.

    Parameters
    ----------
    static, kinetic : float
        Coefficients of friction.
    cohesion : float
        Greatest tangential impulse without pressure.
    pressed : float
        The normal impulse, at least 0.
    sticking : float
        The tangential impulse that would stop all slip.
    """
    if sticking > static * pressed + cohesion:
        return (kinetic * pressed + cohesion) / sticking
    return 1.0


def coefficients(friction: float | Friction) -> tuple[float, float]:
    """Static and kinetic coefficient."""
    if isinstance(friction, Friction):
        return friction.static, friction.kinetic
    return friction, friction


class Adhesion(Model):
    """Cohesion of surfaces that touch, the same until they are apart (Dugdale's law)."""

    normal: Strength = Field(default=0.0, description="stress at which they part [force/area]")
    shear: Strength = Field(
        default=0.0,
        description="stress at which they slide, besides friction; under tension t less by the "
        "factor sqrt(1 - (t/normal)^2) [force/area]",
    )
    reach: Annotated[Number, Field(gt=0.0)] = Field(
        description="gap up to which they hold; `normal` times this is the energy that it takes "
        "to part them, per area [length]"
    )

    @model_validator(mode="after")
    def _check(self) -> Adhesion:
        if self.normal == self.shear == 0.0:
            text = "expected a stress above 0 here or as `shear`; without adhesion leave it out"
            raise_problems("adhesion", [Problem(("normal",), text)])
        return self


class ContactEntry(Model):
    """What happens where bodies meet."""

    bodies: Annotated[
        str | tuple[str, ...],
        Either(
            "all or a list of bodies",
            {str: Literal["all"], tuple: tuple[Name, ...]},
        ),
    ] = Field(
        description="names of the bodies, each pair of which this is for; all: every pair that "
        "no other entry names"
    )
    law: Literal["friction", "tied", "ignore"] = Field(
        default="friction",
        description="friction: they cannot penetrate, slide under Coulomb's law, and part freely; "
        "tied: they move as one body where they share vertices of the grid, from the beginning or "
        "from when they meet; ignore: they pass through each other",
    )
    friction: AnyFriction = Field(default=0.0, description="coefficient of Coulomb's friction [1]")
    adhesion: Adhesion | None = Field(
        default=None, description="how they hold each other where they touch; null: not at all"
    )

    @model_validator(mode="after")
    def _check(self) -> ContactEntry:
        for key, given in (("friction", self.friction != 0.0), ("adhesion", self.adhesion)):
            if self.law != "friction" and given:
                text = f"bodies that are under the law '{self.law}' have no {key}; leave it out"
                raise_problems("contact", [Problem((key,), text)])
        if isinstance(self.bodies, tuple) and len(set(self.bodies)) < max(2, len(self.bodies)):
            text = "expected the names of two bodies or more, each once"
            raise_problems("contact", [Problem(("bodies",), text)])
        return self

    @property
    def name(self) -> str:
        """What the columns of the history call it."""
        return self.bodies if isinstance(self.bodies, str) else "+".join(self.bodies)

    def pairs(self) -> Iterator[tuple[str, str]]:
        """Names of the pairs, in the order of the entry; none for all."""
        return combinations(self.bodies if isinstance(self.bodies, tuple) else (), 2)


class Pairs(NamedTuple):
    """The law of each pair of bodies, for the kernels.

    Attributes
    ----------
    entry : (bodies, bodies) int64
        Number of the pair's entry, from 1, in the row of the body that has the smaller number;
        negative if the entry names the other one first. 0: bodies that pass through each other.
    law : (entries + 1,) int64
        `TIED` or `FRICTION`; the last one is for pairs without an entry, which are tied.
    coefficient : (entries + 1, 2) float64
        Static and kinetic coefficient of friction.
    adhesion : (entries + 1, 3) float64
        Normal and shear strength, and the gap up to which they hold; 0 where there is none.
    """

    entry: np.ndarray
    law: np.ndarray
    coefficient: np.ndarray
    adhesion: np.ndarray

    @classmethod
    def of(cls, entries: Sequence[ContactEntry], bodies: Sequence[str]) -> Pairs:
        """Find the law of each pair; an entry for all is for those that no other one names."""
        count = len(bodies)
        entry = np.full((count, count), len(entries) + 1, np.int64)
        number = {name: i for i, name in enumerate(bodies)}
        for i, each in enumerate(entries, 1):
            if each.bodies == "all":
                entry[np.triu_indices(count, 1)] = i
        for i, each in enumerate(entries, 1):
            for first, second in each.pairs():
                a, b = number[first], number[second]
                entry[min(a, b), max(a, b)] = i if a < b else -i
        law = np.array([*(LAWS.index(each.law) for each in entries), TIED], np.int64)
        entry[law[np.abs(entry) - 1] == IGNORE] = 0
        pairs = [coefficients(given.friction) for given in entries]
        coefficient = np.array([*pairs, (0.0, 0.0)], float)
        held = [each.adhesion for each in entries]
        adhesion = [(each.normal, each.shear, each.reach) if each else (0.0,) * 3 for each in held]
        return cls(entry, law, coefficient, np.array([*adhesion, (0.0,) * 3], float))

    def ties(self, count: int) -> bool:
        """Whether of the first `count` bodies any are tied."""
        pairs = np.abs(self.entry[np.triu_indices(count, 1)])
        return bool((self.law[pairs[pairs > 0] - 1] == TIED).any())


def sharing(case: Any) -> np.ndarray:
    """Return which pairs of the bodies with particles no entry is for, (n, n); i < j counts."""
    entry = Pairs.of(case.contact, [*case.bodies, *case.rigid_bodies]).entry
    n = len(case.bodies)
    return np.abs(entry[:n, :n]) > len(case.contact)
