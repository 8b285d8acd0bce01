"""State and inertia of a free rigid body, and their change in a step.

Plain Python arithmetic on float64 in one order of operations: the same bits on every rank.
"""

from __future__ import annotations

from typing import NamedTuple, Self

from pgimp.errors import CaseError
from pgimp.physics.loads.motion import RigidMotion
from pgimp.physics.rigid import FREEDOMS, Pose, RigidBody, Triple
from pgimp.scene.rigid.bulk import Bulk
from pgimp.scene.rigid.images import Ring
from pgimp.scene.rigid.rotation import Matrix, add, cross, matrix, solve, triple, turned
from pgimp.schema.tables import VectorFunction

Six = tuple[float, ...]
"""Six numbers: along x, y, z, and about them."""


class State(NamedTuple):
    """State of motion of a free rigid body."""

    centre: Triple  #: (3,) float: Its centre of mass.
    #: (4,) float: Unit quaternion of its rotation since the start, real part first.
    turn: tuple[float, float, float, float]
    #: momentum, spin: (3,) float: Momentum; angular momentum about the centre.
    momentum: Triple
    spin: Triple
    angle: Triple  #: (3,) float: Integral of its angular velocity since the start.
    #: (3,) float or (): In periodic domains the image of its centre that is within.
    home: tuple[float, ...] = ()

    @property
    def numbers(self) -> list[float]:
        """All numbers of the state."""
        return [x for part in self for x in part]

    @classmethod
    def of(cls, numbers: list[float]) -> Self:
        """Return the state that has these numbers."""
        x = numbers
        return cls(
            (x[0], x[1], x[2]), (x[3], x[4], x[5], x[6]), (x[7], x[8], x[9]),
            (x[10], x[11], x[12]), (x[13], x[14], x[15]), tuple(x[16:]),
        )  # fmt: skip


