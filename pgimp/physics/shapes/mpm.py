"""The material point method: particles are points, S_vp = S_v(x_p) (34, 35)."""

from typing import ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.physics.shapes.base import PointShape


class MpmParameters(NamedTuple):
    """A point has no size; the tuple keeps one number because Numba needs a field."""

    half: tuple[float, ...]

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 2

    @staticmethod
    def size(shape, cell, F):
        """A point has none."""
        return shape.half, 0.0

    @staticmethod
    def weights(shape, half, f):
        """Tent functions of the cell's two vertices (35).

        The gradient reaches the second vertex also when the particle stands on the first; so that
        the vertex then has a velocity, the weight is never exactly zero.
        """
        f = max(f, 1e-60)
        return (1.0 - f, f), (-1.0, 1.0)


class Mpm(PointShape):
    """Points, the original Material Point Method: cheapest; noisy once particles cross cells."""

    shape: Literal["mpm"] = Field(description="name of the shape")

    vertices: ClassVar[int] = MpmParameters.vertices()
    chi: ClassVar[Literal["point", "box", "tent"]] = "point"
    #: No step is stable at every free surface: the lighter the last vertex, the shorter it has to
    #: be. At this much a last vertex with a hundredth of a particle still is.
    stable_pointwise: ClassVar[float] = 0.1

    def parameters(self, cell: tuple[float, ...]) -> MpmParameters:
        """Parameters of the kernels."""
        return MpmParameters(tuple(0.0 for _ in self.particles_per_cell))
