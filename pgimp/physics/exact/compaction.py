"""A bar under a body force that grows with time (4.1): in equilibrium, or with waves.

With s = E (F - 1) the wave equation in the initial coordinate Z is linear for any strain:
rho0 u_tt = E u_ZZ + rho0 b. In equilibrium u = rho0 b/E (L Z - Z^2/2). Under the ramp b = b' t
this displacement also satisfies the wave equation, but its initial velocity r(Z) is not zero.
The exact solution adds the free vibration w with w = 0 and w_t = -r(Z) at t = 0. By d'Alembert
w = -(R(Z + c t) - R(Z - c t))/(2 c). R is the integral of r, continued oddly about Z = 0 and
evenly about Z = L. w vanishes at all multiples of 2 L/c.
"""

from collections.abc import Iterator
from math import floor, sqrt
from typing import Any, NamedTuple

import numpy as np
from pydantic import Field

from pgimp.jit.kernel import kernel
from pgimp.physics.exact.bar import Bar, BarSolution, bar_of
from pgimp.schema.problems import Problem
from pgimp.schema.tables import VectorTable


@kernel
def load(times, loads, t) -> tuple[float, float]:
    """Body force and its rate at a time: linear between table rows, constant beyond the ends."""
    if t < times[0]:
        return loads[0], 0.0
    for k in range(1, len(times)):
        if t < times[k]:
            rate = (loads[k] - loads[k - 1]) / (times[k] - times[k - 1])
            return loads[k - 1] + rate * (t - times[k - 1]), rate
    return loads[-1], 0.0


class StaticParameters(NamedTuple):
    """The bar (see `Bar`), and the table of the body force: times and values, (rows,) each."""

    wall: float
    length: float
    young: float
    density: float
    times: np.ndarray
    loads: np.ndarray

    def scale(self, t: float) -> float:
        """Return the column's weight W (44), to which (47) refers."""
        return self.density * abs(load(self.times, self.loads, t)[0]) * self.length

    @staticmethod
    def state(solution, X, x, t):
        """Stress (42) at the particle's position; displacement and velocity of the material."""
        b, rate = load(solution.times, solution.loads, t)
        z, length = X[0] - solution.wall, solution.length
        compliance = solution.density / solution.young
        shape = z * (length - 0.5 * z)
        end = length + 0.5 * compliance * b * length * length  # (43)
        above = max(end - (x[0] - solution.wall), 0.0)
        stress = solution.young * (sqrt(2.0 * compliance * b * above + 1.0) - 1.0)
        return (compliance * b * shape,), (compliance * rate * shape,), (stress, 0.0, 0.0)


@kernel
def continued(z, length):
    """r(z) = z (L - z/2), odd about 0 and even about L, so of period 4 L; and its integral."""
    z -= 4.0 * length * floor(0.25 * z / length + 0.5)
    a = abs(z)
    r = a * (length - 0.5 * a)
    return (r if z > 0.0 else -r), a * a * (0.5 * length - a / 6.0)


@kernel
def ramp(z, length, c, t):
    """Displacement, velocity and strain over b'/c^2."""
    r, _ = continued(z, length)
    ahead, sum_ahead = continued(z + c * t, length)
    behind, sum_behind = continued(z - c * t, length)
    return (
        t * r - 0.5 * (sum_ahead - sum_behind) / c,
        r - 0.5 * (ahead + behind),
        t * (length - z) - 0.5 * (ahead - behind) / c,
    )


class DynamicParameters(NamedTuple):
    """The bar (see `Bar`), and the rate b' of the body force."""

    wall: float
    length: float
    young: float
    density: float
    rate: float

    def scale(self, t: float) -> float:
        """Return the column's weight W (44), to which (47) refers."""
        return self.density * abs(self.rate * t) * self.length

    @staticmethod
    def state(solution, X, x, t):
        """Stress at the particle's position; displacement and velocity of the material."""
        z, length = X[0] - solution.wall, solution.length
        square = solution.young / solution.density
        c, f = sqrt(square), solution.rate / square
        u, v, strain = ramp(z, length, c, t)
        # Material point now at x, by a step of Newton's method from the particle's own.
        z += (x[0] - X[0] - f * u) / (1.0 + f * strain)
        strain = ramp(z, length, c, t)[2]
        return (f * u,), (f * v,), (solution.young * f * strain, 0.0, 0.0)


class Compaction(BarSolution):
    """Elastic column on a wall, under a body force that grows in time."""

    dynamic: bool = Field(
        default=False,
        description="the waves that a ramp sends through the column are part of the solution; "
        "false: the column is in equilibrium at any time",
    )

    def unlike(self, case: Any, name: str, velocity: float, bar: Bar) -> Iterator[Problem]:
        """The load must be a table, a ramp from zero if `dynamic`; the column starts at rest."""
        if velocity:
            text = "the exact solution starts at rest; leave this out"
            yield Problem(("bodies", name, "velocity"), text)
        table = case.gravity
        if not isinstance(table, VectorTable):
            text = "the exact solution needs a table over time"
            missing = table is None
            yield Problem(("gravity",), f"missing; {text}" if missing else text, missing)
            return
        if self.dynamic:
            yield from self._no_ramp(table.table, case.time.end)
        for i, (_, (b,)) in enumerate(table.table):
            if bar.density * -b * bar.length >= bar.young:
                text = "the weight reaches Young's modulus and crushes the column"
                yield Problem(("gravity", "table", i, 1), text)

    @staticmethod
    def _no_ramp(rows: Any, end: float) -> Iterator[Problem]:
        if len(rows) != 2 or rows[0] != (0.0, (0.0,)):
            text = "the exact dynamic solution needs one ramp, from [0, [0]] to a second row"
            yield Problem(("gravity", "table"), text)
        elif rows[1][0] < end * (1.0 - 1e-9):
            yield Problem(
                ("gravity", "table", 1, 0),
                f"the exact dynamic solution needs a ramp that goes on to the end at {end:.15g}",
            )

    def parameters(self, case: Any) -> StaticParameters | DynamicParameters:
        """Parameters of the kernels."""
        bar, rows = bar_of(case), case.gravity.table
        if self.dynamic:
            return DynamicParameters(*bar, float(rows[1][1][0] / rows[1][0]))
        times, loads = [row[0] for row in rows], [row[1][0] for row in rows]
        return StaticParameters(*bar, np.array(times, float), np.array(loads, float))
