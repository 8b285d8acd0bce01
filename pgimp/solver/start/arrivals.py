"""Bodies that come as a stage begins: looked at before anything changes, then put in order.

All follows from the case and from the state at the end of the stage before, so that the ranks do
not matter: the numbers of the new particles follow those of all before, by body and position.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from pgimp.errors import CaseError, RunError
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.once.prestress import remember_stress
from pgimp.kernels.order.order import layers_of, locate
from pgimp.kernels.rigid.bodies import distances
from pgimp.kernels.sums.sums import SUMS
from pgimp.mpi.collective import all_or_none
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.bodies.initial_stress import set_initial_stress
from pgimp.scene.bodies.populate import prestressed
from pgimp.scene.geometry import release, share, take_as_empty
from pgimp.scene.scene import Scene
from pgimp.solver.contact.penetration import placed
from pgimp.solver.decomposition import bring_home, create_particles, open_window, ring_counts
from pgimp.solver.history.body_sums import sums_of_bodies
from pgimp.solver.start.creation import LIGHT, Creation

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.rank import Rank
    from pgimp.solver.start.start import Start

#: Depth of a particle's centre in the region of a body that comes, over the least side of an
#: undeformed particle's box, from which on the two overlap.
_DEEP = 0.25

_NONE = np.empty(0, np.int32)

#: A body that comes, a place, and what is there.
_Found = tuple[str, tuple[float, ...], str]


class Arrivals:
    """The bodies that come in a stage; creating it and `enter` are collective.

    Parameters
    ----------
    scene : Scene
        The scene of the stage.
    rank : Rank
        The rank, at the end of the stage before.
    names : collection of str
        The bodies that come.
    gone : collection of str
        Bodies that are removed as the stage begins.

    Attributes
    ----------
    layers : (layers,) int64
        New particles of each layer, as `partition` takes them.

    Raises
    ------
    RunError
        On every rank, if a body would overlap particles or cannot be made. Nothing has changed.
    """

    def __init__(
        self, scene: Scene, rank: Rank, names: Collection[str], gone: Collection[str]
    ) -> None:
        self.scene, self.comm, self.names = scene, rank.comm, names
        try:
            share(scene.case, self.comm, names)
            self.lattice, self.counts, _ = count_particles(scene, self.comm, names)
        except CaseError as error:
            raise RunError(f"{scene.case.staged.title}: {error}") from None
        self._require_room(rank, gone)
        layer = np.empty(len(self.lattice.coordinates[0]), np.int64)
        layers_of(
            scene.settings.shape,
            scene.order_frame,
            scene.setting.identity,
            self.lattice.coordinates[0],
            layer,
        )
        self._layer, total = layer, self.counts.sum(axis=0)
        found = np.bincount(layer, total, scene.domain.frame.vertices[0]).astype(np.int64)
        self.layers, ring = ring_counts(scene, found), scene.domain.ring
        if ring is not None:
            self.layers = self.layers[ring : ring + scene.domain.ring_layers]

    def _require_room(self, rank: Rank, gone: Collection[str]) -> None:
        """Refuse bodies in the place of particles or rigid bodies that stay."""
        every = self.comm.allgather(self._particles_inside(rank, gone) + self._inside(rank, gone))
        if not (found := [one for part in every for one in part]):
            return
        name, place, what = min(found)
        at = ", ".join(f"{c:.6g}" for c in place)
        raise RunError(
            f"{self.scene.case.staged.title}: body '{name}' cannot come: {what} at ({at})\n"
            "  try: a region beside what is there then, or remove what is in its place; the "
            "checkpoint of the stage before is intact"
        )

    def _particles_inside(self, rank: Rank, gone: Collection[str]) -> list[_Found]:
        """First particle of this rank in the region of each body that comes."""
        scene, p, rows = self.scene, rank.up_to_date(), rank.live()
        stay = np.array([name not in gone for name in scene.body_names])
        rows = rows[stay[p.body[rows]]]
        x, deep, found = p.x[rows], _DEEP * min(self.lattice.box), []
        for name in self.names:
            region = scene.case.bodies[name].region
            low, high = region.bounds()
            near = np.flatnonzero(((low <= x) & (x <= high)).all(axis=1))
            inside = near[region.signed_distance(x[near]) < -deep]
            if len(inside):
                place, body = min(
                    zip(map(tuple, x[inside].tolist()), p.body[rows[inside]].tolist(), strict=True)
                )
                found.append((name, place, f"'{scene.body_names[body]}' has a particle there,"))
        return found

    def _inside(self, rank: Rank, gone: Collection[str]) -> list[_Found]:
        """First new particle in each rigid body, of a share of the planes."""
        rigid, comm, planes = rank.scene.interaction.rigid_bodies, self.comm, self.lattice.planes
        if not rigid:
            return []
        states = rank.free.states if rank.free else None
        bodies = placed(rigid, self.scene.case.staged.start, states)
        share_ = (comm.rank * planes // comm.size, (comm.rank + 1) * planes // comm.size)
        found = []
        for block in self.lattice.make(share_, self.counts):
            distance = np.empty(len(block.ids))
            for t, name in enumerate(rigid.names):
                if name in gone:
                    continue
                distances(bodies, t, rigid.frame, block.positions, distance)
                inside = block.positions[distance < -_DEEP * min(self.lattice.box)]
                if len(inside):
                    place = min(map(tuple, inside.tolist()))
                    own = self.scene.body_names[block.body]
                    found.append((own, place, f"it would be in the rigid '{name}'"))
        return found

    def enter(self, now: Start) -> None:
        """Create the particles, and put them in order, in a rank that has entered the stage."""
        rank, scene, comm = now.rank, self.scene, self.comm
        creation, count = Creation(scene), int(self.counts.sum())
        particles, own = create_particles(
            scene,
            rank.slab,
            comm,
            lambda slab: all_or_none(
                comm,
                lambda: creation.create(slab, self.lattice, self.counts, self._layer),
                CaseError,
            ),
        )
        self._prepare(particles, own, scene.case.staged.start)
        particles, own = bring_home(scene, rank.slab, comm, particles, own)
        first = rank.numbered
        particles.id[:own] += first
        rank.numbered += count
        population = rank.population
        rows = population.insert(own)
        p = population.columns
        for name, column in particles._asdict().items():  # gradients are of the start alone
            if (stored := getattr(p, name)).shape[1:] == column.shape[1:]:
                stored[rows] = column[:own]
        locate(scene.settings.shape, scene.order_frame, p, rows, scene.domain.frame.vertices)
        population.restore_order(_NONE, rows)
        rank.moved = True
        scene.interaction.loads.scale_patches(population, comm, self.names)
        least = min(comm.allgather(float(particles.m[:own].min(initial=np.inf))))
        rank.mass_cutoff = min(rank.mass_cutoff, LIGHT * least)
        open_window(rank, now.reduction)
        now.balance.watch(rank.count)
        self._book(now, first)
        release(scene.case)
        take_as_empty(scene.case, comm)

    def _prepare(self, particles: Particles, own: int, time: float) -> None:
        """Set the stress, and look at the constraints that wait for the bodies."""
        scene, comm = self.scene, self.comm
        stress = scene.case.staged.stress
        try:
            scene.interaction.loads.require_all_hold(particles, own, comm, self.names)
            scene.interaction.loads.surfaces.require(particles, own, comm, self.names)
            if stress is not None:
                set_initial_stress(scene, particles, own, comm, stress, time)
        except CaseError as error:
            raise RunError(f"{scene.case.staged.title}: {error}") from None
        if bodies := prestressed(scene):
            rows = np.flatnonzero(np.isin(particles.body[:own], bodies))
            remember_stress(scene.setting.without_shape(), particles, rows)

    def _book(self, now: Start, first: int) -> None:
        """Add what the particles from number `first` on bring to the books."""
        rank, records = now.rank, now.diagnostic_sums
        order = rank.population.order
        offsets = np.flatnonzero(rank.up_to_date().id[order] >= first).astype(np.int32)
        new = Order(order[offsets], np.searchsorted(offsets, rank.population.start))
        brought = np.add.reduce(sums_of_bodies(rank, self.scene, new), axis=0)
        records.added = records.added_so_far(self.scene) + brought
        records.initial_losses[: len(brought) - SUMS] += brought[SUMS:]


def coming(before: Case, now: Case) -> list[str]:
    """Bodies that come in a stage, given the cases of the stage before and of it."""
    return list(now.staged.added[len(before.staged.added) :])


def arrivals_of(scene: Scene, before: Scene, rank: Rank) -> Arrivals | None:
    """Return the bodies that come in a stage, None without any; collective."""
    if names := coming(before.case, scene.case):
        rigid = set(before.case.rigid_bodies) - set(scene.case.rigid_bodies)
        return Arrivals(scene, rank, names, {*scene.case.staged.removed, *rigid})
    return None
