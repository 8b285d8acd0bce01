"""A wall that lets go: the normal part is held only when moving into the wall; with friction."""

from math import sqrt
from typing import ClassVar, NamedTuple

from pydantic import Field

from pgimp.jit.kernel import kernel
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.contact import AnyFriction, coefficients


class SeparatingParameters(NamedTuple):
    """The face."""

    axis: int
    side: int

    @staticmethod
    def constrain(face, v, a):
        """Hold the normal component of a vertex whose new velocity points out of the domain."""
        k = face.axis
        normal = v[0] if k == 0 else (v[1] if k == 1 else v[2])
        hold = normal * face.side > 0.0
        x, y, z = hold and k == 0, hold and k == 1, hold and k == 2
        return (
            (0.0 if x else v[0], 0.0 if y else v[1], 0.0 if z else v[2]),
            (0.0 if x else a[0], 0.0 if y else a[1], 0.0 if z else a[2]),
        )


class FrictionParameters(NamedTuple):
    """The face, static and kinetic coefficient, and the step's length."""

    axis: int
    side: int
    static: float
    kinetic: float
    dt: float

    @staticmethod
    def constrain(face, v, a):
        """Stop what moves into the wall, and brake what slides on it, as far as it is pressed.

        As where bodies meet: first the velocity that particles bring, then that after forces have
        acted; of the second the acceleration changes, too.
        """
        dt = face.dt
        u = _brake(face, (v[0] - dt * a[0], v[1] - dt * a[1], v[2] - dt * a[2]))
        u = (u[0] + dt * a[0], u[1] + dt * a[1], u[2] + dt * a[2])
        w = _brake(face, u)
        return w, (
            a[0] + (w[0] - u[0]) / dt, a[1] + (w[1] - u[1]) / dt, a[2] + (w[2] - u[2]) / dt
        )  # fmt: skip


@kernel
def _brake(face, v):
    """Velocity of a vertex after the wall's impulse."""
    k = face.axis
    into = (v[0] if k == 0 else (v[1] if k == 1 else v[2])) * face.side
    if not into > 0.0:
        return v
    x, y, z = (0.0 if k == 0 else v[0]), (0.0 if k == 1 else v[1]), (0.0 if k == 2 else v[2])
    speed = sqrt(x * x + y * y + z * z)
    part = 0.0
    if speed > face.static * into:
        part = max(0.0, 1.0 - face.kinetic * into / speed)
    return part * x, part * y, part * z


class Separating(Boundary):
    """Wall from which the material lifts off freely: a floor, a stop. It may have friction."""

    friction: AnyFriction = Field(default=0.0, description="coefficient of Coulomb's friction [1]")

    releases: ClassVar[bool] = True

    @property
    def varies(self) -> bool:
        """See `Boundary.varies`: with friction, as it needs the length of the step."""
        return coefficients(self.friction)[0] > 0.0

    def parameters(
        self, axis: int, side: int, start: float, end: float
    ) -> SeparatingParameters | FrictionParameters:
        """See `Boundary.parameters`."""
        if not self.varies:
            return SeparatingParameters(axis, side)
        static, kinetic = coefficients(self.friction)
        dt = max(end - start, 1e-300)  # none where nothing is computed but what is held
        return FrictionParameters(axis, side, float(static), float(kinetic), dt)
