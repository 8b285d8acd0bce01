"""Common base of the elastic bar's solutions: s = E (F - 1) (41), a bar from x-min on."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from math import sqrt
from typing import Any, ClassVar, NamedTuple

from pgimp.geometry.regions import Box
from pgimp.physics.exact.base import Solution
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import WHOLE

#: Conditions that hold the end of a bar; a unilateral one does as long as the bar pushes.
HOLDS = ("fixed", "slip")


class Bar(NamedTuple):
    """Coordinate of the bar's beginning, initial length, Young's modulus and initial density."""

    wall: float
    length: float
    young: float
    density: float

    @property
    def speed(self) -> float:
        """Wave speed with respect to the initial state."""
        return sqrt(self.young / self.density)


class BarSolution(Solution):
    """Base of the solutions of the bar."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (1,)
    model: ClassVar[str] = "linear-1d"

    @property
    def walls(self) -> Mapping[str, tuple[str, ...]]:
        """See `Solution.walls`."""
        return {"x-min": HOLDS}

    def mismatches(self, case: Any, name: str, body: Any) -> Iterator[Problem]:
        """The bar must be a box from wall to wall, or from the wall to a free end."""
        wrong = list(self._wrong_place(case, name, body))
        yield from wrong
        if not wrong:
            yield from self.unlike(case, name, body.velocity[0], bar_of(case))

    @abstractmethod
    def unlike(self, case: Any, name: str, velocity: float, bar: Bar) -> Iterator[Problem]:
        """As `mismatches`, for a bar at the right position; `velocity` is its initial velocity."""

    def _wrong_place(self, case: Any, name: str, body: Any) -> Iterator[Problem]:
        region, low, high = body.region, case.grid.origin[0], case.grid.corner[0]
        path = ("bodies", name, "region")
        slack = WHOLE * case.grid.cell[0]
        if not isinstance(region, Box):
            yield Problem(path, "the exact solution needs a box")
        elif abs(region.min[0] - low) > slack:
            text = f"the exact solution needs a bar that starts at x-min, {low:.15g}"
            yield Problem((*path, "box", "min"), f"{text}, got {region.min[0]:.15g}")
        elif "x-max" in self.walls and abs(region.max[0] - high) > slack:
            text = f"the exact solution needs a bar that ends at x-max, {high:.15g}"
            yield Problem((*path, "box", "max"), f"{text}, got {region.max[0]:.15g}")


def bar_of(case: Any) -> Bar:
    """The bar of a case without mismatches."""
    (body,) = case.bodies.values()
    material = case.materials[body.material]
    low, high = body.region.min[0], body.region.max[0]
    return Bar(float(low), float(high - low), float(material.young), float(material.density))
