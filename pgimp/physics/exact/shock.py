"""A bar that is thrown at a wall (4.2): a front runs to the free end and comes back.

Behind the first front the bar is at rest with F = 1 - |v0|/c (46). Behind the reflected front it
is unstressed and flies back at |v0|. In the initial coordinate Z both fronts run at
c = sqrt(E/rho0), for any strain. At t = 2 L/c the whole bar leaves the wall.
"""

from collections.abc import Iterator, Mapping
from math import sqrt
from typing import Any, NamedTuple

from pgimp.physics.exact.bar import HOLDS, Bar, BarSolution, bar_of
from pgimp.physics.exact.base import no_gravity
from pgimp.schema.problems import Problem


class ShockParameters(NamedTuple):
    """The bar (see `Bar`), and its velocity v0 < 0 before the impact."""

    wall: float
    length: float
    young: float
    density: float
    velocity: float

    def scale(self, t: float) -> float:
        """Return the stress behind the front, E |v0|/c."""
        return sqrt(self.young * self.density) * abs(self.velocity)

    @staticmethod
    def state(solution, X, x, t):
        """Displacement, velocity and stress before, between or behind the fronts."""
        c = sqrt(solution.young / solution.density)
        z, v = X[0] - solution.wall, solution.velocity
        arrival = z / c
        back = (2.0 * solution.length - z) / c
        if t > back:
            return (v * arrival - v * (t - back),), (-v,), (0.0, 0.0, 0.0)
        if t > arrival:
            return (v * arrival,), (0.0,), (solution.young * v / c, 0.0, 0.0)
        return (v * t,), (v,), (0.0, 0.0, 0.0)


class Shock(BarSolution):
    """Elastic bar thrown at a wall, until the reflected front has come back to the wall."""

    @property
    def walls(self) -> Mapping[str, tuple[str, ...]]:
        """See `Solution.walls`."""
        return {"x-min": (*HOLDS, "unilateral")}

    def unlike(self, case: Any, name: str, velocity: float, bar: Bar) -> Iterator[Problem]:
        """The bar must fly at the wall, slower than sound, and the run end before it leaves it."""
        yield from no_gravity(case)
        if not -bar.speed < velocity < 0.0:
            yield Problem(
                ("bodies", name, "velocity"),
                "the exact solution needs a bar that flies at the wall, slower than its waves: "
                f"between {-bar.speed:.6g} and 0, got {velocity:.15g}",
                absent=not velocity,
            )
        leaves = 2.0 * bar.length / bar.speed
        if case.time.end > leaves * (1.0 + 1e-9):
            yield Problem(
                ("time", "end"),
                f"the exact solution ends at {leaves:.9g}, when the bar leaves the wall, "
                f"got {case.time.end:.15g}",
            )

    def parameters(self, case: Any) -> ShockParameters:
        """Parameters of the kernels."""
        (body,) = case.bodies.values()
        return ShockParameters(*bar_of(case), float(body.velocity[0]))
