"""The part of a patch that presses on another body.

The weights of a patch say where it touches, see `pgimp.kernels.contact.surfaces.patches.rows`.
Between curved surfaces that is a part of it, in its middle, although all of it presses. So the
pressure is taken as that under a footing: linear, without tension, with the force in the same line.
"""

from math import inf

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.surfaces.patches.levels import FACET, FACING, GAP, WEIGHT

#: Cells by which gaps of facets under pressure are above the least of their patch, at most: the
#: sagitta of a cell on a disk with a radius of two cells.
_TOUCHING = 0.06


@inner_kernel
def facing_part(same):
    """Part of a facet that faces the other body: 1 if parallel, little where it is askew.

    `same` is the cosine between its normal and that of the other body.
    """
    square = same * same
    return square * square * square * square if same < 0.0 else 0.0


@inner_kernel
def pressing(surface, near, side, least, cell):
    """Area of a facet as far as it may press, given the least gap of its patch on a side."""
    if near.side != side or not near.gap < least + _TOUCHING * cell:
        return 0.0
    return surface.area[near.facet] * near.facing


@inner_kernel
def pressed_area(surface, own, numbers, count, least, cell):
    """Area of a patch under pressure, in the initial state.

    `own`, `numbers` and `count` are as of `gather`, with weights that add up to 1. Along each axis
    but that of its normal, a force within the middle third presses on all of it. One nearer to its
    end presses on three times the distance from there.
    """
    area, most, greatest = 0.0, 0.0, -1
    low, high, at = (inf, inf, inf), (-inf, -inf, -inf), (0.0, 0.0, 0.0)
    for m in range(count):
        s, w, part = numbers[FACET, m], own[WEIGHT, m], own[FACING, m]
        x, half = surface.x[s], surface.half[s]
        at = (at[0] + w * x[0], at[1] + w * x[1], at[2] + w * x[2])
        if not (own[GAP, m] < least + _TOUCHING * cell and part > 0.0):
            continue
        area += part
        if part > most:
            most, greatest = part, s
        low = (
            min(low[0], x[0] - half[0]), min(low[1], x[1] - half[1]), min(low[2], x[2] - half[2])
        )  # fmt: skip
        high = (
            max(high[0], x[0] + half[0]), max(high[1], x[1] + half[1]), max(high[2], x[2] + half[2])
        )  # fmt: skip
    axis = 0
    for d in range(3):
        if greatest >= 0 and abs(surface.normal[greatest, d]) > abs(surface.normal[greatest, axis]):
            axis = d
    for d in range(3):
        if d != axis and low[d] < high[d]:
            nearest = min(at[d] - low[d], high[d] - at[d])
            area *= max(0.0, min(1.0, 3.0 * nearest / (high[d] - low[d])))
    return area
