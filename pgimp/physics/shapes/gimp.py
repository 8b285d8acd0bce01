"""Contiguous-particle GIMP: chi_p is a box of constant size, S_vp piecewise quadratic (36-40)."""

from typing import ClassVar, Literal

from pydantic import Field

from pgimp.physics.shapes.base import PointShape, WideShape
from pgimp.physics.shapes.stretch import FixedSize


class GimpParameters(FixedSize):
    """Half-widths l_p of the particles' boxes by direction, in cells; at most 1/2."""

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 3

    @staticmethod
    def weights(shape, half, f):
        """Weights (40), for f in [l, 1 + l), without branches: a branch costs 40 % here.

        With t = 1 + l - f, u = max(1 - l - f, 0), s = max(f - 1 + l, 0) the outer weights are
        (t^2 - u^2)/(4 l) and s^2/(4 l). The middle weight makes the sum 1 (23).
        """
        t = 1.0 + half - f
        u = max(1.0 - half - f, 0.0)
        s = max(f - 1.0 + half, 0.0)
        q = 0.25 / half
        w0 = (t * t - u * u) * q
        w2 = s * s * q
        g0 = -2.0 * (t - u) * q
        g2 = 2.0 * s * q
        return (w0, 1.0 - w0 - w2, w2), (g0, -g0 - g2, g2)

    @staticmethod
    def moments(shape, half, f, g):
        """See `pgimp.physics.shapes.base.moments`; K and e are of the kink at vertex 1."""
        a = max(f - 1.0 + half, 0.0)
        third = half * half * (1.0 / 3.0)
        q = 0.25 / half
        K, e = a * a * (3.0 * half - a) * q * (1.0 / 3.0), a * (2.0 * half - a) * q
        return (K - third, third - 2.0 * K, K), (e, -2.0 * e, e)


class Gimp(WideShape, PointShape):
    """Boxes of constant size (contiguous-particle GIMP): smooth; for strains of some per cent."""

    shape: Literal["gimp"] = Field(description="name of the shape")

    in_cell: ClassVar[bool] = True
    rings: ClassVar[bool] = True
    vertices: ClassVar[int] = GimpParameters.vertices()

    def parameters(self, cell: tuple[float, ...]) -> GimpParameters:
        """Parameters of the kernels: l_p = L/(2 particles per cell)."""
        return GimpParameters(tuple(0.5 / n for n in self.particles_per_cell))
