"""Elements of a surface of triangles in the boxes of the lattice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.geometry.regions.base import Region
from pgimp.geometry.rows import ascending
from pgimp.scene.bodies.elements import Elements, Indices
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surfaces.boxes import Closed, edge

#: Part of a box within which an element is on a face of the lattice.
_ROUNDING = 1e-9


def triangle_elements(
    body: LatticeBody, ranges: Sequence[Indices], closed: Closed, within: Region | None
) -> Elements | None:
    """Elements of a surface of triangles, cut along planes of the region; None for others."""
    edges, lattice, D = [], [], len(ranges)
    planes = within.planes() if within else []
    for d, r in enumerate(ranges):
        lattice.append(edge(body.edges[d], np.append(r, r[-1] + 1 if len(r) else 0)))
        cuts = [plane.at for plane in planes if plane.axis == d]
        own = [at for at in cuts if lattice[d][0] < at < lattice[d][-1]] if len(r) else []
        edges.append(np.unique(np.append(lattice[d], own)))
    pieces = body.region.facets(edges)
    if pieces is None:
        return None
    number, centre, area, second = pieces
    box, kept = np.empty_like(number), np.ones(len(number), bool)
    for d, r in enumerate(ranges):
        box[:, d] = np.searchsorted(lattice[d], edges[d][number[:, d]], "right") - 1 + r[:1].sum()
        for side in (-1, 1):
            if (d, side) in closed:
                end = body.edges[d][0 if side < 0 else -1]
                kept &= np.abs(centre[:, d] - end) > _ROUNDING * body.size[d]
    size = np.sqrt((area * area).sum(axis=1))
    normal = area / np.where(size > 0.0, size, 1.0)[:, None]
    found = Elements(
        box, centre, area, np.zeros((len(box), D, D)), np.full((len(box), D), 0.5) * body.size,
        (second * size[:, None])[:, :, None] * normal[:, None],
    )  # fmt: skip
    return found.chosen(np.flatnonzero(kept)[ascending(box[kept])])
