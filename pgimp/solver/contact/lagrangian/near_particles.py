"""Particles near contact at their current positions, with data of their reference vertices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.decomposition.population import Population
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.lagrangian.reference_grid import (
    REFERENCE_VERTEX,
    ReferenceVertices,
    read_reference_vertices,
)
from pgimp.kernels.contact.lagrangian.rigid_ends import UNKNOWN
from pgimp.kernels.contact.lagrangian.supports import Supports, find_supports, narrow_supports
from pgimp.kernels.contact.lagrangian.vertices import NEAR_MOTION, copy_near_motion
from pgimp.kernels.contact.volumes import BOXES
from pgimp.kernels.data.arguments import Field
from pgimp.kernels.grid.conditions import Holding
from pgimp.kernels.rigid.bodies import AnyRigidBodies
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.lagrangian.messages import swap
from pgimp.solver.contact.lagrangian.parts import move_to_boxes
from pgimp.solver.contact.lagrangian.selected import Selection, flat, plain

#: Numbers in a `NEAR_MOTION`.
MOTION = NEAR_MOTION.itemsize // 8


class Near(NamedTuple):
    """A rank's data in a step for its share of the vertices."""

    #: The particles, the vertices that they may share, and their initial supports.
    selection: Selection
    motion: np.ndarray  #: (n,) NEAR_MOTION: The particles in this step.
    now: Supports  #: Their supports at their current positions.
    vertices: ReferenceVertices  #: All their vertices, in the order of their keys.


class NearParticles:
    """The particles of a selection in a step, on the ranks that share out the vertices round them.

    Parameters
    ----------
    local : (k, 3) uint32
        See `Supports`.
    """

    def __init__(self, scene: Scene, comm: Communicator, local: np.ndarray) -> None:
        self.scene, self.comm, self.call, self._local = scene, comm, Bound(), local
        exact = scene.settings.exact_surfaces.any() and not scene.settings.mixed
        self._plain, self._exact = plain(scene), bool(exact)
        self._kept: dict[str, np.ndarray] = {}
        self._place = b""
        self._supports: dict[str, Supports] = {}

    def gather(
        self, field: Field, population: Population, selection: Selection, holding: Holding
    ) -> Near:
        """Gather the data for this rank's share of the vertices; collective.

        Parameters
        ----------
        field : Field
            After the update of momentum.
        population : Population
            This rank's particles.
        selection : Selection
            Those near contact.
        holding : Holding
            Faces and constraints.
        """
        given, call = selection.given, self.call
        if population.outdated:
            population.update(given.every)
        rows = population.order[given.offsets].astype(np.int64)
        motion = self._storage("motion", len(rows), NEAR_MOTION)
        call(copy_near_motion, self._plain, population.columns, rows, motion)
        if self._exact:
            move_to_boxes(self.scene, population.columns, rows, motion)
        values = self._storage("values", len(given.keys), REFERENCE_VERTEX)
        call(read_reference_vertices, holding, field, given.keys, values)
        if self.comm.size > 1:
            motion = swap(self.comm, motion, given.particles, selection.particles)
            values = swap(self.comm, values, given.vertices, selection.vertices)
            found, values = values, self._storage("sorted", len(values), REFERENCE_VERTEX)
            np.take(flat(found), selection.order, axis=0, out=flat(values), mode="clip")
        now = self.supports(selection, motion)
        return Near(selection, motion, now, ReferenceVertices(selection.keys, values))

    def supports(self, selection: Selection, motion: np.ndarray) -> Supports:
        """Supports of particles at their current positions; they hold until the next ones."""
        supports = self._room(len(motion), "current")
        x = motion.view(np.float64).reshape(len(motion), MOTION)  # begins with the position
        shape, frame = self.scene.settings.uncut, self.scene.domain.frame
        self.call(find_supports, shape, frame, selection.half_width, x, supports)
        return supports

    def left(self, near: Near) -> tuple[Supports, float]:
        """Supports for the sums of volumes, and whether their gradient counts."""
        table = near.selection.table
        if not isinstance(self.scene.settings.uncut, BOXES):
            return near.now, 1.0
        if not needed(near.selection.cut):
            return near.now, 0.0
        left, scene = self._room(len(table), "left"), self.scene
        self.call(
            narrow_supports,
            scene.settings.uncut,
            scene.domain.frame,
            table,
            near.motion,
            near.now,
            left,
        )
        return left, 0.0

    def forget_moved(self, near: Near, rigid_bodies: AnyRigidBodies) -> None:
        """Have found again what rigid bodies fill of vertices, where any has moved."""
        if not rigid_bodies:
            return
        place = rigid_bodies.motion["centre"].tobytes() + rigid_bodies.motion["rotation"].tobytes()
        if place != self._place:
            near.selection.contact_vertices.fills["state"] = UNKNOWN
            self._place = place

    def _storage(self, name: str, count: int, kind: np.dtype) -> np.ndarray:
        """Storage for so many records, kept from step to step."""
        kept = self._kept.get(name)
        if kept is None or len(kept) < count:
            kept = self._kept[name] = np.empty(count + count // 8, kind)
        return kept[:count]

    def _room(self, count: int, kind: str) -> Supports:
        """Storage for the supports of a kind."""
        kept = self._supports.get(kind)
        if kept is None or len(kept.first) < count:
            kept = self._supports[kind] = Supports.empty(
                count + count // 8, self._local, self.scene.case.axisymmetric
            )
        every = {name: getattr(kept, name)[:count] for name in ("first", "w", "g", "hoop")}
        return kept._replace(**every)
