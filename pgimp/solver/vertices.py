"""The vertices of a rank in a step, besides contact: forcing, mirrors, constraints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from pgimp.kernels.data.arguments import Forcing, Order
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.data.record import ACCELERATION, VELOCITY
from pgimp.kernels.grid.constraints import apply_constraints
from pgimp.kernels.grid.faces import Faces
from pgimp.kernels.grid.image_values import fold_volumes
from pgimp.kernels.grid.mirror import fold, reflect
from pgimp.kernels.lagrangian.keep import keep_motion
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.loads.prescribed import Places
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step


class VertexUpdate(NamedTuple):
    """A step's forcing of the vertices."""

    t: Step
    faces: Faces | tuple[()]  #: Faces or (): The conditions of faces in the step.
    forcing: Forcing  #: The other forcing, without loads on particles only.
    ledger: Ledger  #: Ledger for work and impulses.


class StepPart:
    """What a scene may add to a step; each part overrides the methods that it needs.

    A step calls the methods in the order of their definition. `pgimp.solver.parts` lists the parts.
    """

    #: Rate whose product with the step must not be above the Courant number, for the part to be
    #: stable: as the cells that waves cross in a unit of time.
    rate: float = 0.0

    def begin(self, rank: RankState, order: Order, done: int) -> None:
        """Act before the sums over particles; collective.

        Parameters
        ----------
        order : Order
            Its particles: all, or in scenes of both configurations those in the current one.
        done : int
            Number of the step before.
        """

    def strain(
        self, rank: RankState, groups: Sequence[Any], update: VertexUpdate, loads: Loads
    ) -> None:
        """Strain particles before forces act, with all sums at hand; collective.

        Parameters
        ----------
        groups : sequence of ParticleGroup
            The particles.
        update, loads
            The step's; the sums must be the same thereafter, but for the stress.
        """

    def add_forces(self, rank: RankState, update: VertexUpdate) -> None:
        """Add forces to the sums at the vertices, before the momentum update; collective."""

    def slow(self, rank: RankState, update: VertexUpdate) -> None:
        """Take velocity after all conditions and contact, before anything is booked."""

    def book(self, rank: RankState, update: VertexUpdate) -> None:
        """Book impulses and work, after all conditions and contact; collective."""

    def force_particles(self, rank: RankState, order: Order, t: Step, forcing: Forcing) -> Forcing:
        """Return the forcing of the particles with what the part adds to it; collective."""
        return forcing

    def complete(self, rank: RankState) -> None:
        """Act when the particles have moved, in the rows and the order as the step began."""

    def change_particles(self, rank: RankState, t: Step) -> None:
        """Take particles out, or let others in, when the canonical order is restored."""


def vertex_update(
    rank: RankState, t: Step, loads: Loads, ledger: Ledger | None = None
) -> VertexUpdate:
    """Return a step's forcing of the vertices, booked in a ledger, else in the rank's.

    It has no loads on particles only: kernels that work on vertices are then compiled once for all
    kinds of loads.
    """
    scene, grid = rank.scene, rank.grid
    constraints = scene.interaction.loads.constraints_at(t.start, t.end)
    marked: tuple[Any, ...] = (constraints, grid.marks[0]) if constraints else ()
    if scene.interaction.loads.placed:
        marked += (Places(scene.domain.frame, grid.window, grid.motion),)
    forcing = Forcing(
        t.dt,
        scene.domain.gravity(t.start),
        rank.mass_cutoff,
        Loads(relaxation=loads.relaxation),
        (),
        marked,
        scene.domain.walls(t.start, t.end),
        False,
        rank.clearances.stored(grid),
    )
    faces = scene.domain.face_parameters(t.start, t.end)
    return VertexUpdate(t, faces, forcing, ledger or rank.ledger)


def fold_mirrors(rank: RankState, update: VertexUpdate) -> None:
    """Fold the sums beyond reflecting faces; find the clearances of unilateral ones."""
    scene, field, call, volumes = rank.scene, rank.grid.field, rank.call, rank.contact.volumes
    for seam in scene.domain.seams if volumes else ():
        call(fold_volumes, scene.domain.frame, field, *volumes, seam)
    for releases in (False, True):  # unilateral ones last: they include the sums of both
        for mirror in (*scene.domain.absorbing_mirrors, *scene.domain.mirrors):
            if mirror.releases == releases:
                call(fold, scene.domain.frame, field, mirror, update.forcing, update.ledger)
                if volumes:
                    call(fold_volumes, scene.domain.frame, field, *volumes, mirror)
        if not releases:
            rank.clearances.find(rank.grid)


def hold_constrained(rank: RankState, update: VertexUpdate) -> VertexUpdate:
    """Set the velocities of constraints; return the update with those that forces give."""
    if not update.forcing.marked:
        return update
    if rank.grips and rank.grips.acts:
        marked = (rank.grips.find(rank, update), *update.forcing.marked[1:])
        update = update._replace(forcing=update.forcing._replace(marked=marked))
    rank.call(apply_constraints, rank.grid.field, update.forcing, update.ledger)
    if rank.grips:
        rank.grips.await_contact(rank)
    return update


def move_slaves(rank: RankState) -> None:
    """Move vertices that hold next to nothing as their masters say; collective."""
    if rank.slaves:
        rank.slaves.spread(rank, rank.grid.G, VELOCITY)
        rank.slaves.spread(rank, rank.grid.G, ACCELERATION)  # for the work of loads that follow


def keep_vertex_motion(rank: RankState, update: VertexUpdate) -> None:
    """Move the vertices that keep their motion, in the initial configuration."""
    if rank.grid.motion:
        rank.call(keep_motion, rank.grid.field, update.t.dt)
        if rank.scene.by_cells:
            rank.population.outdate(rank.by_cells_alone())


def reflect_mirrors(rank: RankState, update: VertexUpdate) -> None:
    """Set the vertices beyond reflecting faces, and beyond seams, from vertices inside."""
    scene, field = rank.scene, rank.grid.field
    domain = scene.domain
    for images in reversed((*domain.seams, *domain.absorbing_mirrors, *domain.mirrors)):
        rank.call(reflect, domain.frame, field, images, update.forcing, update.ledger)
