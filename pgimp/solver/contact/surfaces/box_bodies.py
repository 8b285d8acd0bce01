"""Surfaces of bodies of particles from files: those of their boxes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.regions.box import Box
from pgimp.mpi.communicator import Communicator
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.volume_fractions import VolumeFractions
from pgimp.solver.contact.impulses.messages import greatest, total, united
from pgimp.solver.rank_state import RankState

#: Part of a box by which particles on a lattice of their own are off it, at most.
_NEAR = 1e-6

#: A full box. Sums of whole numbers have the same bits in any order.
_FULL = 1 << 30


class BoxBody(LatticeBody):
    """Boxes of a lattice of their own, of which some are filled.

    Parameters
    ----------
    edges : list of (n + 1,) float64
        Coordinates of the boxes by direction.
    there : (n, ...) bool
        Mask of the filled ones.
    """

    def __init__(self, edges: list[NDArray[np.float64]], there: NDArray[np.bool_]) -> None:
        ends = (tuple(float(e[end]) for e in edges) for end in (0, -1))
        low, high = ends
        centres = [0.5 * (e[1:] + e[:-1]) for e in edges]
        super().__init__(Box(min=low, max=high), edges, centres, cut=False)
        self._there = there

    def slabs(self, planes: tuple[int, int]) -> Iterator[VolumeFractions]:
        """See `LatticeBody.slabs`."""
        first, last = max(planes[0], 0), min(planes[1], len(self._there))
        if first < last:
            whole = self._there[first:last].reshape(-1)
            none = np.zeros(0)
            ranges = [(first, last), *self.box[1:]]
            yield VolumeFractions(ranges, whole, none.astype(int), none, none[:, None])


def boxes_of(rank: RankState, body: int) -> BoxBody:
    """The boxes of a body's particles in the initial state; collective.

    Particles on a lattice of their own have its boxes. Those of others fill boxes of the domain's
    lattice in part: at least half full ones count, and those among such.
    """
    scene, comm, p = rank.scene, rank.comm, rank.population.columns
    frame, rows = scene.domain.frame, rank.population.order
    rows = rows[p.body[rows] == body]
    x, volume = p.origin[rows], p.V0[rows].copy()
    if scene.case.axisymmetric:  # of the sections of rings
        volume /= 2.0 * np.pi * np.maximum(x[:, 0], 1e-300)
    D, origin = x.shape[1], np.array(frame.origin)
    side = np.array(frame.cell) / scene.case.method.particles_per_cell
    most = greatest(comm, float(volume.max(initial=0.0)))
    side *= max(1.0, round((most / float(np.prod(side))) ** (1.0 / D)))
    low = np.array([-greatest(comm, float(-x[:, d].min(initial=1e300))) for d in range(D)])
    high = np.array([greatest(comm, float(x[:, d].max(initial=-1e300))) for d in range(D)])
    if not (low <= high).all():
        low = high = origin
    at = (x - low) / side
    off = greatest(comm, float(np.abs(at - np.rint(at)).max(initial=0.0)))
    if off < _NEAR:
        begin, number = low - 0.5 * side, np.rint(at).astype(np.int64)
        there = np.zeros(np.rint((high - low) / side).astype(np.int64) + 1, np.uint8)
        there[tuple(number.T)] = 1
        filled = united(comm, there).astype(bool)
    else:
        first = np.maximum(np.floor((low - origin) / side - 0.5), 0.0)
        begin = origin + first * side
        count = np.ceil((high - begin) / side + 0.5).astype(np.int64)
        ends = np.ceil((origin + frame.cells * np.array(frame.cell) - begin) / side - _NEAR)
        filled = _filled(comm, (x - begin) / side, volume / most, np.minimum(count, ends))
    edges = []
    for d, n in enumerate(filled.shape):
        planes = origin[d] + np.arange(frame.cells[d] + 1) * frame.cell[d]
        own, far = begin[d] + np.arange(-1, n + 2) * side[d], _NEAR * frame.cell[d]
        # What does not end at a face of the domain goes on empty; no facet crosses the grid.
        own = own[int(own[1] < planes[0] + far) : n + 3 - int(own[-2] > planes[-1] - far)]
        every = np.sort(np.concatenate([own, planes[(planes > own[0]) & (planes < own[-1])]]))
        every = every[np.diff(every, prepend=-np.inf) > far]
        number = np.floor((0.5 * (every[1:] + every[:-1]) - begin[d]) / side[d]).astype(np.int64)
        inside = (number >= 0) & (number < n)
        filled = np.take(filled, np.clip(number, 0, n - 1), axis=d)
        filled &= inside.reshape([-1 if e == d else 1 for e in range(D)])
        edges.append(every)
    return BoxBody(edges, filled)


def _filled(
    comm: Communicator, at: np.ndarray, part: np.ndarray, count: np.ndarray
) -> NDArray[np.bool_]:
    """Mask of the boxes that are half full, or between such, given places in boxes; collective."""
    D, count = at.shape[1], count.astype(np.int64)
    first = np.floor(at - 0.5).astype(np.int64)
    away = at - 0.5 - first
    sums = np.zeros(count, np.int64)
    for corner in product((0, 1), repeat=D):
        w = np.prod(np.where(corner, away, 1.0 - away), axis=1) * part
        number = first + corner
        some = ((number >= 0) & (number < count)).all(axis=1)
        np.add.at(sums, tuple(number[some].T), np.rint(_FULL * w[some]).astype(np.int64))
    filled = total(comm, sums) >= _FULL // 2
    wide, between = np.pad(filled, 1), np.ones(filled.shape, bool)
    for d in range(D):
        for shift in (-1, 1):
            between &= np.roll(wide, shift, axis=d)[(slice(1, -1),) * D]
    return filled | between
