"""Frames of the rigid bodies: their surfaces in present poses, for pictures and ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pgimp.io.frames.mesh import Mesh, columns, described
from pgimp.io.frames.particlefile import FORMAT_VERSION
from pgimp.io.frames.series import Series
from pgimp.io.frames.writers import begin_frame
from pgimp.io.rundir.ownfiles import RIGID_FRAME
from pgimp.mpi.collective import on_root
from pgimp.storage.atomic import temporary
from pgimp.storage.datasets import Dataset, lay_out
from pgimp.storage.framefile import FrameFile
from pgimp.storage.unfinished import Unfinished, explained_errors, removed_on_error

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.simulation import Simulation


class RigidFrames(Series):
    """Writes the surfaces of rigid bodies, if the case has any, and the files that list them.

    They have the numbers of the particles' frames. Rank 0 has all surfaces, and writes them.

    Parameters
    ----------
    directory : Path
        The run directory; the same on every rank.
    case : Case
        Gives the title and the units.
    """

    def __init__(self, directory: Path, case: Case, sim: Simulation) -> None:
        super().__init__(sim.comm, directory / "rigid", RIGID_FRAME)
        self.enter(case, sim)

    def enter(self, case: Case, sim: Simulation) -> None:
        """Use the bodies of a case, or of another stage of it."""
        self._dimension = case.dimensions
        self._attributes = {
            "format": FORMAT_VERSION,
            "title": str(case.title),
            "units": str(case.units),
            "dimensions": case.dimensions,
            "bodies": list(case.rigid_bodies),
        }

    def write(self, sim: Simulation, number: int) -> None:
        """Write the surfaces as the next frame, and finish the previous one; collective.

        Raises
        ------
        RunError
            On every rank, if there is no space for it, or if the previous frame could not be
            written completely.
        """
        rigid_bodies = sim.scene.interaction.rigid_bodies
        if not rigid_bodies:
            return
        self.finish()
        path = self.folder / f"rigid-{number:06d}.h5"
        part, what = temporary(path), f"write the frame {path} at step {sim.step}"
        time, step = float(sim.time), int(sim.step)
        poses = rigid_bodies.poses(time, sim.rank.free.states if sim.rank.free else [])
        attributes = self._attributes | {"time": time, "step": np.int64(step)}

        def create() -> tuple[dict[str, int], dict[int, bytes]]:
            layout = lay_out(
                [
                    Dataset("position", "<f8", (3,), {"meaning": "position [length]"}),
                    Dataset("body", "<i8", (), {"names": list(rigid_bodies.names)}),
                ],
                len(rigid_bodies.surface.body),
                attributes,
                {"connectivity": rigid_bodies.surface.cells},
                more=begin_frame,
            )
            with explained_errors(what):
                layout.create(part)
            return layout.offsets, layout.parts

        with removed_on_error(part, self.comm):
            offsets, says = on_root(self.comm, create)
            file = FrameFile(part, self.comm)
            if self.comm.rank == 0:
                for place, data in says.items():
                    file.write(place, data)
                file.write(offsets["position"], rigid_bodies.surface_at(poses, sharp=True))
                file.write(offsets["body"], rigid_bodies.surface.body)
                file.write(offsets["connectivity"], rigid_bodies.surface.cells)
            unfinished = Unfinished(part, path, file, self.comm, what)
        counts = len(rigid_bodies.surface.body), len(rigid_bodies.surface.cells)
        fields = columns({"position": (3, "<f8"), "body": (0, "<i8")})
        nodes = 2 ** (self._dimension - 1)
        self._wait_for(unfinished, Mesh(path, time, step, *counts, nodes, fields))

    def resume(self, number: int) -> list[str]:
        """See `Series.resume`; nothing is done if there is no rigid body."""
        return super().resume(number) if self._attributes["bodies"] else []

    def _listed(self, path: Path) -> Mesh:
        return described(path, ("position", "body"))
