"""Wide facets among those near others: where flat faces lie on each other, see `rectangles.py`."""

from __future__ import annotations

import numpy as np

from pgimp.geometry.rows import distinct
from pgimp.kernels.contact.impulses.pairs import SeparatingWalls
from pgimp.kernels.contact.surfaces.nearest import FLAT
from pgimp.solver.contact.surfaces.table import Table

#: Greatest relative error of areas of rectangles, and cosines' and places' of what is in a plane.
_EXACT = 1e-6

#: Least cosine between a normal and the opposite one of faces that lie on each other.
_PARALLEL = 1.0 - 1.25e-5

#: Cells by which neighbours of facets are apart at least, on the other side of a ring of them.
_RING = 0.25


def joined(table: Table, walls: SeparatingWalls, every: np.ndarray) -> np.ndarray:
    """Candidates, with wide facets where all parts lie on one plane; as of `find_candidates`.

    `every` are in order. Normals are those of this search: what tilts keeps small facets.
    """
    surface, count, (facet, body, other) = table.surface, len(table.wide), every.T
    some = np.flatnonzero(table.wide[facet] >= 0)
    if not len(some):
        return every
    f, o, wall = facet[some], other[some], body[some] - walls.first
    lies, before, on_wall = np.empty(len(some)), np.flatnonzero(o >= 0), np.flatnonzero(o < 0)
    axis, side = (walls.planes[name][wall[on_wall]] for name in ("axis", "side"))
    lies[on_wall] = surface.turned[f[on_wall], axis] * side
    same = np.einsum("ni,ni->n", surface.turned[f[before]], surface.turned[o[before]])
    lies[before] = np.where(surface.tip[o[before]] & FLAT, -same, 0.0)
    some = some[lies > _PARALLEL]
    if not len(some):
        return every
    wide, o = table.wide[facet[some]], other[some]
    first, of = distinct(np.column_stack([wide, body[some]]))
    before = np.flatnonzero(o >= 0)
    one, its, alike = o[first][of[before]], o[before], np.ones(len(o), bool)
    n, away = surface.normal[one], surface.x[its] - surface.x[one]
    alike[before] = np.einsum("ni,ni->n", n, surface.normal[its]) > 1.0 - _EXACT
    off = np.abs(np.einsum("ni,ni->n", n, away))
    alike[before] &= off < _EXACT * surface.radius[one]
    parts = np.bincount(table.wide[table.wide >= 0] - count)
    good = np.bincount(of, alike) == parts[wide[first] - count]
    order = np.argsort(of, kind="stable")
    begin = np.searchsorted(of[order], np.arange(len(first)))
    middle = order[begin + np.bincount(of) // 2]
    found, gone = every.copy(), np.zeros(len(every), bool)
    gone[some[good[of]]] = True
    kept = some[first[good]]
    gone[kept] = False
    found[kept, 0], found[kept, 2] = wide[first[good]], o[middle[good]]
    return found[~gone]


def parted(table: Table, every: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Candidates with the facets of wide ones in their place, and the number that each had."""
    count = len(table.wide)
    facets = np.flatnonzero(table.wide >= 0)
    facets = facets[np.argsort(table.wide[facets], kind="stable")]
    begin = np.searchsorted(table.wide[facets], np.arange(count, len(table.every.x) + 1))
    wide = every["facet"] - count
    parts = np.where(wide < 0, 1, np.diff(begin, append=begin[-1])[np.maximum(wide, 0)])
    row = np.repeat(np.arange(len(every)), parts)
    found = every[row]
    inside = np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts)
    some = wide[row] >= 0
    found["facet"][some] = facets[begin[wide[row[some]]] + inside[some]]
    return found, row


def moving_of(table: Table, every: np.ndarray, travel: float, moving: np.ndarray) -> np.ndarray:
    """Facets that are to be moved for some candidates, of those that may be; by patch.

    Near those next to others are all that may become so: bodies move by `travel` cells. If that is
    inf, all may.
    """
    surface, marks = table.surface, np.full(len(table.wide), travel == np.inf)
    near = every["other"][every["other"] >= 0]
    for _ in range(0 if marks.all() else 1 + int(np.ceil(2.0 * travel / _RING))):
        marks[near] = True
        first, count = surface.start[near], np.diff(surface.start)[near]
        row = np.repeat(first - np.cumsum(count) + count, count) + np.arange(count.sum())
        fresh = np.zeros(len(marks), bool)
        fresh[surface.beside[row]] = True
        near = np.flatnonzero(fresh & ~marks)
    marks[near] = True
    marks[every["facet"][every["facet"] < len(marks)]] = True
    wide = np.unique(every["facet"][every["facet"] >= len(marks)])
    found = np.concatenate([moving[marks[moving]], wide])
    return found[np.argsort(table.every.patch[found], kind="stable")]
