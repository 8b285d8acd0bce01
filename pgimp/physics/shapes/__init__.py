"""Shapes: the particle characteristic function chi_p that decides the method, one file each.

A shape is the entry of the case (a `Shape`) whose ``parameters(cell)`` gives a NamedTuple with
three kernels as static methods, in units of cells:

- ``vertices()``: vertices of a support along a direction.
- ``size(shape, cell, F)``: half-widths of chi_p by direction for a deformation gradient, at most 1;
  and the largest of them before this limit, 0 where sizes are constant. Above 1 the particle counts
  as clamped.
- ``weights(shape, half, f)``: weights S_vp (19) along one direction and their gradients (20) times
  the cell size, for the ``vertices`` vertices of the support. `f` is the particle's coordinate
  relative to the first vertex, floor(xi - half), so it lies in [half, half + 1).

Shapes whose weights are not products over the directions have ``edges(shape, F)`` in place of
``weights``: see `pgimp.physics.shapes.cpdi_corners`.
"""

from pgimp.physics.shapes.base import Shape
from pgimp.physics.shapes.bspline import BsplineCubic, BsplineQuadratic
from pgimp.physics.shapes.cpdi import Cpdi
from pgimp.physics.shapes.cpdi_corners import CpdiCorners
from pgimp.physics.shapes.finite_gimp import FiniteGimp
from pgimp.physics.shapes.fuzzy import FuzzyConstant, FuzzyNearest
from pgimp.physics.shapes.gimp import Gimp
from pgimp.physics.shapes.mpm import Mpm

#: The shapes by their name in the case, ``method: {shape: NAME}``.
SHAPES: dict[str, type[Shape]] = {
    "mpm": Mpm,
    "gimp": Gimp,
    "finite-gimp": FiniteGimp,
    "cpdi": Cpdi,
    "cpdi-corners": CpdiCorners,
    "bspline-quadratic": BsplineQuadratic,
    "bspline-cubic": BsplineCubic,
    "fuzzy-nearest": FuzzyNearest,
    "fuzzy-constant": FuzzyConstant,
}
