"""B-splines of second and third order, as in other codes: chi_p is as wide as a cell.

The quadratic weight is the grid's tent averaged over a box of one cell. This is gimp's weight (40)
with a half-width of half a cell for any particles per cell. The cubic weight is the tent averaged
over a tent of one cell to either side, as for a fuzzy particle of constant size. So both use the
kernels of these shapes. Weights are smooth, once and twice differentiable. The particles of a cell
overlap, so there is little cell-crossing noise.

The price is a blurred surface. Inside a body the chi_p add up to one. At its surface they fall to
zero over a cell, half of it outside; the mass stays exact. At faces with a condition
``wall: mirror`` reflects the part beyond, so that the body ends at the face. At free surfaces a
fixed support has no remedy: bending is too soft, see ``docs/methods.md``.
"""

from typing import ClassVar, Literal

from pydantic import Field

from pgimp.physics.shapes.base import WideShape, beyond_walls
from pgimp.physics.shapes.fuzzy import FixedFuzzyParameters
from pgimp.physics.shapes.gimp import GimpParameters


class BsplineQuadratic(WideShape):
    """Quadratic B-splines (boxes of one cell, which overlap): quiet; soft at free surfaces."""

    shape: Literal["bspline-quadratic"] = Field(description="name of the shape")
    wall: Literal["ghost", "mirror", "auto"] = beyond_walls("mirror")

    vertices: ClassVar[int] = GimpParameters.vertices()

    def parameters(self, cell: tuple[float, ...]) -> GimpParameters:
        """Parameters of the kernels: l_p = L/2."""
        return GimpParameters(tuple(0.5 for _ in self.particles_per_cell))


class BsplineCubic(WideShape):
    """Cubic B-splines (tents of one cell, of constant size): quietest; softer still."""

    shape: Literal["bspline-cubic"] = Field(description="name of the shape")
    wall: Literal["ghost", "mirror", "auto"] = beyond_walls("mirror")

    vertices: ClassVar[int] = FixedFuzzyParameters.vertices()
    chi: ClassVar[Literal["point", "box", "tent"]] = "tent"
    wide: ClassVar[bool] = True
    stable_pointwise: ClassVar[float] = 0.9

    def parameters(self, cell: tuple[float, ...]) -> FixedFuzzyParameters:
        """Parameters of the kernels: d = L."""
        return FixedFuzzyParameters(tuple(1.0 for _ in self.particles_per_cell))
