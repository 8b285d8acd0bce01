"""Absorbing faces of a rank: their state, which all ranks have alike, and their forces.

A face's state is found in the first step in which it absorbs: the forces that then hold its
vertices, and the wave speeds there. From then on it is constant, but where bodies are removed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.errors import DamagedError
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.grid.absorbing import (
    NUMBERS,
    REACTION_MASS,
    AbsorbingFace,
    absorb,
    book_absorbed,
)
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.damping.absorbing_start import absorbing_face, find_face, without
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart, VertexUpdate

if TYPE_CHECKING:
    from pgimp.io.checkpoints.checkpointfile import CheckpointFile

    Read = Callable[[CheckpointFile, str, tuple[int, ...]], np.ndarray]

#: Names of a face's datasets in checkpoints, before its own: lower corner and extent of its
#: vertices; the face's values and those of its vertices.
BOX, STATE = "absorbing-box-", "absorbing-"


class AbsorbingFaces(StepPart):
    """The absorbing faces of a stage.

    Parameters
    ----------
    scene : Scene
        Its scene.
    before : AbsorbingFaces, optional
        Absorbing faces of the stage before; faces that stay absorbing keep their state.

    Attributes
    ----------
    found : dict of str to AbsorbingFace
        The faces whose state is found.
    """

    def __init__(self, scene: Scene, before: AbsorbingFaces | None = None) -> None:
        self.scene, self._impulses = scene, dict[str, np.ndarray]()
        self.found: dict[str, AbsorbingFace] = {}
        for number, face in scene.domain.absorbing:
            if before is not None and face.name in before.found:
                self.found[face.name] = before.found[face.name]._replace(number=number)

    def add_forces(self, rank: RankState, update: VertexUpdate, find: bool = True) -> None:
        """Add the faces' forces to the sums at the vertices, before the momentum update.

        Collective where a face's state is still to be found, and `find`.
        """
        domain, field = self.scene.domain, rank.grid.field
        if domain.settling:
            return
        due = [each for each in domain.absorbing if find and each[1].name not in self.found]
        for n, (number, face) in enumerate(due):
            later = [other for _, other in due[n + 1 :]]
            state = find_face(rank, update, number, face, ([*self.found.values()], later))
            self.found[face.name] = state
        size = len(rank.grid.G) // RECORD * 3
        for name in self.found:
            if name not in self._impulses or len(self._impulses[name]) < size:
                self._impulses[name] = np.empty(size)
        for moving in (False, True):
            for name, state in self.found.items():
                rank.call(
                    absorb, domain.frame, field, update.forcing, state, self._impulses[name],
                    update.ledger, moving,
                )  # fmt: skip

    def book(self, rank: RankState, update: VertexUpdate) -> None:
        """Book energy and work of the faces in a step, after all conditions and contact."""
        if self.scene.domain.settling:
            return
        for name, state in self.found.items():
            impulse = self._impulses[name]
            rank.call(book_absorbed, rank.grid.field, update.forcing, state, impulse, update.ledger)

    def remove(self, rank: RankState, bodies: Sequence[int]) -> None:
        """Leave of forces and masses what is of bodies that stay; collective, before others go."""
        self.found = {name: without(rank, state, bodies) for name, state in self.found.items()}

    def datasets(self) -> dict[str, np.ndarray]:
        """Return the state of the faces by its names in checkpoints."""
        found = {}
        for name, state in self.found.items():
            found[BOX + name] = np.concatenate([state.lower, state.extent]).astype(float)
            found[STATE + name] = state.values
        return found

    def stored(self, source: CheckpointFile, read: Read) -> dict[str, np.ndarray]:
        """Read the faces' state from a checkpoint, as datasets.

        Parameters
        ----------
        read : callable
            Reads a dataset of a given shape.

        Raises
        ------
        DamagedError
            If it does not fit the faces.
        """
        found, most = {}, 1.0 + np.prod(self.scene.domain.frame.vertices, dtype=float)
        for _, face in self.scene.domain.absorbing:
            if BOX + face.name not in source.whole:
                continue
            _, shape = source.whole.get(STATE + face.name, (None, ()))
            if len(shape) != 2 or not 0 < shape[0] <= most or shape[1] != NUMBERS:
                raise DamagedError(f"its absorbing face {face.name} is not of the scene's shape")
            box, values = (
                read(source, BOX + face.name, (6,)),
                read(source, STATE + face.name, shape),
            )
            wrong = (box < 0.0).any() or (np.floor(box) != box).any()
            wrong |= len(values) != 1 + box[3:].prod() or (values[:, REACTION_MASS:] < 0.0).any()
            if wrong:
                raise DamagedError(f"the state of its absorbing face {face.name} is damaged")
            found[BOX + face.name], found[STATE + face.name] = box, values
        return found

    def restore(self, found: Mapping[str, np.ndarray]) -> None:
        """Take over the state of the faces, see `stored`."""
        for number, face in self.scene.domain.absorbing:
            if BOX + face.name in found:
                lower, extent = found[BOX + face.name].astype(np.int64).reshape(2, 3)
                values = found[STATE + face.name]
                self.found[face.name] = absorbing_face(
                    self.scene, number, face, lower, extent, values
                )


def absorbing_of(
    scene: Scene, _: Communicator, before: AbsorbingFaces | None = None
) -> AbsorbingFaces | None:
    """Return the absorbing faces of a scene; None without any.

    At rest faces hold with other forces, found anew.
    """
    if before and (before.scene.case.rests or scene.case.rests):
        before = None
    return AbsorbingFaces(scene, before) if scene.domain.absorbing else None
