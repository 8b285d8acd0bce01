"""Shapes: the particle characteristic function that decides the method, one file each.

A shape is the entry of the case (a `Model`) whose ``parameters()`` gives a NamedTuple with two
kernels as static methods, both in units of cells along one direction:

- ``first(shape, d, xi)``: the first vertex of the support of a particle at `xi`;
- ``weights(shape, d, f)``: the weights S_vp (19) of the ``shape.vertices`` vertices of the support
  and their gradients (20) times the cell size; `f` is `xi` less the first vertex.
"""

from pgimp.shapes.gimp import Gimp
from pgimp.shapes.mpm import Mpm

#: The shapes by their name in the case, ``method: {shape: NAME}``.
SHAPES = {"mpm": Mpm, "gimp": Gimp}
