"""Centrifugal and Coriolis forces of a rotating frame.

In a grid that turns with a rotor, the rotor is at rest and only vibrates. The force per mass on its
particles is b = -omega x (omega x (x - about)) - 2 omega x v.
"""

from typing import ClassVar, NamedTuple

from pgimp.physics.loads.bodyforce import BodyForceEntry
from pgimp.physics.loads.motion import Rotation, check_rotation
from pgimp.schema.sizes import Problems


class RotatingFrameParameters(NamedTuple):
    """Point on the axis, and angular velocity; zeros in directions that the case lacks."""

    about: tuple[float, float, float]
    omega: tuple[float, float, float]

    @staticmethod
    def acceleration(force, x, v, t):
        """See `pgimp.physics.loads`."""
        a, w = force.about, force.omega
        r0, r1, r2 = x[0] - a[0], x[1] - a[1], x[2] - a[2]
        # omega x (omega x r) + 2 omega x v = omega x (omega x r + 2 v)
        u0 = w[1] * r2 - w[2] * r1 + 2.0 * v[0]
        u1 = w[2] * r0 - w[0] * r2 + 2.0 * v[1]
        u2 = w[0] * r1 - w[1] * r0 + 2.0 * v[2]
        return w[2] * u1 - w[1] * u2, w[0] * u2 - w[2] * u0, w[1] * u0 - w[0] * u1


class RotatingFrame(Rotation, BodyForceEntry):
    """Centrifugal and Coriolis force of a grid that turns; velocities are those in it."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2, 3)

    def check(self, dimensions: int) -> Problems:
        """See `BodyForceEntry.check`."""
        yield from check_rotation((), self, dimensions)

    def parameters(self) -> RotatingFrameParameters:
        """Parameters of the kernels."""
        x, y, z = (*self.about, 0.0)[:3]
        rate = self.rate if isinstance(self.rate, tuple) else (0.0, 0.0, float(self.rate))
        return RotatingFrameParameters((x, y, z), (rate[0], rate[1], rate[2]))
