"""Wide facets: those of a flat face in a cell, as one, where another flat face is before them.

Weights of a patch are means over its facets, by their second moments, see
`pgimp.kernels.contact.surfaces.spread`. So a rectangle has exact ones, whatever it is made of. Near
edges, rows of facets along these tell where a patch touches; at corners and before what is not
flat, small facets do.
"""

from __future__ import annotations

import numpy as np

from pgimp.geometry.rows import distinct
from pgimp.kernels.contact.surfaces.data import Surface
from pgimp.kernels.contact.surfaces.nearest import WIDE
from pgimp.scene.bodies.surface_patches import radius_of

#: Greatest relative error of areas of rectangles, and of cosines of what is in a plane.
_EXACT = 1e-6

#: Cells by which facets of a row are off it, at most; likewise for vectors across their edge.
_ROW = 1e-3


def with_wide(
    surface: Surface, edges: tuple[np.ndarray, np.ndarray], cell: np.ndarray, number: np.ndarray
) -> tuple[Surface, np.ndarray]:
    """Facets, and after them wide ones; the wide one that each facet is part of, or -1.

    Parameters
    ----------
    surface : Surface
        The facets of all bodies.
    edges : ((n,) bool, (n, 3) float64)
        Whether they are in a plane, and not at its edges; else unit vectors towards the only edge.
    cell : (D,) float64
        Sides of a cell.
    number : (n, D) int64
        Numbers of the cells that they are in.
    """
    D, wide, (inside, towards) = len(cell), np.full(len(surface.x), -1), edges
    flat = np.flatnonzero(inside | towards.any(axis=1))
    if D < 3 or not len(flat):
        return surface, wide
    away = np.rint((towards * surface.x).sum(axis=1) / (_ROW * cell.min()))
    rows = np.column_stack([np.rint(towards / _ROW), away]).astype(np.int64)
    first, of = distinct(np.column_stack([surface.patch, surface.cell, number, rows])[flat])
    own, order = flat[first], np.argsort(of, kind="stable")
    begin = np.searchsorted(of[order], np.arange(len(first)))

    def sums(values: np.ndarray) -> np.ndarray:
        """Sums over the facets of each wide one."""
        return np.add.reduceat(values[order], begin)

    part, its = surface.area[flat], surface.edges[flat]
    area = sums(part)
    x = sums(part[:, None] * surface.x[flat]) / area[:, None]
    way = surface.x[flat] - x[of]
    square = way[:, :, None] * way[:, None] + (its.transpose(0, 2, 1) @ its) / 3.0
    moments = sums(part[:, None, None] * square) / area[:, None, None]
    normal, both = surface.normal[own], np.zeros((len(own), 2, 3))
    # Of slivers without a width nothing is known: they are as small as they are.
    with np.errstate(invalid="ignore", divide="ignore"):
        b = surface.edges[own, 1]
        b = b / np.sqrt((b * b).sum(axis=1))[:, None]
        a = np.cross(b, normal)
        along, skew, across = (
            3.0 * np.einsum("ki,kij,kj->k", *each) for each in ((a, moments, a), (a, moments, b),
                                                               (b, moments, b))
        )  # fmt: skip
        along = np.sqrt(along)
        skew /= along
        across = np.sqrt(np.maximum(across - skew**2, 0.0))
        both[:, 0], both[:, 1] = along[:, None] * a + skew[:, None] * b, across[:, None] * b
    low = np.minimum.reduceat((surface.middle - surface.half)[flat[order]], begin)
    high = np.maximum.reduceat((surface.middle + surface.half)[flat[order]], begin)
    same = np.minimum.reduceat((surface.normal[flat] * normal[of]).sum(axis=1)[order], begin)
    good = (np.bincount(of) > 1) & (same > 1.0 - _EXACT)
    good &= np.abs(4.0 * along * across - area) < _EXACT * area
    wide[flat] = np.where(good, len(wide) + np.cumsum(good) - 1, -1)[of]
    own = own[good]
    place = surface.place[own]
    place[:, :D] += (x[good] - surface.x[own])[:, :D] / cell
    more = {
        "x": x[good], "middle": 0.5 * (low + high)[good], "half": 0.5 * (high - low)[good],
        "area": area[good], "radius": radius_of(area[good], D), "place": place,
        "edges": both[good], "tip": surface.tip[own] | WIDE,
        "start": np.full(len(own), surface.start[-1]),
    }  # fmt: skip
    found = {
        name: np.concatenate([values, more[name] if name in more else values[own]])
        for name, values in surface._asdict().items() if name not in ("beside", "periods")
    }  # fmt: skip
    return surface._replace(**found), wide
