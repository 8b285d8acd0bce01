"""Two features that exclude each other, and why."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple

from pgimp.case.checks.exclusions.feature import Feature, Place
from pgimp.schema.problems import Problem


class Exclusion(NamedTuple):
    """Two features that no case has together; `{a.name}`, `{b.axis}` .. are of their places."""

    a: Feature
    """Where it is, the case is wrong."""
    b: Feature
    why: str
    remedy: str = ""
    same: Literal["", "owner", "axis"] = ""
    """Of what both have to be to exclude each other: one body or face, or one axis."""
    each: bool = False
    """Whether every place of `b` is told, and not the first alone."""

    def texts(self, place: Place) -> tuple[str, str]:
        """Reason and remedy for tables, with a place for both."""
        why, remedy = (text.format(a=place, b=place) for text in (self.why, self.remedy))
        return why.removesuffix(":"), remedy

    def text(self, a: Place, b: Place) -> str:
        """Message about two places."""
        between = " " if self.why.endswith(":") else "; "
        return between.join(filter(None, (self.why, self.remedy))).format(a=a, b=b)

    def problems(self, here: Iterable[Place], there: Iterable[Place]) -> Iterator[Problem]:
        """Yield the problems of a case that has `a` here and `b` there."""
        for place in here:
            key = self.same
            others = [b for b in there if not key or getattr(b, key) == getattr(place, key)]
            for other in others if self.each else others[:1]:
                yield Problem(place.path, self.text(place, other))
