"""Sides and levels of patches.

The gap G of a patch is a smooth least one of its facets' gaps g_k. A level s solves

    sum_k A_k max(0, s - g_k)^2 = A d^2,   G = s - d.

A_k are the facets' areas, A is the area of those that face the other body, and d a small length. G
is the gap itself where a patch and what it meets are parallel. Its derivatives are weights,
W_k ~ A_k max(0, s - g_k), which add up to 1.

Where a patch tilts, pressure p moves towards what is deepest: a spring against it, of p/d over an
area. Weights of a step are those at its begin, so that the spring is explicit. In a grid of cells h
it has omega^2 = 2 p/(3 rho h d) = a/(3 d), with the acceleration a of vertices at the surface by
even pressure. So d is a dt^2/2 at least: what contact keeps the patch from in a step.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inner_kernel
from pgimp.physics.contact.base import TIED

#: The least length d in cells, and over a dt^2 with the acceleration a that contact gives a patch.
FADES, FOLLOWS = 0.002, 0.5

#: Iterations for the level, at most, and the change over d that ends them.
_NEWTON, _EXACT = 40, 1e-12

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
def _side_of(surface, f):
    """Number of the side of facet `f`, by its normal in the initial state; 0 of walls."""
    if f < 0:
        return 0
    axis = 0
    for d in range(1, 3):
        if abs(surface.normal[f, d]) > abs(surface.normal[f, axis]):
            axis = d
    return 2 * axis + (1 if surface.normal[f, axis] > 0.0 else 0)


@inner_kernel
def find_sides(surface, every, first, last, near):
    """Set the sides of the other body that facets of a patch meet; returns the mask of these.

    The nearest facet's side has all those with normals like its own. Facets without a gap are on
    side -1; there is none unless a gap is below `near`.
    """
    mask = 0
    for n in range(first, last):
        every[n].side = -1
    while True:
        best, least = -1, near if mask == 0 else inf
        for n in range(first, last):
            if every[n].side < 0 and every[n].gap < least:
                least, best = every[n].gap, n
        if best < 0:
            return mask
        side = _side_of(surface, every[best].other)
        while mask >> side & 1:
            side += 6
        mask |= 1 << side
        for n in range(first, last):
            same = 0.0
            for d in range(3):
                same += every[n].normal[d] * every[best].normal[d]
            if n == best or (every[n].side < 0 and every[n].gap < inf and same > _ONE_SIDE):
                every[n].side = side


@inner_kernel
def level(surface, every, first, last, side, least, width):
    """Level of a patch above the least gap, by Newton's method from above."""
    near, whole, most, deepest = 0.0, 0.0, 0.0, least
    for n in range(first, last):
        area = surface.area[every[n].facet]
        most += area
        if every[n].side == side:
            whole += area * every[n].facing
            if every[n].gap <= least + width:
                near += area
                deepest = max(deepest, every[n].gap)
    whole = max(whole, _LEAST * most)
    s = deepest + width * sqrt(whole / near)  # all of these at the greatest of their gaps
    for _ in range(_NEWTON):
        value, slope = -whole * width * width, 0.0
        for n in range(first, last):
            if every[n].side != side:
                continue
            deep = max(0.0, s - every[n].gap)
            area = surface.area[every[n].facet]
            value += area * deep * deep
            slope += 2.0 * area * deep
        s -= value / slope
        if not value > _EXACT * width * slope:
            break
    return s


@inner_kernel
def share(surface, near, side, level, tied):
    """Weight of a facet in its patch; of tied ones `level` is where ties end."""
    if near.side != side or not near.gap < level:
        return 0.0
    area = surface.area[near.facet]
    return area if tied else area * (level - near.gap)
