"""Impulses of all pairs of a scene, found by sweeps, and what they change."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.colouring import bound_bodies
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.impulses.books import book_contacts
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.reference_grid import NUMBERS, Changes
from pgimp.kernels.contact.impulses.rows import Solved, begin_solution
from pgimp.kernels.contact.surfaces.groups import find_changed, solve_groups
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.base import NoContact
from pgimp.solver.contact.free_bodies import FreeBodies
from pgimp.solver.contact.impulses.bonds import bonded, separating_walls, with_walls
from pgimp.solver.contact.impulses.joint import Joint
from pgimp.solver.contact.impulses.kept_forces import KeptForces
from pgimp.solver.contact.impulses.room import Room
from pgimp.solver.lagrangian.masters import REACH as MASTERS_AWAY
from pgimp.solver.rank_state import RankState

#: The most sweeps over all pairs in a step, and the relative change of impulses that ends them. To
#: 1e-3 disks rebound the same to four digits, but what rests with friction slowly gains energy.
ACCURACY = 200, 1e-6


class ImpulseContact(NoContact):
    """Contact by impulses that are found together, in scenes with an initial configuration.

    Attributes
    ----------
    fields : tuple of int
        Number of each body's velocity field: bodies that are near each other at the start have
        different ones, unless they are bonded; so has each in the current configuration.
    groups : (bodies,) int64
        Groups of bonded bodies.
    free : FreeBodies or None
        The rigid bodies that move freely, if any.
    sweeps : int
        Sweeps over the pairs in the last step with any, on a rank that solves.
    """

    bears = True

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        self.call = Bound()
        self.bodies = len(scene.body_names)
        self.fields = (0,) * self.bodies if scene.interaction.pairs else ()
        self.groups = np.zeros(self.bodies, np.int64)
        self._grouped = False
        self.pairs, self._walls = with_walls(scene), separating_walls(scene)
        rigid_bodies: Any = (
            scene.interaction.rigid_bodies.in_planes(1) if scene.interaction.rigid_bodies else ()
        )
        self._contact = Contact.empty(
            self.pairs, np.empty(0), 1, self.bodies + 1, len(scene.domain.faces), rigid_bodies
        )
        self.free = FreeBodies(scene, comm) if scene.interaction.rigid_bodies.free else None
        self._warm_start, self._room = KeptForces(comm), Room()
        self._dt, self.sweeps, self._accuracy = 0.0, 0, ACCURACY

    @property
    def rigid_bodies(self) -> Any:
        """The rigid bodies for kernels, as they are in this step; () without any."""
        return self._contact.rigid_bodies

    @property
    def kept_forces(self) -> np.ndarray:
        """See `NoContact.kept_forces`."""
        return self._warm_start.stored

    def restore_forces(self, forces: np.ndarray) -> None:
        """See `NoContact.restore_forces`."""
        self._warm_start.restore(forces)

    def assign_fields(self, rank: RankState) -> None:
        """See `NoContact.assign_fields`; once, for the groups of bodies bonded at the start."""
        if self._grouped:
            return
        self._grouped = True
        scene, grid, population = self.scene, rank.grid, rank.population
        if not self.fields:
            return
        p, order = population.up_to_date(), population.order
        boxes = np.full((2, self.bodies, scene.dimension), np.inf)
        boxes[1] = -np.inf
        bound_bodies(p.origin, p.body, order, boxes)
        domain = scene.domain
        boxes = (boxes - np.array(domain.frame.origin)) * np.array(domain.frame.inverse)
        every = np.array(self.comm.allgather(boxes))
        low, high = every[:, 0].min(axis=0), every[:, 1].max(axis=0)
        exact = bool(scene.settings.exact_surfaces.any())
        # From a particle, or the centroid of a part of one, to the farthest vertex with weight.
        distance = 2.0 + (4.0 if exact else 2.0) * np.array(scene.settings.uncut.half)
        cells = [n * joined for n, joined in zip(domain.frame.cells, domain.periodic, strict=True)]
        self.fields, self.groups = bonded(
            self.pairs, low, high, distance, scene.settings.lagrangian, exact * MASTERS_AWAY, cells
        )
        if max(self.fields) > 0 and self.fields != grid.fields:
            grid.fields = self.fields
            grid.store(grid.base)

    def _solve(self, joint: Joint, free: Holding, ledger: Ledger) -> Changes:
        """Solve for the impulses of pairs, and book them."""
        call = self.call
        pairs, coupling, known = joint
        vertices = flat(known.values)
        solved = self._room.solved(len(vertices), coupling)
        call(begin_solution, free.frame, vertices, coupling, solved)
        self._sweep(free, pairs, coupling, solved)
        self._warm_start.keep(pairs, coupling, solved, vertices, self._dt)
        changes = self._changes(known.keys, vertices, solved)
        self._book(free, pairs, coupling, solved, vertices, ledger)
        return changes

    def _changes(self, keys: np.ndarray, vertices: np.ndarray, solved: Solved) -> Changes:
        """What the impulses have changed, of the vertices where there is any."""
        room = self._room
        into = room.changes(len(keys))
        return room.changed(self.call(find_changed, keys, vertices, solved, into))

    def _sweep(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved
    ) -> None:
        """Solve for the impulses of pairs, by sweeps over those of all groups together."""
        count = len(pairs.ends)
        self._warm_start.begin(self._contact, pairs, coupling, solved, self._dt)
        self._solve_groups(free, (pairs, np.arange(count), np.array([0, count])), coupling, solved)

    def _solve_groups(
        self, free: Holding, pairs: tuple[ContactPairs, np.ndarray, np.ndarray],
        coupling: Coupling, solved: Solved,
    ) -> None:  # fmt: skip
        """Solve for the impulses of groups of pairs, see `solve_groups`."""
        count = len(pairs[0].ends)
        prepared = self._room.prepared(count)
        self.sweeps = self.call(
            solve_groups, self._contact, free, pairs, coupling, solved, prepared, self._accuracy
        )

    def _book(
        self, free: Holding, pairs: ContactPairs, coupling: Coupling, solved: Solved,
        vertices: np.ndarray, ledger: Ledger,
    ) -> None:  # fmt: skip
        """Book the impulses of pairs."""
        of = self._contact, free, pairs, coupling, solved, vertices
        self.call(book_contacts, *of, self._walls, ledger)


def flat(values: np.ndarray) -> np.ndarray:
    """Records of reference vertices as (n, NUMBERS) float64, without a copy."""
    return values.view(np.float64).reshape(-1, NUMBERS)


def nothing_held(holding: Holding) -> Holding:
    """Conditions inside the solver: none, as constrained vertices have no inverse mass."""
    forcing = holding.forcing._replace(marked=(), clearances=())
    return holding._replace(faces=(), forcing=forcing)
