"""Cells around facets near material, and the vertices there that may move it: for several steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.material.particles import (
    Region,
    find_near_clusters,
    mark_cells,
    number_region,
    room_for_vertices,
)
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.impulses.messages import united
from pgimp.solver.contact.surfaces.proximity import TRAVEL
from pgimp.solver.rank_state import RankState

#: Cells from a facet within which particles count.
_WITHIN = 2.0


class NearRegion:
    """The cells around facets near material, found again and again.

    Parameters
    ----------
    slot : (bodies,) int64
        Numbers of the velocity fields of bodies that facets meet, among these; -1 of others.

    Attributes
    ----------
    region : Region
        See there.
    cells : int
        Number of its cells.
    numbers : (n, 4) int64
        Its vertices along x, y, z, and their slots.
    """

    def __init__(self, scene: Scene, comm: Communicator, slot: np.ndarray) -> None:
        self.scene, self.comm, self.call, self._slot = scene, comm, Bound(), slot
        self._periods = np.zeros(3, np.int64)
        joined = np.array(scene.domain.periodic, bool)
        self._periods[: scene.dimension] = joined * np.array(scene.domain.frame.cells)
        self.region: Region
        self.cells, self.numbers = 0, np.empty((0, 4), np.int64)

    def find(self, rank: RankState, low: np.ndarray, high: np.ndarray, order: Any) -> np.ndarray:
        """Find the boxes with material in and around them, (n,) bool; collective.

        Parameters
        ----------
        low, high : (n, D) float64
            Ends of the boxes.
        order : (n,) int32
            The rank's particles.
        """
        frame, D, call = self.scene.domain.frame, self.scene.dimension, self.call
        origin, inverse = np.array(frame.origin), np.array(frame.inverse)
        away, periods = _WITHIN + 2.0 * TRAVEL, self._periods
        ends = np.zeros((2, len(low), 3))
        ends[0, :, :D] = np.floor((low - origin) * inverse - away)
        ends[1, :, :D] = np.floor((high - origin) * inverse + away)
        most = np.ones(3)
        most[:D] = frame.cells
        joined = periods > 0
        there = np.isfinite(ends).all(axis=(0, 2))
        there &= ((ends[0] <= most) | joined).all(axis=1) & ((ends[1] >= -1.0) | joined).all(axis=1)
        cells = np.where(joined, ends[:, there], np.clip(ends[:, there], -1.0, most))
        cells = np.ascontiguousarray(cells.astype(np.int64))
        # Of boxes longer than a period every cell is once.
        cells[1] = np.where(joined, np.minimum(cells[1], cells[0] + periods - 1), cells[1])
        first, last = cells
        corner = np.where(joined, 0, first.min(axis=0, initial=2**40) if len(first) else 0)
        extent = np.where(joined, periods, last.max(axis=0, initial=-1) - corner + 1)
        slots = 1 + int(self._slot.max(initial=-1))
        number = room_for_vertices(extent, periods, D, slots)
        self.region = Region(corner, periods, np.full(extent, -1), number, self._slot)
        marks = np.zeros((*extent, slots), np.uint8)
        call(mark_cells, frame, self.region, rank.population.up_to_date(), order, marks)
        marks = united(self.comm, marks)
        found = np.zeros(len(first), np.uint8)
        call(find_near_clusters, cells, self.region, marks, found)
        # Both sizes are one tuple: vertices as they are asked for, cells with them.
        sizes = [0]

        def fill(room: np.ndarray) -> int:
            self.region.number[self.region.number >= 0] = -1
            sizes[0], many = call(number_region, frame, self.region, marks, room)
            return int(many)

        numbers, count = grown(1024, lambda room: np.empty((room, 4), np.int64), fill)
        self.cells, self.numbers = sizes[0], numbers[:count]
        near = np.zeros(len(low), bool)
        near[np.flatnonzero(there)[found > 0]] = True
        return near
