"""Sides and levels of patches.

The gap G of a patch is a smooth least one of its facets' gaps g_k. A level s solves

    sum_k A_k max(0, s - g_k)^2 = A d^2,   G = s - d.

A_k are the facets' areas, A is the area of those that face the other body, and d a small length. G
is the gap itself where a patch and what it meets are parallel. Its derivatives are weights,
W_k ~ A_k max(0, s - g_k), which add up to 1.

Where a patch tilts, pressure p moves towards what is deepest: a spring against it, of p/d over an
area. Weights of a step are those at its begin, so that the spring is explicit. In a grid of cells h
it has omega^2 = 2 p/(3 rho h d) = a/(3 d), with the acceleration a of vertices at the surface by
even pressure. So d is a dt^2/4 at least, with the acceleration a that contact gave the patch in the
last step; or much more in this one, if a patch begins to touch: what ends the way beyond its gap.
The gap has the least d: a constraint that changes as d does would take energy.
"""

from math import inf, sqrt

from numpy import int64

from pgimp.jit.kernel import inner_kernel
from pgimp.jit.vectors.lanes import sum_of
from pgimp.jit.vectors.rows import load_row
from pgimp.jit.vectors.simd import lane, vector, where
from pgimp.kernels.contact.surfaces.nearest import SIDE
from pgimp.physics.contact.base import TIED

#: The least length d in cells, and over a dt^2 with the acceleration a that contact gives a patch.
FADES, FOLLOWS = 0.002, 0.25

#: Iterations for the level, at most, and the relative error of its root that ends them.
_NEWTON, _EXACT = 40, 1e-13

#: Rows of what is gathered of the facets on a side: gap, area, the part of it that faces the other
#: body, weight. Whole numbers: which candidate it is, and its facet.
GAP, AREA, FACING, WEIGHT, GATHERED = range(5)
NUMBER, FACET, NUMBERED = range(3)

#: Least area A, in areas of the patch.
_LEAST = 0.03

#: Cells of gap above which a patch has no pair. Over the way by which it comes nearer in the step
#: the gap above which it has none either, and cells of gap at which it always has one.
NEAR, SOON, TOUCHES = 0.25, 4.0, 1e-3

#: Least cosine between normals on one side of a body.
_ONE_SIDE = 0.7


@inner_kernel
def end_of_patch(surface, every, first):
    """The end of the facets of a patch near one body, from the first one on."""
    last, body, patch = first + 1, every[first].body, surface.patch[every[first].facet]
    while last < len(every):
        if every[last].body != body or surface.patch[every[last].facet] != patch:
            return last
        last += 1
    return last


@inner_kernel
def entry_of(pairs, a, b):
    """Entry of the law of two bodies, 0 without one, and whether b comes first."""
    entry, swapped = pairs.entry[min(a, b), max(a, b)], a > b
    return (entry, swapped) if entry >= 0 else (-entry, not swapped)


@inner_kernel
def law_of(pairs, a, b, cell, way):
    """As `entry_of`, and the gap from which on two bodies do not act on each other.

    `cell` is the least side of a cell, `way` the one by which they may come nearer in a step; below
    0 every gap matters.
    """
    entry, swapped = entry_of(pairs, a, b)
    if entry == 0:
        return entry, swapped, 0.0
    near = NEAR * cell
    if pairs.kind[entry - 1] != TIED:
        soon = SOON * way + TOUCHES * cell if way >= 0.0 else near
        near = max(min(near, soon), pairs.adhesion[entry - 1, 2])
    return entry, swapped, near


@inner_kernel
def find_sides(surface, every, first, last, near):
    """Set the sides of the other body that facets of a patch meet; returns the mask of these.

    The nearest facet's side has all those with normals like its own. Facets without a gap are on
    side -1; there is none unless a gap is below `near`.
    """
    mask, best, least = 0, -1, near
    for n in range(first, last):
        every[n].side = -1
        if every[n].gap < least:
            least, best = every[n].gap, n
    while best >= 0:
        f, side = every[best].other, 0  # that of walls
        if f >= 0:
            side = int64(surface.tip[f] >> SIDE)  # type: ignore[assignment]
        while mask >> side & 1:
            side += 6
        mask |= 1 << side
        of, best, least = every[best].normal, -1, inf
        for n in range(first, last):
            one = every[n]
            if one.side >= 0 or not one.gap < inf:
                continue
            same = one.normal[0] * of[0] + one.normal[1] * of[1] + one.normal[2] * of[2]
            if same > _ONE_SIDE:
                one.side = side
            elif one.gap < least:
                least, best = one.gap, n
    return mask


@inner_kernel
def gather(surface, group, side, own, numbers):
    """Gather the facets of a patch on a side; clears all weights.

    Parameters
    ----------
    group : (array, int, int)
        Candidates, and of these the first one and the end of the patch's.
    own : (GATHERED, room) float64
        Set; nothing more up to a multiple of four.
    numbers : (NUMBERED, room) int64
        Set.

    Returns
    -------
    tuple of int, float, int
        How many there are, the area of the whole patch, and the candidate with the least gap.
    """
    (every, first, last), found, deepest = group, 0, -1
    for n in range(first, last):
        near = every[n]
        area, near.weight = surface.area[near.facet], 0.0
        if near.side == side:
            if deepest < 0 or near.gap < every[deepest].gap:
                deepest = n
            numbers[NUMBER, found], numbers[FACET, found] = n, near.facet
            own[GAP, found], own[AREA, found] = near.gap, area
            own[FACING, found], own[WEIGHT, found] = area * near.facing, 0.0
            found += 1
    for m in range(found, found + -found % 4):
        own[GAP, m], own[AREA, m], own[FACING, m] = inf, 0.0, 0.0
    return found, surface.whole[every[first].facet], deepest


@inner_kernel
def level(own, count, whole, least, width):
    """Level of a patch above the least gap, by Newton's method from above for the equation's root.

    `own` and `count` are as of `gather`, `whole` is the area of the patch.
    """
    if count == 1:
        return least + width * sqrt(max(own[FACING, 0], _LEAST * whole) / own[AREA, 0])
    near, facing, deepest = vector(0.0), vector(0.0), vector(least)
    for m in range(0, count, 4):
        gap, area = load_row(own, GAP, m), load_row(own, AREA, m)
        touches = gap <= least + width
        near = near + where(touches, area, 0.0)
        deepest = where(touches & (gap > deepest), gap, deepest)
        facing = facing + load_row(own, FACING, m)
    most = max(max(lane(deepest, 0), lane(deepest, 1)), max(lane(deepest, 2), lane(deepest, 3)))
    facing = max(sum_of(facing), _LEAST * whole)
    s, aim = most + width * sqrt(facing / sum_of(near)), width * sqrt(facing)
    for _ in range(_NEWTON):
        square, slope = vector(0.0), vector(0.0)
        for m in range(0, count, 4):
            deep = s - load_row(own, GAP, m)
            deep = where(deep > 0.0, deep, 0.0)
            part = load_row(own, AREA, m) * deep
            square, slope = part * deep + square, slope + part
        root = sqrt(sum_of(square))
        s -= (root - aim) * root / sum_of(slope)
        if not root - aim > _EXACT * aim:
            break
    return s
