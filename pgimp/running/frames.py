"""Frames of a run: positions and fields of all particles at the case's times."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.io.frames.mesh import Mesh, described
from pgimp.io.frames.particlefile import ParticleFile
from pgimp.io.frames.series import Series
from pgimp.io.results.reader import Frame
from pgimp.io.rundir.ownfiles import FRAME
from pgimp.physics.derived import RECOVERED
from pgimp.physics.fields import ALWAYS
from pgimp.solver.lagrangian.pieces import source_at
from pgimp.solver.lagrangian.recovered_stress import recovered_at

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.simulation import Simulation


class Frames(Series):
    """Writes the frames of a run and the files that list them.

    Parameters
    ----------
    directory : Path
        The run directory; the same on every rank.
    case : Case
        Gives the title, the units and the optional fields.
    """

    def __init__(self, directory: Path, case: Case, sim: Simulation) -> None:
        super().__init__(sim.comm, directory / "particles", FRAME)
        self.enter(case, sim)

    def enter(self, case: Case, sim: Simulation) -> None:
        """Use the output settings of a case, or of another stage of it."""
        self.fields = [*ALWAYS, *(name for name in sim.scene.fields if name in case.output.fields)]
        compressed = case.output.compression != "none"
        self._file = ParticleFile(case, sim.scene, self.fields, case.output.precision, compressed)

    def write(self, sim: Simulation, number: int | None = None) -> None:
        """Write the present state as the next frame, and finish the previous one; collective.

        Parameters
        ----------
        sim : Simulation
            The run; it may continue at once.
        number : int, optional
            Number of the frame, by default the next one.

        Raises
        ------
        RunError
            On every rank, if the disk is full, or if the previous frame could not be written
            completely. That frame then has no file; the frames before it are intact.
        """
        self.finish()
        number = self.written if number is None else number
        path = self.folder / f"particles-{number:06d}.h5"
        storage = sim.live()
        rows = self._file.rows(
            self.comm, sim.population.columns.id[storage], storage, sim.count,
            not sim.scene.settings.loses,
        )  # fmt: skip
        time, step = float(sim.time), int(sim.step)
        what = f"write the frame {path} at step {step}"
        instead = {}
        if RECOVERED in self.fields:
            instead[RECOVERED] = recovered_at(sim.rank, storage, rows.storage)
        at = partial(source_at, sim.rank)
        file = self._file.write(path, at, rows, (time, step), what, instead)
        self._wait_for(file, self._file.mesh(path, (time, step), rows.count))

    def _listed(self, path: Path) -> Mesh:
        Frame(path)
        return described(path, self.fields)
