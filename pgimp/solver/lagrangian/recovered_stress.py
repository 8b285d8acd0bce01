"""Stress at any point of bodies in the initial configuration, recovered from particles near it.

Stresses of particles have an error of first order, as they are even over a cell along one direction
or another. That is opposite on both sides of the cell's middle, so that a linear function through
them has little of it. It is a recovery as that of Zienkiewicz and Zhu (Int. J. Numer. Meth. Engng
33, 1331-1364, 1992).
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from pgimp.kernels.sums.recovered_stress import fit_stresses
from pgimp.solver.lagrangian.pieces import source_at
from pgimp.solver.rank_state import RankState

#: Tags of messages with particles near the ends of slabs.
_UP, _DOWN = 27, 28


class _Near(NamedTuple):
    """Particles that count: those of a rank, and of others near its ends."""

    x: np.ndarray  #: (n, D) float64: Undeformed places, in cells from the grid's origin.
    body: np.ndarray  #: (n,) int64: Body.
    id: np.ndarray  #: (n,) int64: Number.
    volume: np.ndarray  #: (n,) float64: Initial volume.
    sigma: np.ndarray  #: (n, S) float64: Stress.


def recovered_at(rank: RankState, rows: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Stresses where particles in `rows` of a rank are, in the order `wanted` of rows; collective.

    Those of all are found, in any order of rows. Returns (n, 6).
    """
    p = rank.population.columns
    found = np.zeros((p.capacity, 6))
    stress = recovered_stresses(rank, p.origin[rows], p.body[rows])
    found[rows, : stress.shape[1]] = stress
    return found[wanted]


def recovered_stresses(rank: RankState, x: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Stresses at undeformed places of bodies, (n, S); collective.

    Parameters
    ----------
    x : (n, D) float64
        The places, each in a cell of the rank's particles or beside one.
    body : (n,) int
        Their bodies.
    """
    frame = rank.scene.domain.frame
    points = (x - np.array(frame.origin)) * np.array(frame.inverse)
    near = _gather(rank)
    sizes = [cells + 4 for cells in frame.cells]
    keys = _keys(near.x, near.body, sizes)
    order = np.lexsort((near.id, keys))
    x, volume, sigma, keys = (a[order] for a in (near.x, near.volume, near.sigma, keys))

    own = _keys(points, body, sizes)
    sorting = np.argsort(own, kind="stable")
    cells, first = np.unique(own[sorting], return_index=True)
    strides = np.cumprod([1, *sizes[:0:-1]])[::-1]
    runs = []
    for steps in product((-1, 0, 1), repeat=len(sizes) - 1):
        middle = cells + int(np.dot(steps, strides[:-1]))
        begin = np.searchsorted(keys, middle - 1, side="left")
        end = np.searchsorted(keys, middle + 1, side="right")
        runs.append(np.stack([begin, end], axis=1))
    found, given = np.zeros((len(points), sigma.shape[1])), np.ascontiguousarray(points[sorting])
    first = np.append(first, len(points)).astype(np.int64)
    work = np.zeros((1 + points.shape[1], 1 + points.shape[1] + sigma.shape[1]))
    fit_stresses(given, first, np.stack(runs, axis=1), x, volume, sigma, work, found)
    result = np.empty_like(found)
    result[sorting] = found
    return result


def _keys(x: np.ndarray, body: np.ndarray, sizes: list[int]) -> np.ndarray:
    """Numbers of the cells of bodies with places, those along the last direction in a row."""
    found = body.astype(np.int64)
    number = np.floor(x).astype(np.int64)
    for d, size in enumerate(sizes):
        found = found * size + np.clip(number[:, d] + 2, 1, size - 2)
    return found


def _gather(rank: RankState) -> _Near:
    """The particles of a rank, and those of its neighbours near its ends; collective."""
    population, slab, comm = rank.population, rank.slab, rank.comm
    p, order, frame = population.columns, population.ordered, rank.scene.domain.frame
    shared = rank.scene.settings.vertices - 1

    def chosen(layers: slice) -> _Near:
        start = order.start[layers]
        rows = order.rows[start[0] : start[-1]] if len(start) else order.rows[:0]
        x = (p.origin[rows] - np.array(frame.origin)) * np.array(frame.inverse)
        sigma = source_at(rank, rows).take("sigma")
        return _Near(x, p.body[rows].astype(np.int64), p.id[rows], p.V0[rows], sigma)

    parts, requests = [chosen(slice(None))], []
    lower = slab.lower if slab.lower is not None and slab.lower < comm.rank else None
    upper = slab.upper if slab.upper is not None and slab.upper > comm.rank else None
    if lower is not None:
        requests.append(comm.isend(tuple(chosen(slice(shared + 1))), lower, _DOWN))
    if upper is not None:
        requests.append(comm.isend(tuple(chosen(slice(-shared - 1, None))), upper, _UP))
    for neighbour, tag in ((lower, _UP), (upper, _DOWN)):
        if neighbour is not None:
            parts.append(_Near(*comm.recv(source=neighbour, tag=tag)))
    for request in requests:
        request.wait()
    return _Near(*(np.concatenate(each) for each in zip(*parts, strict=True)))
