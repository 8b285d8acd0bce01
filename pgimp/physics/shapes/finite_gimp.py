"""Contiguous-particle GIMP whose particles' boxes follow the deformation (36-39).

In one dimension this is the paper's Finite GIMP: half-width l_p F. In two and three dimensions a
deformed box is approximated by the grid-aligned box with the same second moments. This is exact
under stretches along the grid, and a cube keeps its size under any rotation. Under shear the box
has the parallelepiped's spread along each direction but not its tilt. Neighbours then overlap or
leave gaps, on a part of the volume that grows with the square of the shear. A simple shear g widens
boxes by g^2/2. So the particles are a partition of unity to first order. The same holds for boxes
of a rotated lattice, which stay along the grid.
"""

from typing import ClassVar, Literal

from pydantic import Field

from pgimp.physics.shapes.base import WideShape
from pgimp.physics.shapes.gimp import GimpParameters
from pgimp.physics.shapes.stretch import TrackedSize


class FiniteGimpParameters(TrackedSize):
    """Initial half-widths of the particles' boxes by direction, in cells; at most 1/2."""

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 4

    @staticmethod
    def weights(shape, half, f):
        """Mean of the tent over the box, for f in [l, 1 + l), exact for half-widths up to a cell.

        As in `gimp`, but a box of more than half a cell may reach a fourth vertex. With
        a_j = max(f + l - j, 0) the outer weights are (t^2 - u^2)/(4 l), (a_1^2 - 2 a_2^2)/(4 l) and
        a_2^2/(4 l).
        """
        t = 1.0 + half - f
        u = max(1.0 - half - f, 0.0)
        a1 = max(f + half - 1.0, 0.0)
        a2 = max(f + half - 2.0, 0.0)
        q = 0.25 / half
        w0 = (t * t - u * u) * q
        w2 = (a1 * a1 - 2.0 * (a2 * a2)) * q
        w3 = a2 * a2 * q
        g0 = -2.0 * (t - u) * q
        g2 = 2.0 * (a1 - 2.0 * a2) * q
        g3 = 2.0 * a2 * q
        return (w0, 1.0 - w0 - w2 - w3, w2, w3), (g0, -g0 - g2 - g3, g2, g3)

    @staticmethod
    def moments(shape, half, f, g):
        """See `pgimp.physics.shapes.base.moments`; K and e are of the kinks at vertices 1 and 2."""
        a, b = max(f - 1.0 + half, 0.0), max(f - 2.0 + half, 0.0)
        third = half * half * (1.0 / 3.0)
        q = 0.25 / half
        K1, e1 = a * a * (3.0 * half - a) * q * (1.0 / 3.0), a * (2.0 * half - a) * q
        K2, e2 = b * b * (3.0 * half - b) * q * (1.0 / 3.0), b * (2.0 * half - b) * q
        return (
            (K1 - third, third - 2.0 * K1 + K2, K1 - 2.0 * K2, K2),
            (e1, e2 - 2.0 * e1, e1 - 2.0 * e2, e2),
        )


class FiniteGimp(WideShape):
    """Boxes that follow the deformation: as gimp at small strains, and accurate at large ones."""

    shape: Literal["finite-gimp"] = Field(description="name of the shape")

    in_cell: ClassVar[bool] = True
    rings: ClassVar[bool] = True
    vertices: ClassVar[int] = FiniteGimpParameters.vertices()

    @property
    def follows(self) -> bool:
        """See `Shape.follows`."""
        return True

    def parameters(self, cell: tuple[float, ...]) -> FiniteGimpParameters:
        """Parameters of the kernels."""
        return FiniteGimpParameters(tuple(0.5 / n for n in self.particles_per_cell))

    def fixed(self, cell: tuple[float, ...]) -> GimpParameters:
        """See `Shape.fixed`: undeformed boxes are as in `gimp`."""
        return GimpParameters(self.parameters(cell).half)
