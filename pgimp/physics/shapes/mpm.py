"""The material point method: particles are points, S_vp = S_v(x_p) (34, 35)."""

from typing import ClassVar, Literal

from pydantic import Field

from pgimp.physics.shapes.base import PointShape
from pgimp.physics.shapes.stretch import FixedSize


class MpmParameters(FixedSize):
    """A point has no size; the tuple keeps one number because Numba needs a field."""

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 2

    @staticmethod
    def weights(shape, half, f):
        """Tent functions of the cell's two vertices (35).

        The gradient reaches the second vertex even if the particle is on the first vertex. The
        weight is never exactly zero, so that the second vertex then has a velocity.
        """
        f = max(f, 1e-60)
        return (1.0 - f, f), (-1.0, 1.0)

    @staticmethod
    def moments(shape, half, f, g):
        """See `pgimp.physics.shapes.base.moments`: none of a point."""
        return (0.0 * f, 0.0 * f), (0.0 * f, 0.0 * f)


class Mpm(PointShape):
    """Points, the original Material Point Method: cheapest; noisy once particles cross cells."""

    shape: Literal["mpm"] = Field(description="name of the shape")

    in_cell: ClassVar[bool] = True
    rings: ClassVar[bool] = True
    vertices: ClassVar[int] = MpmParameters.vertices()
    chi: ClassVar[Literal["point", "box", "tent"]] = "point"
    #: No step is stable at every free surface: a lighter last vertex needs a shorter step. This
    #: Courant number is stable for a last vertex with a hundredth of a particle's mass.
    stable_pointwise: ClassVar[float] = 0.1

    def parameters(self, cell: tuple[float, ...]) -> MpmParameters:
        """Parameters of the kernels."""
        return MpmParameters(tuple(0.0 for _ in self.particles_per_cell))
