"""Vertices that hold next to nothing, as slaves of a cell near them: bodies exact to their surface.

A surface may leave a vertex as little as one likes. Such a vertex has hardly any stiffness beside
its mass, or hardly any mass, and would move by itself. So one that holds less than `LEAST` of a
cell moves as the multilinear function of the nearest cell whose vertices all hold enough, continued
to its place. Its force and its mass go to that cell's vertices with the same weights. Rigid motions
are kept, so that momentum and angular momentum stay exact. After Badia, Verdugo and Martin, The
aggregated unfitted finite element method, Comput. Meth. Appl. Mech. Engng 336, 533-553 (2018).

Where no such cell is near, as in bodies thinner than two cells, a vertex stays free. If it is too
light for usual steps it has mass of others of its cells: the body has the same mass.

All ranks have the table of all slaves; each folds what belongs to its planes, in the order of the
vertices. So no bit depends on the ranks.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from pgimp.case.stepping.courant import largest_courant
from pgimp.errors import CaseError
from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import FORCE, RECORD
from pgimp.kernels.lagrangian.slaves import (
    fold_averages,
    fold_vectors,
    leave_to_masters,
    spread_vectors,
    take_vectors,
)
from pgimp.kernels.sums.sums import ANGULAR, KINETIC, MOMENTUM
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.greatest_frequency import steady
from pgimp.solver.lagrangian.masters import Vertices, choose_masters
from pgimp.solver.lagrangian.slave_rows import Rows, exchange, find_rows, places_of, records_of
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart, VertexUpdate

#: Part of a cell below which a vertex is a slave.
LEAST = 0.05


class Slaves(StepPart):
    """The slaves of a scene's bodies that are exact to their surface.

    Attributes
    ----------
    keys : (n,) int64
        The slaves, as numbers of vertices and fields, ascending.
    masters : (m,) int64
        Likewise their masters, each once.
    of : (n, 2^D) int64
        Each slave's masters, as numbers in `masters`.
    weights : (n, 2^D) float64
        Their weights.
    own : (bodies, n) float64
        The masses that slaves have of each body, and give to their masters.
    mass : (m,) float64
        The masters' masses with those of their slaves.
    free : (k,) int64
        Vertices that hold too little, and have no cell near them.
    courant : float
        Courant number up to which vertices near slaves are stable.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.scene, self.comm = scene, comm
        corners = 2**scene.dimension
        self.keys = self.masters = np.zeros(0, np.int64)
        self.of, self.weights = np.zeros((0, corners), np.int64), np.zeros((0, corners))
        self.own = np.zeros((len(scene.body_names), 0))
        self.free, self.courant = np.zeros(0, np.int64), np.inf
        # Changes of mass by folding: vertex, body, change.
        self._changes: tuple[np.ndarray, np.ndarray, np.ndarray] = (
            self.keys, self.keys, np.zeros(0)
        )  # fmt: skip
        self._field: Any = None
        self._rows: Rows

    def find(self, rank: RankState, vertices: Vertices, masses: np.ndarray) -> None:
        """Find slaves and masters from what vertices hold; collective.

        Parameters
        ----------
        vertices : Vertices
            What its vertices hold of cells.
        masses : (bodies, planes, y, z) float64
            The masses that vertices have of each body.
        """
        # Slaves of all ranks, and what is held around them.
        held = vertices.held
        few = np.where(vertices.exact & (held > 0.0) & (held < LEAST))
        mine = few[0] < rank.grid.owned
        few = tuple(each[mine] for each in few)
        keys = np.sort(np.concatenate(self.comm.allgather(vertices.keys[few])))
        near = vertices.around(keys)
        at, there = vertices.find(near, rank.grid.owned)
        fields = vertices.field_of(near)
        own = np.zeros((len(self.scene.body_names), len(at[0])))
        for b, field in enumerate(rank.grid.fields or [0] * len(own)):
            own[b] = np.where(fields[there] == field, masses[b][at[0], at[2], at[3]], 0.0)
        parts = self.comm.allgather((near[there], held[at], own))
        known, values, own = (np.concatenate(each, axis=-1) for each in zip(*parts, strict=True))
        order = np.argsort(known, kind="stable")
        known, values, own = known[order], values[order], own[:, order]

        # Their masters; none whose folded mass would become small.
        masters, weights = choose_masters(vertices, keys, known, values, LEAST)
        chosen = masters[:, 0] >= 0
        total, row = own.sum(axis=0), np.searchsorted(known, keys)
        while True:
            folded = total.copy()
            share = weights[chosen] * total[row[chosen], None]
            np.add.at(folded, masters[chosen].reshape(-1), share.reshape(-1))
            bad = folded < 0.5 * total
            bad[row[chosen]] = False
            spoilt = chosen & (bad[masters] & (weights < 0.0)).any(axis=1)
            if not spoilt.any():
                break
            chosen &= ~spoilt
        self.free = keys[~chosen]
        self.keys, self.weights = keys[chosen], weights[chosen]
        self.own = own[:, row[chosen]]
        folded[row[chosen]] = 0.0
        moved: list[tuple[int, int, float]] = []
        self.courant = np.inf
        if len(keys):
            self.courant, moved = steady(
                rank,
                vertices,
                known,
                folded,
                (self.keys, self.free),
                (masters[chosen], self.weights),
            )
        even = np.array([pair[:2] for pair in moved], np.int64).reshape(-1)
        numbers = np.unique(np.concatenate([masters[chosen].reshape(-1), even]))
        self.of = np.searchsorted(numbers, masters[chosen])
        self.masters, self.mass = known[numbers], folded[numbers]
        bodies = own.argmax(axis=0)
        self._find_changes([(known[[to, by]], bodies[to], mass) for to, by, mass in moved])
        if rank.averaged_mass:
            self.courant /= (1.0 + rank.averaged_mass.alpha.max()) ** 0.5
        self._field = None

    def _find_changes(self, moved: list[tuple[np.ndarray, int, float]]) -> None:
        """Set the changes of mass by folding, and those of free vertices.

        These are the keys of the vertex that takes and of the one that gives, a body and a mass.
        """
        found = [(keys, np.full(2, body), np.array([mass, -mass])) for keys, body, mass in moved]
        for b, mass in enumerate(self.own):
            change = np.zeros(len(self.masters))
            np.add.at(change, self.of.reshape(-1), (self.weights * mass[:, None]).reshape(-1))
            for keys, values in ((self.keys, -mass), (self.masters, change)):
                some = values != 0.0
                found.append((keys[some], np.full(some.sum(), b), values[some]))
        keys, bodies, values = (np.concatenate(each) for each in zip(*found, strict=True))
        self._changes = keys, bodies, values

    def fold_masses(self, rank: RankState) -> None:
        """Add the kept masses of slaves to their masters'.

        Those of copies at seams across y and z stay parts, by which steps join them.
        """
        if rank.scene.domain.seams:
            return
        rows, records = self.located(rank), rank.grid.kept.values.reshape(-1, RECORD)
        keys, _, changes = self._changes
        slaves = np.isin(keys, self.keys)
        at, _ = records_of(rank, keys)
        there = (at >= 0) & ~slaves
        np.add.at(records[:, KEPT_MASS], at[there], changes[there])
        records[rows.slaves[rows.slaves >= 0], KEPT_MASS] = 0.0
        records[rows.copies[:, 1], KEPT_MASS] = records[rows.copies[:, 0], KEPT_MASS]

    def add_forces(self, rank: RankState, update: VertexUpdate) -> None:
        """Add the forces on slaves to their masters'; see `StepPart.add_forces`."""
        if not needed(len(self.masters)):
            return
        rows, grid = self.located(rank), rank.grid
        to = self.of, self.weights, rows.masters
        rank.call(fold_vectors, grid.G, FORCE, self._forces(rank, rows), *to)
        self._leave(rank, rows)

    def _forces(self, rank: RankState, rows: Rows) -> np.ndarray:
        """The forces on all slaves that the rank needs, (n, 3); collective."""
        force = np.empty((len(self.keys), 3))
        rank.call(take_vectors, rank.grid.G, RECORD, FORCE, rows.own, force)
        exchange(self.comm, force, rows, 0)
        return force

    def _leave(self, rank: RankState, rows: Rows) -> None:
        """Take forces and masses from slaves, as their masters have them; set all copies."""
        rank.call(leave_to_masters, rank.grid.G, self.mass, rows.slaves, rows.masters)
        records = rank.grid.G.reshape(-1, RECORD)
        records[rows.copies[:, 1]] = records[rows.copies[:, 0]]

    def fold_averages(
        self, rank: RankState, alpha: np.ndarray, known: np.ndarray, lumped: np.ndarray
    ) -> None:
        """Add what the averaged mass takes from slaves to their masters' forces; collective.

        Parameters
        ----------
        alpha : (bodies,) float64
            Part of the consistent mass by body.
        known : (m, 3) float64
            The masters' accelerations, from `spread`.
        lumped : (n,) bool or (0,)
            Slaves whose masters keep the lumped mass.
        """
        if not needed(len(self.keys)):
            return
        rows, mass = self.located(rank), np.asarray(alpha @ self.own)
        if len(lumped):
            mass[lumped] = 0.0
        rank.call(
            fold_averages, rank.grid.G, FORCE, self._forces(rank, rows), mass, known,
            self.of, self.weights, rows.masters,
        )  # fmt: skip
        self._leave(rank, rows)

    def spread(
        self, rank: RankState, values: np.ndarray, first: int, size: int = RECORD
    ) -> np.ndarray:
        """Set vectors at slaves to what their masters' give, and return these; collective.

        Parameters
        ----------
        values : (records * size,) float64
            Records of the rank's vertices.
        first : int
            Entry of a record with the first component.
        size : int
            Numbers of a record.

        Returns
        -------
        (m, 3) float64
            The vectors of the masters that the rank needs.
        """
        known = np.empty((len(self.masters), 3))
        if not needed(len(self.keys)):
            return known
        rows = self.located(rank)
        rank.call(take_vectors, values, size, first, rows.masters, known)
        exchange(self.comm, known, rows, 1)
        to = self.of, self.weights, rows.slaves
        rank.call(spread_vectors, values, size, first, known, *to)
        records, vector = values.reshape(-1, size), slice(first, first + 3)
        records[rows.copies[:, 1], vector] = records[rows.copies[:, 0], vector]
        return known

    def complete_sums(
        self,
        rank: RankState,
        some: Collection[int] | None,
        part: np.ndarray | tuple[()],
        sums: np.ndarray,
    ) -> None:
        """Add what vertices have with the masses of others: momenta and kinetic energy.

        Parameters
        ----------
        some : collection of int or None
            The bodies of the sums; None: all.
        part : (bodies,) float64 or ()
            See `pgimp.kernels.lagrangian.sums.motion_sums`.
        sums : (layers, bodies, columns) float64
            See `pgimp.kernels.sums.sums.layer_sums`.
        """
        if not len(self.masters):
            return
        rows = self.located(rank)
        bodies, mass = self._changes[1][rows.changed], self._changes[2][rows.changed]
        counted = np.isin(bodies, [*some]) if some is not None else np.ones(len(bodies), bool)
        records = rows.records[counted]
        layer, bodies, mass = rows.layers[counted], bodies[counted], mass[counted]
        mass = mass * part[bodies] if len(part) else mass
        motion = rank.grid.kept.values.reshape(-1, RECORD)[records]
        v = motion[:, KEPT_VELOCITY : KEPT_VELOCITY + 3]
        x = places_of(rank, self._changes[0][rows.changed[counted]])
        x += motion[:, DISPLACEMENT : DISPLACEMENT + 3]
        for d in range(int(self.scene.case.axisymmetric), 3):
            np.add.at(sums[..., MOMENTUM + d], (layer, bodies), mass * v[:, d])
        for d in range(0 if self.scene.case.axisymmetric else 3):
            i, j = (d + 1) % 3, (d + 2) % 3
            about = mass * (x[:, i] * v[:, j] - x[:, j] * v[:, i])
            np.add.at(sums[..., ANGULAR + d], (layer, bodies), about)
        square = v[:, 0] * v[:, 0] + v[:, 1] * v[:, 1] + v[:, 2] * v[:, 2]
        np.add.at(sums[..., KINETIC], (layer, bodies), 0.5 * mass * square)

    def led_by(self, rank: RankState, marked: np.ndarray) -> np.ndarray:
        """Whether slaves have masters among marked records of any rank, (n,) bool; collective."""
        masters = self.located(rank).masters
        found = self.comm.allgather((masters >= 0) & marked[masters])
        return np.asarray(np.any(found, axis=0)[self.of].any(axis=1))

    def records(self, rank: RankState, some: np.ndarray) -> np.ndarray:
        """Numbers of the records of some slaves that the rank has; collective as `spread`."""
        rows = self.located(rank)
        found, low = rows.slaves[some], rows.copies[:, 0]
        found = found[found >= 0]
        return np.concatenate([found, rows.copies[np.isin(low, found), 1]])

    def located(self, rank: RankState) -> Rows:
        """Where the rank has slaves and masters; collective when planes or window have changed."""
        if self._field is not rank.grid.field:
            self._field = rank.grid.field
            self._rows = find_rows(rank, self.keys, self.masters, self._changes[0])
        return self._rows

    @property
    def part(self) -> float:
        """Part of the largest Courant number of the case that vertices near surfaces bear."""
        return min(1.0, self.courant / largest_courant(self.scene.case))

    def require_stable(self, courant: float) -> None:
        """Refuse steps that vertices near the surface do not bear.

        Raises
        ------
        CaseError
            On every rank.
        """
        if courant > self.courant:
            alone = len(self.free)
            raise CaseError(
                "bodies: near the surface of bodies with cut cells vertices are stable up to "
                f"the Courant number {self.courant:.2g}; the first step has {courant:.2g}. "
                + f"{alone} of them hold little, and have no cell near them. "
                * bool(alone)
                + "Such are where a body is thinner than two cells, or ends in a sharp edge: take "
                "finer cells (grid.cell), a smaller number (time.step), or surface: whole-particles"
            )

    def notes(self) -> list[str]:
        """Say how many vertices hold too little and move by themselves."""
        if not len(self.free):
            return []
        return [
            f"vertices that hold less than {100 * LEAST:g} % of a cell, and have no cell near them "
            f"to move with: {len(self.free)}; where bodies are thinner than two "
            f"cells. They allow Courant numbers up to {self.courant:.2g}"
        ]


def slaves_of(scene: Scene, comm: Communicator, before: Slaves | None = None) -> Slaves | None:
    """The slaves of a scene; None without bodies that are exact to their surface."""
    return Slaves(scene, comm) if scene.settings.exact_surfaces.any() else None
