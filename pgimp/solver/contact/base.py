"""Contact as the step sees it, and the contact of bodies that share one velocity field: none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.grid.momentum import WHOLE, update_momentum
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step
from pgimp.solver.vertices import VertexUpdate

if TYPE_CHECKING:
    from pgimp.solver.contact.free_bodies import FreeBodies


class NoContact:
    """The contact of bodies that share one velocity field; its kinds override what they do.

    A step calls the methods in the order in which they stand here. All are collective.

    Parameters
    ----------
    scene : Scene
        The scene.
    comm : communicator
        Of all ranks.

    Attributes
    ----------
    at_vertices : bool
        Whether bodies exchange impulses at vertices that they share, which frames may show.
    fields : tuple of int
        Number of each body's velocity field; () if all share one for ever.
    free : FreeBodies or None
        The rigid bodies that move freely, if there are any.
    data : Contact or ()
        The data of kernels for the vertices where bodies meet; () without any.
    """

    at_vertices = False
    fields: tuple[int, ...] = ()
    free: FreeBodies | None = None
    data: Any = ()

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.scene, self.comm = scene, comm

    @property
    def rigid_bodies(self) -> Any:
        """The rigid bodies for kernels, as they are in this step; () where there are none."""
        return ()

    def assign_fields(self, rank: RankState) -> None:
        """Assign velocity fields to bodies: one to those that cannot meet soon."""

    def detect(self, rank: RankState, t: Step, ledger: Ledger) -> None:
        """Find the vertices where bodies meet, after the halo exchange."""

    def update_momentum(self, rank: RankState, update: VertexUpdate) -> None:
        """Update velocities and accelerations of the vertices, with contact there: (14, 17)."""
        self.advance(rank, update, WHOLE)

    def exchange(self, rank: RankState, update: VertexUpdate) -> None:
        """Exchange impulses between vertices of different places."""

    def forces(self, rank: RankState, update: VertexUpdate, out: np.ndarray) -> None:
        """Add the forces of contact at a rank's vertices, in place of `update_momentum`.

        Parameters
        ----------
        out : (vertices, 3) float64
            The force on the bodies with the lower numbers.
        """

    def moved(self) -> None:
        """Note that the rank's particles are others now."""

    def advance(self, rank: RankState, update: VertexUpdate, part: int) -> None:
        """Call `update_momentum` for a part of the update."""
        rank.call(
            update_momentum, self.scene.frame, rank.grid.field, update.faces, update.forcing,
            update.ledger, self.data, part,
        )  # fmt: skip
