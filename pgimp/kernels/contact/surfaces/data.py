"""Surfaces of bodies for the kernels of contact: facets, patches, and the grid's cells there."""

from math import floor
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.kernel import inlined, inner_kernel, is_array
from pgimp.jit.memory import structure
from pgimp.kernels.data.particles import FloatArray, IntArray

#: A facet near another body, in a step: the facet, the other body, its facet next to the first one,
#: and the number of the other body's side there, see `find_patch_pairs`. Then the gap between both,
#: the facet's weight in its patch, the part that faces the other body, see `facing_part`, and the
#: normal there, out of the other body. Then the place of its centroid in the other body's cell.
#: Half-edges there, and an offset of the place, in cells, are those of facets that touch, see
#: `pgimp.kernels.contact.surfaces.spread`; zero of others. Last the first and the number of its
#: `Pieces` that are kept; none if they have to be found again. What walls need is together.
NEAR_FACET = structure(
    ("facet", "i8"),
    ("body", "i8"),
    ("other", "i8"),
    ("side", "i8"),
    ("gap", "f8"),
    ("weight", "f8"),
    ("facing", "f8"),
    ("normal", "f8", 3),
    ("place", "f8", 3),
    ("piece", "i8"),
    ("pieces", "i8"),
    ("edges", "f8", (2, 3)),
    ("offset", "f8", 3),
)


#: What is known of a patch since the facets next to it were found: the way by which its gaps were
#: from closing. From `PLACE` on the vector from the other body's facet to its middle one, and the
#: deformation gradients of both. They do not matter of patches that touch and move.
CLEAR, PLACE, KNOWN = 0, 1, 22

#: More than any length; checkpoints have finite numbers. The first number from `PLACE` on is this
#: where these do not matter.
FAR = 1e300


class Surface(NamedTuple):
    """The facets of all bodies, by patch, see `pgimp.scene.bodies.surface_patches.Facets`."""

    #: x, normal, middle, half: (n, 3) float64.
    x: FloatArray
    normal: FloatArray
    middle: FloatArray
    half: FloatArray
    area: FloatArray  #: (n,) float64.
    radius: FloatArray  #: (n,) float64: Radii of discs of these sizes, half-lengths in 2D.
    patch: IntArray  #: (n,) int64.
    whole: FloatArray  #: (n,) float64: Area of the patch.
    body: IntArray  #: (n,) int64: Bodies; rigid ones come after the others.
    cell: IntArray  #: (n,) int64: Numbers in `SurfaceCells`; -1 on rigid bodies.
    place: FloatArray  #: (n, 3) float64: Places in the cells, in cells from their first vertices.
    #: (n, 2, 3) float64: Half-edges of parallelograms with their second moments.
    edges: FloatArray
    #: (n,): Marks: `TIP` beside a sharp edge, where both bodies' facets look; see `nearest`.
    tip: NDArray[np.uint8]
    #: start, beside: (n + 1,) and (k,) int64: Neighbours of each facet.
    start: IntArray
    beside: IntArray
    #: now, turned: (n, 3) float64: Centroids and unit normals in this step, where they matter.
    now: FloatArray
    turned: FloatArray
    extent: FloatArray  #: (n, 2, 3) float64: Likewise half-edges.
    #: (n, 2^D) float64: Means of the weights of its cell's vertices over each facet.
    means: FloatArray
    #: (3,) float64 or (): Period by direction, 0 where there is none; () if no face is periodic.
    periods: Any


class SurfaceCells(NamedTuple):
    """The cells of the bodies' own grids that facets are in."""

    low: FloatArray  #: (m, 3) float64: Coordinates of their first vertices.
    corners: IntArray  #: (m, 2^D) int64: Their vertices, as numbers of surface vertices.
    #: start, column: (m + 1,) and (k,) int64: The vertices that move those, themselves or masters.
    start: IntArray
    column: IntArray
    weight: FloatArray  #: (k, 2^D) float64: Weights of each at the cell's vertices.
    beside: IntArray  #: (m, 6) int64: Cells below and above along each direction, or -1.
    #: (m,) bool: Whether the vertices move themselves: their weights are those of the unit matrix.
    plain: NDArray[np.bool_]


class Patches(NamedTuple):
    """Patches near another body, and which of them matter in a step."""

    start: IntArray  #: (patches + 1,) int64: The first facet near the body of each.
    awake: IntArray  #: (k,) int64: Numbers of those that may have a pair, ascending.
    walks: NDArray[np.uint8]  #: (k,): 1 where facets next to them are to be found anew.
    ways: FloatArray  #: (k,) float64: Ways by which bodies may come nearer there in a step.
    #: (patches, KNOWN) float64: What is known of each.
    known: FloatArray

    @classmethod
    def of(cls, surface: Surface, every: NDArray, way: float = 0.0) -> Self:
        """The patches of facets near other bodies, by patch and body; all of them matter."""
        patch, body = surface.patch[every["facet"]], every["body"]
        begin = np.flatnonzero(np.diff(patch, prepend=-1) | np.diff(body, prepend=-1))
        awake = np.arange(len(begin))
        ways = np.full(len(begin), way)
        known = np.zeros((len(begin), KNOWN))
        known[:, CLEAR] = -FAR
        return cls(np.append(begin, len(every)), awake, np.ones(len(begin), np.uint8), ways, known)

    def first(self, count: int) -> Self:
        """With only the first ones of those that are awake."""
        return self._replace(
            awake=self.awake[:count], walks=self.walks[:count], ways=self.ways[:count]
        )


@inner_kernel
def least_side(frame):
    """Least side of a cell."""
    cell = frame.cell[0]
    for d in range(len(frame.cell)):
        cell = min(cell, frame.cell[d])
    return cell


@inlined
def turns(surface, way, d):
    """Length of the whole periods in a component `d` of a vector, so that the rest is shortest."""
    if is_array(surface.periods):
        return _whole(way, surface.periods[d])
    return 0.0


@inner_kernel
def _whole(way, period):
    """Length of the whole periods nearest to a length."""
    return floor(way / period + 0.5) * period if period > 0.0 else 0.0


def no_facets(count: int) -> NDArray:
    """Allocate for so many facets near other bodies."""
    return np.empty(count, NEAR_FACET)
