"""The part of a patch that presses on another body.

The weights of a patch say where it touches, see `pgimp.kernels.contact.surfaces.rows`. Between
curved surfaces that is a part of it, in its middle, although all of it presses. So the pressure is
taken as that under a footing: linear, without tension, with the force in the same line.
"""

from math import inf

from pgimp.jit.kernel import inner_kernel

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
def pressed_area(surface, every, first, last, side, least, cell):
    """Area of a patch under pressure, in the initial state.

    `every` are its facets, from `first` to `last`, with weights that add up to 1. Along each axis
    but that of its normal, a force within the middle third presses on all of it. One nearer to its
    end presses on three times the distance from there.
    """
    area, axis, most = 0.0, 0, 0.0
    for n in range(first, last):
        part = pressing(surface, every[n], side, least, cell)
        area += part
        if part > most:
            most = part
            for d in range(3):
                s = every[n].facet
                if abs(surface.normal[s, d]) > abs(surface.normal[s, axis]):
                    axis = d
    whole = area
    for d in range(3):
        low, high, at = inf, -inf, 0.0
        for n in range(first if d != axis else last, last):
            s = every[n].facet
            at += every[n].weight * surface.x[s, d]
            if pressing(surface, every[n], side, least, cell) > 0.0:
                low = min(low, surface.x[s, d] - surface.half[s, d])
                high = max(high, surface.x[s, d] + surface.half[s, d])
        if low < high:
            whole *= max(0.0, min(1.0, 3.0 * min(at - low, high - at) / (high - low)))
    return whole
