"""Convected particle domains: weights are means of the tent over the ends of a particle's box.

After Sadeghirad, Brannon and Burghardt, A convected particle domain interpolation technique,
Int. J. Numer. Meth. Engng 86, 1435-1456 (2011), along each direction: the tent is taken at the two
ends of the box and is linear in between. The ends then move exactly with the grid, so that the
boxes of neighbours stay contiguous where the stretch jumps, and bars do not tear. Gradients are as
for boxes (`finite-gimp`): the difference of the ends' values over the width.

In two and three dimensions weights are products over the directions. The widths belong to the
grid-aligned box with the same second moments as the deformed box. The corners follow stretches
along the grid, but do not tilt under shear and rotation; docs/methods.md has the cost. A half-width
is at most one cell. With two particles a cell and stretches beyond four, neighbours then no longer
touch; the log counts such particles.
"""

from typing import ClassVar, Literal

from pydantic import Field

from pgimp.jit.tuples import scaled
from pgimp.physics.shapes.base import WideShape
from pgimp.physics.shapes.stretch import FixedSize, TrackedSize


class CpdiParameters(TrackedSize):
    """Initial half-widths of the particles' boxes by direction, in cells; at most 1/2."""

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 4

    @staticmethod
    def weights(shape, half, f):
        """Means of the tent at f - l and f + l, for f in [l, 1 + l) and half-widths up to a cell.

        a = f - l lies in [0, 1). With b = f + l and b_j = max(b - j, 0) the values at b are
        1 - b + b_1, b - 2 b_1 + b_2, b_1 - 2 b_2 and b_2.
        """
        a = f - half
        b = f + half
        b1 = max(b - 1.0, 0.0)
        b2 = max(b - 2.0, 0.0)
        q = 0.5 / half
        n2 = b1 - 2.0 * b2
        n0 = 1.0 - b + b1
        w0 = 0.5 * ((1.0 - a) + n0)
        g0 = q * (n0 - (1.0 - a))
        g2, g3 = q * n2, q * b2
        return (
            (w0, 1.0 - w0 - 0.5 * n2 - 0.5 * b2, 0.5 * n2, 0.5 * b2),
            (g0, -g0 - g2 - g3, g2, g3),
        )

    @staticmethod
    def moments(shape, half, f, g):
        """See `pgimp.physics.shapes.base.moments`: of the line between the ends' values."""
        return scaled(half * half * (1.0 / 3.0), g), scaled(0.0, g)


class FixedCpdiParameters(FixedSize):
    """Half-widths of the particles' boxes by direction, in cells; at most 1/2, and constant."""

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 3

    @staticmethod
    def weights(shape, half, f):
        """As `CpdiParameters.weights`, for half-widths up to half a cell: b_2 = 0."""
        a = f - half
        b = f + half
        b1 = max(b - 1.0, 0.0)
        q = 0.5 / half
        n0 = 1.0 - b + b1
        w0 = 0.5 * ((1.0 - a) + n0)
        g0 = q * (n0 - (1.0 - a))
        g2 = q * b1
        return (w0, 1.0 - w0 - 0.5 * b1, 0.5 * b1), (g0, -g0 - g2, g2)

    @staticmethod
    def moments(shape, half, f, g):
        """As `CpdiParameters.moments`."""
        return scaled(half * half * (1.0 / 3.0), g), scaled(0.0, g)


class Cpdi(WideShape):
    """Boxes whose ends move with the grid (convected particle domains): bars do not tear."""

    shape: Literal["cpdi"] = Field(description="name of the shape")

    in_cell: ClassVar[bool] = True
    rings: ClassVar[bool] = True
    vertices: ClassVar[int] = CpdiParameters.vertices()
    ends: ClassVar[bool] = True

    @property
    def follows(self) -> bool:
        """See `Shape.follows`."""
        return True

    def parameters(self, cell: tuple[float, ...]) -> CpdiParameters:
        """Parameters of the kernels."""
        return CpdiParameters(tuple(0.5 / n for n in self.particles_per_cell))

    def fixed(self, cell: tuple[float, ...]) -> FixedCpdiParameters:
        """See `Shape.fixed`."""
        return FixedCpdiParameters(self.parameters(cell).half)