class FreeBody:
    """Constants of a free rigid body.

    Parameters
    ----------
    name, entry : str, RigidBody
        The entry in the case.
    bulk : Bulk
        Its inertia.
    dimensions, rings : int, tuple of Ring
        Directions of the scene; those of a periodic domain, else ().
    axial : bool
        Whether it is a body of revolution, which only moves along its axis, y.

    Attributes
    ----------
    may : tuple of 6 bool
        Degrees of freedom: along x, y, z and about them.
    """

    def __init__(
        self, name: str, entry: RigidBody, bulk: Bulk, dimensions: int,
        rings: tuple[Ring, ...] = (), axial: bool = False,
    ) -> None:  # fmt: skip
        assert entry.free is not None
        self.name = name
        self.bulk, self.may = bulk, entry.free.may(dimensions)
        self.free, self.rings = entry.free, rings
        if axial:
            self.may = tuple(may and d == 1 for d, may in enumerate(self.may))
        self.first = self._at_start(entry)
        self._last: tuple[State | None, Six] = (None, ())

    def _at_start(self, entry: RigidBody) -> State:
        """Return its state at the start."""
        motion, centre = entry.velocity, self.bulk.centre
        velocity: tuple[float, ...] = motion if isinstance(motion, tuple) else ()
        x, y, z = (*velocity, 0.0, 0.0, 0.0)[:3]
        omega = (0.0, 0.0, 0.0)
        if isinstance(motion, RigidMotion):
            rate = motion.rotation.rate
            omega = (0.0, 0.0, float(rate)) if isinstance(rate, float | int) else triple(rate)
            about = triple((*motion.rotation.about, 0.0, 0.0))
            arm = tuple(a - b for a, b in zip(centre, about, strict=True))
            along = triple((*(motion.translation or ()), 0.0, 0.0, 0.0))
            x, y, z = (a + b for a, b in zip(along, cross(omega, triple(arm)), strict=True))
        still = State(centre, (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0,) * 3)
        moving = [v if may else 0.0 for v, may in zip((x, y, z, *omega), self.may, strict=True)]
        least = 1e-9 * max(map(abs, (x, y, z)))
        for v, kept, freedom in zip((x, y, z), moving, FREEDOMS, strict=False):
            if abs(v - kept) > least:
                raise CaseError(
                    f"bodies.{self.name}.velocity: its centre of mass moves by {v:.3g} along "
                    f"{freedom}, which `fixed` excludes"
                )
        momentum, spin = self.momenta(self.inertia(still.turn), moving)
        home = tuple(ring.inside(x) for ring, x in zip(self.rings, centre, strict=False))
        return still._replace(momentum=momentum, spin=spin, home=home)

    def inertia(self, turn: tuple[float, ...]) -> Matrix:
        """Return the moments of inertia in the directions of space."""
        R = matrix(turn)
        a, b, c, d, e, f, g, h, k = self.bulk.inertia
        found: list[float] = []
        for x, y, z in (R[:3], R[3:6], R[6:]):
            u, v, w = x * a + y * d + z * g, x * b + y * e + z * h, x * c + y * f + z * k
            found += (u * R[3 * j] + v * R[3 * j + 1] + w * R[3 * j + 2] for j in range(3))
        return tuple(found)

    def mass_matrix(self, inertia: Matrix) -> list[list[float]]:
        """Return the mass matrix, 6 x 6, from velocities to momenta; identity where held."""
        M = [[0.0] * 6 for _ in range(6)]
        for i in range(6):
            for j in range(6):
                if i == j and not self.may[i]:
                    M[i][j] = 1.0
                elif not (self.may[i] and self.may[j]):
                    continue
                elif i > 2 and j > 2:
                    M[i][j] = inertia[3 * (i - 3) + j - 3]
                elif i == j:
                    M[i][j] = self.bulk.mass
        return M

    def momenta(self, inertia: Matrix, velocities: list[float]) -> tuple[Triple, Triple]:
        """Return linear and angular momentum for velocities along and about x, y, z."""
        M = self.mass_matrix(inertia)
        p = [
            sum(M[i][j] * velocities[j] for j in range(6)) if self.may[i] else 0.0 for i in range(6)
        ]
        return (p[0], p[1], p[2]), (p[3], p[4], p[5])

    def velocities(self, state: State) -> Six:
        """Return velocity and angular velocity."""
        if self._last[0] is not state:  # needed several times a step
            found = self._velocities((*state.momentum, *state.spin), self.inertia(state.turn))
            self._last = state, found
        return self._last[1]

    def _velocities(self, momenta: Six, inertia: Matrix) -> Six:
        return tuple(solve(self.mass_matrix(inertia), [*momenta]))

    def halfway(self, state: State, dt: float) -> Matrix:
        """Return the moments of inertia at the rotation after half a step.

        With these a body without forces conserves its energy to second order in the step.
        """
        omega = self.velocities(state)[3:]
        return self.inertia(turned(state.turn, triple(tuple(0.5 * dt * w for w in omega))))

    def moved(self, state: State, momenta: Six, inertia: Matrix, dt: float) -> State:
        """Return the state after a step with these momenta."""
        p = tuple(value if may else 0.0 for value, may in zip(momenta, self.may, strict=True))
        v = self._velocities(p, inertia)
        shift, turn = triple(tuple(dt * x for x in v)), triple(tuple(dt * w for w in v[3:]))
        return State(
            add(state.centre, shift),
            turned(state.turn, turn),
            triple(p),
            triple(p[3:]),
            add(state.angle, turn),
            tuple(map(Ring.inside, self.rings, state.home, shift)),
        )

    def carried(self, state: State, start: float, dt: float, gravity: Six) -> list[float]:
        """Return the momentum after a step from `start` under gravity, force and spring.

        The spring acts by its deflection at the beginning, the dashpot by the mean velocity. As a
        quarter of k dt^2 is added to the mass in this, no spring shortens the steps.
        """
        mass, spring = self.bulk.mass, self.free.spring
        if self.free.force is None and spring is None:
            return [p + dt * mass * g for p, g in zip(state.momentum, gravity, strict=True)]
        push = [mass * g for g in gravity]
        if self.free.force is not None:
            force = self.free.force
            given = force.value(start) if isinstance(force, VectorFunction) else force
            for d, f in enumerate(given):
                push[d] += f
        if spring is None:
            return [p + dt * f for p, f in zip(state.momentum, push, strict=True)]
        heavy = mass + 0.5 * dt * spring.dashpot + 0.25 * dt**2 * spring.stiffness
        to = (*(spring.to or self.first.centre), 0.0, 0.0)[:3]
        for d, (x, at, p) in enumerate(zip(state.centre, to, state.momentum, strict=True)):
            push[d] -= spring.stiffness * (x - at) + spring.dashpot * p / mass
        part = dt * mass / heavy
        return [p + part * f for p, f in zip(state.momentum, push, strict=True)]

    def pushed(self, state: State, given: list[float]) -> State:
        """Return the state after an impulse and an angular impulse, along its free directions."""
        p = tuple(
            own + (J if may else 0.0)
            for own, J, may in zip((*state.momentum, *state.spin), given, self.may, strict=True)
        )
        return state._replace(momentum=triple(p), spin=triple(p[3:]))

    def pose(self, state: State) -> Pose:
        """Return the pose: position and rotation."""
        return Pose(state.centre, matrix(state.turn))

    def moments(self, state: State) -> Six:
        """Return momentum, and angular momentum about the origin of the coordinates."""
        return (*state.momentum, *add(state.spin, cross(state.centre, state.momentum)))

    def angle(self, state: State) -> tuple[float, ...]:
        """Return the integral of the angular velocity since the start."""
        return state.angle

    def energy(self, state: State) -> float:
        """Return the kinetic energy."""
        v = self.velocities(state)
        return 0.5 * sum(a * b for a, b in zip(v, (*state.momentum, *state.spin), strict=True))
