"""Convected particle domains in full: weights are means of the grid's over a particle's corners.

After Sadeghirad, Brannon and Burghardt, A convected particle domain interpolation technique,
Int. J. Numer. Meth. Engng 86, 1435-1456 (2011). F makes a particle's box a parallelogram, in 3D a
parallelepiped. Its corners are x_c = x_p + sum_j s_cj F e_j l_j, s_cj = -1 or 1, with the initial
half-widths l_j. Weights and gradients are

    S_vp = 2^-D sum_c S_v(x_c),    grad S_vp = 2^-D sum_c S_v(x_c) A^-T s_c,    A = F diag(l),

The gradient is the mean, over the parallelogram, of the gradient of the multilinear interpolation
between its corners. Corners move with the grid. Neighbours stay contiguous under any uniform
deformation, also under shear and rotation, where the grid-aligned boxes of `cpdi` do not. Both
shapes are equal where F is diagonal, and always in 1D.

Only a corner's weights are products over the directions, so the transfers go from corner to corner,
see `pgimp.kernels.transfer.corners`. A support has at most four vertices a direction. If a
parallelogram extends over more than a cell to either side along a grid direction, it is shrunk to
a cell. The log counts such particles.
"""

from typing import Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.jit.kernel import exact
from pgimp.physics.shapes.base import WideShape
from pgimp.physics.shapes.cpdi import CpdiParameters, FixedCpdiParameters
from pgimp.physics.shapes.stretch import LARGEST


@exact
def _extents(half, cell, F):
    """Half-widths of the deformed box's grid-aligned bounding box, sum_j |F_ij| l_j, in cells."""
    D = len(half)
    initial = tuple(half[d] * cell[d] for d in range(D))
    return tuple(sum(abs(F[D * i + j]) * initial[j] for j in range(D)) / cell[i] for i in range(D))


@exact
def _clamped(half, cell, F):
    """Half-widths limited to `LARGEST`, and the largest before the limit."""
    extents = _extents(half, cell, F)
    return tuple(min(each, LARGEST) for each in extents), max(extents)


@exact
def _half_edges(half, cell, F):
    """Vectors F e_j l_j, in cells, after shrinking."""
    D, extents = len(half), _extents(half, cell, F)
    # Factors of at most 1: LARGEST over an extent of zero would be infinite.
    inner = tuple(min(LARGEST / x, 1.0) / h for x, h in zip(extents, cell, strict=True))
    initial = tuple(half[d] * cell[d] for d in range(D))
    return tuple(tuple(F[D * i + j] * initial[j] * inner[i] for i in range(D)) for j in range(D))


class CpdiCornersParameters(NamedTuple):
    """Initial half-widths of the particles' boxes by direction, in cells; sides of a cell."""

    half: tuple[float, ...]
    cell: tuple[float, ...]

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 4

    @staticmethod
    def size(shape, cell, F):
        """Half-widths of the grid-aligned box around all corners."""
        return _clamped(shape.half, cell, F)

    @staticmethod
    def edges(shape, F):
        """Half edges of the parallelogram, each a tuple of components in cells."""
        return _half_edges(shape.half, shape.cell, F)


class CpdiCorners(WideShape):
    """Parallelograms whose corners move with the grid: large shear and rotation, with stretches."""

    shape: Literal["cpdi-corners"] = Field(description="name of the shape")

    in_cell: ClassVar[bool] = True
    vertices: ClassVar[int] = CpdiCornersParameters.vertices()
    ends: ClassVar[bool] = True

    @property
    def follows(self) -> bool:
        """See `Shape.follows`."""
        return True

    @property
    def separable(self) -> bool:
        """See `Shape.separable`."""
        return len(self.particles_per_cell) == 1

    def parameters(self, cell: tuple[float, ...]) -> Any:
        """Parameters of the kernels; in 1D of `cpdi`."""
        half = tuple(0.5 / n for n in self.particles_per_cell)
        return CpdiParameters(half) if self.separable else CpdiCornersParameters(half, tuple(cell))

    def fixed(self, cell: tuple[float, ...]) -> FixedCpdiParameters:
        """See `Shape.fixed`: undeformed boxes have the same corners as in `cpdi`."""
        return FixedCpdiParameters(tuple(0.5 / n for n in self.particles_per_cell))
