"""Contiguous-particle GIMP whose particles' boxes follow the deformation (36-39).

In one dimension this is the paper's Finite GIMP: half-width l_p F. In two and three dimensions a
deformed box is approximated by the box, along the grid's directions, with the same second moments:
right under stretches along the grid and under rotation by any angle; under shear the parallelepiped
is replaced by that box, which covers the same extent but not the same points, so that neighbours
overlap a little and the particles are a partition of unity only to first order in the shear.
"""

from typing import ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.shapes.base import Shape
from pgimp.shapes.stretch import stretched


class FiniteGimpParameters(NamedTuple):
    """Initial half-widths of the particles' boxes by direction, in cells; at most 1/2."""

    half: tuple[float, ...]

    @staticmethod
    def size(shape, cell, F):
        """Follows the deformation."""
        return stretched(shape.half, cell, F)

    @staticmethod
    def weights(shape, half, f):
        """Mean of the tent over the box, exact for half-widths up to a cell.

        (G(xi + l) - G(xi - l))/(2 l), with the tent's integral G written in squares of truncated
        distances; a_j belongs to the box's high end, b_j to its low end, over vertex j.
        """
        q = 0.25 / half
        a0, a1, a2 = f + half, max(f + half - 1.0, 0.0), max(f + half - 2.0, 0.0)
        b0 = f - half
        an, bn = a0 + 1.0, b0 + 1.0
        A0, A1, A2, B0 = a0 * a0, a1 * a1, a2 * a2, b0 * b0
        w0 = (an * an - 2.0 * A0 + A1 - bn * bn + 2.0 * B0) * q
        w2 = (A1 - 2.0 * A2) * q
        w3 = A2 * q
        g0 = (an - 2.0 * a0 + a1 - bn + 2.0 * b0) * (2.0 * q)
        g2 = (a1 - 2.0 * a2) * (2.0 * q)
        g3 = a2 * (2.0 * q)
        return (w0, 1.0 - w0 - w2 - w3, w2, w3), (g0, -g0 - g2 - g3, g2, g3)


class FiniteGimp(Shape):
    """Contiguous-particle GIMP whose particles follow the deformation: the most accurate."""

    shape: Literal["finite-gimp"] = Field(description="name of the shape")

    vertices: ClassVar[int] = 4

    def parameters(self, cell: tuple[float, ...]) -> FiniteGimpParameters:
        """Parameters of the kernels."""
        return FiniteGimpParameters(tuple(0.5 / n for n in self.particles_per_cell))
