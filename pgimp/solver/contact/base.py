"""Interface of contact for the step, and bodies that share one velocity field: no contact."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.kernels.data.arguments import Field
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.step.momentum import FURTHER, WHOLE, update_momentum
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import VertexUpdate

if TYPE_CHECKING:
    from pgimp.kernels.contact.impulses.reference_grid import Changes
    from pgimp.solver.contact.free_bodies import FreeBodies


class NoContact:
    """No contact: bodies that share one velocity field; the kinds of contact override its methods.

    A step calls the methods in the order of their definition. All are collective.

    Attributes
    ----------
    at_vertices : bool
        Whether bodies exchange impulses at shared vertices, for output in frames.
    by_planes : bool
        Whether `update_momentum` may go on some planes after the others.
    bears : bool
        Whether `exchange` leaves impulses to constraints, at vertices that they hold.
    """

    at_vertices = False
    by_planes = True
    bears = False
    #: Number of each body's velocity field; () if all share one for ever.
    fields: tuple[int, ...] = ()
    free: FreeBodies | None = None  #: The rigid bodies that move freely, if any.
    data: Any = ()  #: Contact or (): The kernels' data for contact vertices; () without any.

    #: What contact has changed in the last step at vertices of all ranks, in the initial
    #: configuration; None if nothing touched.
    changes: Changes | None = None

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.scene, self.comm = scene, comm

    @property
    def rigid_bodies(self) -> Any:
        """The rigid bodies for kernels, as they are in this step; () without any."""
        return ()

    @property
    def volumes(self) -> tuple[np.ndarray, ...]:
        """Sums of volumes at vertices that are shared, and their used rows; () without any."""
        return (self.data.volumes, self.data.used) if self.data else ()

    def assign_fields(self, rank: RankState) -> None:
        """Assign velocity fields to bodies: a common one to bodies that cannot touch soon."""

    def excursion(self, rank: RankState) -> float:
        """Cells by which the rank's particles have left their bodies' boxes of the last search.

        Called after each step, once.
        """
        return 0.0

    def note_excursion(self, greatest: float) -> None:
        """Note the greatest `excursion` of all ranks after a step."""

    @property
    def assignment(self) -> np.ndarray:
        """State of `assign_fields` for checkpoints, int64; empty if it follows from the case.

        Fields follow from where bodies were at the last assignment. Sums over fields, and sweeps
        over their pairs, go in their order.
        """
        return np.empty(0, np.int64)

    def restore(self, rank: RankState, assignment: np.ndarray) -> None:
        """Continue with an `assignment` from a checkpoint; collective."""

    @property
    def kept_forces(self) -> np.ndarray:
        """Forces at which the next step begins to solve, for checkpoints: this rank's rows."""
        return np.empty((0, 0))

    def restore_forces(self, forces: np.ndarray) -> None:
        """Continue with the `kept_forces` of all ranks from a checkpoint."""

    @property
    def search(self) -> np.ndarray:
        """State of the search for what may meet, for checkpoints: of one rank, on others empty."""
        return np.empty(0)

    def restore_search(self, search: np.ndarray) -> None:
        """Continue with a `search` from a checkpoint, on every rank."""

    @property
    def surface_loads(self) -> np.ndarray:
        """Loads on surfaces since the last frame, for checkpoints: of one rank, on others empty."""
        return np.empty((0, 0))

    def restore_loads(self, loads: np.ndarray) -> None:
        """Continue with the `surface_loads` of a checkpoint, on every rank."""

    def conclude(self, rank: RankState) -> None:
        """End a stage in which no step may have been taken since a checkpoint; collective."""

    def follow(self, before: NoContact) -> None:
        """Go on from the contact of the stage before."""

    def detect(self, rank: RankState, t: Step, ledger: Ledger) -> None:
        """Find the contact vertices, after the halo exchange."""

    def update_momentum(self, rank: RankState, update: VertexUpdate) -> None:
        """Update velocities and accelerations of the vertices, with contact there: (14, 17)."""
        field, part = rank.grid.field, WHOLE
        for active in rank.averaged_mass.by_planes(rank) if rank.averaged_mass else (field.active,):
            self.advance(rank, update, part, field._replace(active=active))
            part = FURTHER

    def hold(self, rank: RankState, update: VertexUpdate, field: Field) -> None:
        """Let momenta of a `field` become velocities that satisfy contact and faces, by no force.

        The rank's own before its update, or another like it after that.
        """
        self.advance(rank, update, WHOLE, field)

    def exchange(self, rank: RankState, update: VertexUpdate) -> None:
        """Exchange impulses between vertices at different positions."""

    def forces(self, rank: RankState, update: VertexUpdate, out: np.ndarray) -> None:
        """Add the forces of contact at a rank's vertices, in place of `update_momentum`.

        Parameters
        ----------
        out : (vertices, 3) float64
            The force on the lower-numbered body of each pair.
        """

    def overrun(self, rank: RankState, done: Step) -> list[str]:
        """Warnings of contact that was overrun, on rank 0; collective."""
        return []

    def moved(self) -> None:
        """Note that the rank's particles have changed."""

    def advance(
        self, rank: RankState, update: VertexUpdate, part: int, field: Field | None = None
    ) -> None:
        """Call `update_momentum` for a part of the update, of all planes or those of a `field`."""
        rank.call(
            update_momentum,
            self.scene.domain.frame,
            field or rank.grid.field,
            update.faces,
            update.forcing,
            update.ledger,
            self.data,
            part,
        )
