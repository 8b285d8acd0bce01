"""Elements of a body's surface in the boxes of the lattice, and the particles that carry them.

By the divergence theorem the area vector of the surface in a box is what the areas inside on the
box's faces lack of a closed surface. Its first moments follow from the volume inside and from the
moments of these areas. So all elements together close exactly, whatever the region. Elements are of
parts of lattice boxes, so that a load may begin and end within a box.
"""

from __future__ import annotations

import numpy as np

from pgimp.geometry.regions.base import Region
from pgimp.scene.bodies.elements import Elements
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surfaces.boxes import Closed
from pgimp.scene.bodies.surfaces.cut import cut_elements
from pgimp.scene.bodies.surfaces.triangles import triangle_elements
from pgimp.scene.bodies.surfaces.whole import whole_elements


def find_elements(
    body: LatticeBody, within: Region | None, planes: tuple[int, int], closed: Closed = ()
) -> Elements:
    """Find the elements of a body's surface within a region, in a range of lattice planes.

    Parameters
    ----------
    body : LatticeBody
        The body; its boxes are whole where surfaces do not cut them.
    within : Region or None
        Elements with their centroid in here count; None: all.
    planes : (int, int)
        First plane and end; elements there, and up to a box beyond the lattice, are found.
    closed : sequence of (axis, side)
        Faces of the lattice, low (-1) or high (1), behind which bodies go on: none is on these.
    """
    ranges = []
    least, most = (body.region if within is None else within).bounds()
    for d, (e, (begin, end)) in enumerate(zip(body.edges, body.box, strict=True)):
        # What a file has is empty where its particles exist already.
        at = np.clip((np.array([least[d], most[d]]) - e[0]) / body.size[d], -(2.0**60), 2.0**60)
        low = max(begin - 1, int(np.floor(at[0])) - 1, -1)
        high = min(end + 1, int(np.ceil(at[1])) + 1, len(e))
        if d == 0:
            low, high = max(low, planes[0]), min(high, planes[1])
        ranges.append(np.arange(low, max(low, high)))
        if (d, -1) in closed:
            ranges[d] = ranges[d][ranges[d] >= 0]
        if (d, 1) in closed:
            ranges[d] = ranges[d][ranges[d] < len(e) - 1]
    cuts = (body.region, *([within] if within else ())) if body.exact else ()
    facets = triangle_elements(body, ranges, closed, within) if body.exact else None
    if facets is not None:
        found = facets
    elif body.cut:
        found = cut_elements(body, ranges, closed, cuts)
    else:
        found = whole_elements(body, ranges, closed)
    if within is None or not len(found.box):
        return found
    return found.chosen(within.contains(found.centroid))
