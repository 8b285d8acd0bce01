"""Contact entries of the case, and the law of each pair of bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Annotated, Any, Literal, NamedTuple, get_type_hints

import numpy as np
from pydantic import Field, model_validator

from pgimp.physics.contact import LAWS
from pgimp.physics.contact.base import IGNORE, TIED, UNILATERAL, ContactLaw
from pgimp.physics.contact.friction import AnyFriction
from pgimp.schema.base import Model, Name, Number
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.registries import ByWord, name_of

Strength = Annotated[Number, Field(ge=0.0)]


class Adhesion(Model):
    """Cohesion of surfaces that touch, the same until they are apart (Dugdale's law)."""

    normal: Strength = Field(default=0.0, description="stress at which they part [force/area]")
    shear: Strength = Field(
        default=0.0,
        description="stress at which they slide, besides friction; under tension t less by the "
        "factor sqrt(1 - (t/normal)^2) [force/area]",
    )
    reach: Annotated[Number, Field(gt=0.0)] = Field(
        alias="range",
        description="gap up to which they hold; `normal` times this is the energy that it takes "
        "to part them, per area [length]",
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
        Either("all or a list of bodies", {str: Literal["all"], tuple: tuple[Name, ...]}),
    ] = Field(
        description="names of the bodies, each pair of which this is for; all: every pair that "
        "no other entry names"
    )
    law: Annotated[ContactLaw, ByWord(lambda: LAWS, "law of contact")] = Field(
        default="friction", validate_default=True, description="how they act on each other"
    )
    friction: AnyFriction = Field(default=0.0, description="coefficient of Coulomb's friction [1]")
    adhesion: Adhesion | None = Field(
        default=None, description="how they hold each other where they touch; null: not at all"
    )
    restitution: Annotated[Number, Field(ge=0.0, le=1.0)] = Field(
        default=0.0,
        description="coefficient of restitution of rigid bodies: their speed after an impact over "
        "that before, along the normal; bodies of a material rebound by their waves [1]",
    )
    itself: bool = Field(
        default=False,
        alias="self",
        description="whether each of the bodies also meets itself, where it folds; bodies exact "
        "to their surface, in the initial configuration",
    )

    @model_validator(mode="after")
    def _check(self) -> ContactEntry:
        for key, given in (
            ("friction", self.friction != 0.0),
            ("adhesion", self.adhesion),
            ("restitution", self.restitution),
        ):
            if given and key not in self.law.keys:
                name = name_of(self.law, LAWS)
                text = f"bodies that are under the law '{name}' have no {key}; leave it out"
                raise_problems("contact", [Problem((key,), text)])
        least = 1 if self.itself else 2
        if isinstance(self.bodies, tuple) and len(set(self.bodies)) < max(least, len(self.bodies)):
            text = "expected the names of two bodies or more, each once (one with `self: true`)"
            raise_problems("contact", [Problem(("bodies",), text)])
        return self

    @property
    def name(self) -> str:
        """Name in the columns of the history."""
        return self.bodies if isinstance(self.bodies, str) else "+".join(self.bodies)

    def pairs(self) -> Iterator[tuple[str, str]]:
        """Names of the pairs, in the order of the entry; none if the entry is for all."""
        return combinations(self.bodies if isinstance(self.bodies, tuple) else (), 2)


class Pairs(NamedTuple):
    """The law of each pair of bodies, for the kernels."""

    #: (bodies, bodies) int16: Number of the pair's entry, from 1, in the row of the body with the
    #: smaller number. It is negative if the entry names the other body first, 0 if the bodies pass
    #: through each other. On the diagonal it is of bodies that meet themselves, else 0.
    entry: np.ndarray
    #: (entries + 1,) int64: `TIED` or `UNILATERAL`; the last is for pairs without an entry, which
    #: are tied.
    kind: np.ndarray
    #: Parameters of each registered unilateral law; only their types matter.
    laws: tuple[NamedTuple, ...]
    law: np.ndarray  #: (entries + 1,) int64: Index of the entry's law in `laws`.
    parameters: np.ndarray  #: (entries + 1, n) float64: Parameters of the entry's law.
    #: (entries + 1, 3) float64: Normal and shear strength, and the gap up to which they hold; 0
    #: without adhesion.
    adhesion: np.ndarray

    @classmethod
    def of(cls, entries: Sequence[ContactEntry], bodies: Sequence[str]) -> Pairs:
        """Find the law of each pair; an entry for all applies to pairs that no other one names."""
        count = len(bodies)
        # Small numbers, and no lists of all pairs: there may be thousands of bodies.
        entry = np.full((count, count), len(entries) + 1, np.int16)
        number = {name: i for i, name in enumerate(bodies)}
        for i, each in enumerate(entries, 1):
            if each.bodies == "all":
                for a in range(count):
                    entry[a, a + 1 :] = i
        np.fill_diagonal(entry, 0)
        for i, each in enumerate(entries, 1):
            if each.itself:
                own = bodies if each.bodies == "all" else each.bodies
                entry[[number[name] for name in own], [number[name] for name in own]] = i
            for first, second in each.pairs():
                a, b = number[first], number[second]
                entry[min(a, b), max(a, b)] = i if a < b else -i
        kind = np.array([*(each.law.kind for each in entries), TIED], np.int64)
        for ignored in np.flatnonzero(kind == IGNORE) + 1:
            entry[np.abs(entry) == ignored] = 0
        laws = [kind for kind in map(parameters_of, LAWS.values()) if kind]
        law, parameters = np.zeros(len(kind), np.int64), np.zeros((len(kind), _width(laws)))
        for i, each in enumerate(entries):
            if each.law.kind == UNILATERAL:
                given = each.law.parameters(each)
                law[i] = laws.index(type(given))
                parameters[i, : len(given)] = given
        held = [each.adhesion for each in entries]
        adhesion = [(each.normal, each.shear, each.reach) if each else (0.0,) * 3 for each in held]
        examples = tuple(each._make((0.0,) * len(each._fields)) for each in laws)
        return cls(entry, kind, examples, law, parameters, np.array([*adhesion, (0.0,) * 3], float))

    def ties(self, count: int) -> bool:
        """Whether any of the first `count` bodies are tied."""
        tied = np.flatnonzero(self.kind == TIED) + 1
        return any(
            bool((np.abs(self.entry[a, a + 1 : count, None]) == tied).any()) for a in range(count)
        )


def parameters_of(law: type[ContactLaw]) -> type[NamedTuple] | None:
    """Return the type of a unilateral law's parameters; None for other laws."""
    if law.kind != UNILATERAL:
        return None
    return get_type_hints(law.parameters)["return"]


def _width(laws: Sequence[type[NamedTuple]]) -> int:
    return max(len(kind._fields) for kind in laws)


def sharing(case: Any) -> np.ndarray:
    """Mask of the pairs of bodies with particles that have no entry, (n, n); i < j counts."""
    entry = Pairs.of(case.contact, [*case.bodies, *case.rigid_bodies]).entry
    n = len(case.bodies)
    return np.abs(entry[:n, :n]) > len(case.contact)
