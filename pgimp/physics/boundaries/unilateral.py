"""A unilateral wall with friction: it stops bodies that move into it, and they part freely."""

from math import sqrt
from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field

from pgimp.jit.kernel import kernel
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.contact.friction import AnyFriction, coefficients, coulomb_part
from pgimp.schema.base import Number


class UnilateralParameters(NamedTuple):
    """Face, static and kinetic coefficient of friction, and length of the step."""

    axis: int
    side: int
    static: float
    kinetic: float
    dt: float

    @staticmethod
    def approach(face, v, a, clearance):
        """Stop normal motion into the wall, and apply friction to sliding.

        As in contact of bodies: first to the velocity from the particles, then to the velocity
        after forces, which also changes the acceleration. The gap may close within the step.
        """
        dt = face.dt
        gap_rate = clearance / dt
        brought = (v[0] - dt * a[0], v[1] - dt * a[1], v[2] - dt * a[2])
        left = _brake(face, brought, gap_rate)
        # Exactly v where nothing was changed, without rounding.
        u = tuple(v[d] if left[d] == brought[d] else left[d] + dt * a[d] for d in range(3))
        w = _brake(face, u, gap_rate)
        return w, tuple(a[d] + (w[d] - u[d]) / dt for d in range(3))


@kernel
def _brake(face, v, gap_rate):
    """Velocity of a vertex after the wall's impulse."""
    k = face.axis
    into = (v[0] if k == 0 else (v[1] if k == 1 else v[2])) * face.side - gap_rate
    if not into > 0.0:
        return v
    x, y, z = (0.0 if k == 0 else v[0]), (0.0 if k == 1 else v[1]), (0.0 if k == 2 else v[2])
    speed = sqrt(x * x + y * y + z * z)
    part = max(0.0, 1.0 - coulomb_part(face.static, face.kinetic, 0.0, into, speed))
    normal = gap_rate * face.side
    return tuple(normal if k == d else part * w for d, w in enumerate((x, y, z)))


class Unilateral(Boundary):
    """Wall from which the material lifts off freely: a floor, a stop. It may have friction."""

    friction: AnyFriction = Field(default=0.0, description="coefficient of Coulomb's friction [1]")

    restitution: Annotated[Number, Field(ge=0.0, le=1.0)] = Field(
        default=0.0,
        description="coefficient of restitution of rigid bodies that move freely; bodies of a "
        "material rebound by their waves [1]",
    )

    releases: ClassVar[bool] = True
    approaches: ClassVar[bool] = True

    @property
    def mirrors(self) -> bool:
        """See `Boundary.mirrors`: what a mirror presses on the face would rub without friction."""
        return coefficients(self.friction)[0] == 0.0

    @property
    def varies(self) -> bool:
        """See `Boundary.varies`: by the length of the step."""
        return True

    def parameters(self, axis: int, side: int, start: float, end: float) -> UnilateralParameters:
        """See `Boundary.parameters`."""
        static, kinetic = coefficients(self.friction)
        dt = max(end - start, 1e-300)  # zero if only the held components are computed
        return UnilateralParameters(axis, side, float(static), float(kinetic), dt)
