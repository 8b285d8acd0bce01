"""Frames of a run: positions and fields of all particles at the case's times."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pgimp.io.frames.particlefile import ParticleFile
from pgimp.io.frames.series import Entry, Series
from pgimp.io.frames.vtkseries import Mesh, described
from pgimp.io.frames.xdmf import Collection, particles
from pgimp.io.results.reader import Frame
from pgimp.io.rundir.ownfiles import FRAME
from pgimp.physics.fields import ALWAYS
from pgimp.solver.lagrangian.pieces import source_at

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.simulation import Simulation


class Frames(Series):
    """Writes the frames of a run and the XDMF file that lists them.

    Parameters
    ----------
    directory : Path
        The run directory; the same on every rank.
    case : Case
        Gives the title, the units and the optional fields.
    sim : Simulation
        The run.
    """

    def __init__(self, directory: Path, case: Case, sim: Simulation) -> None:
        super().__init__(sim.comm, Collection(directory / "particles.xdmf"), FRAME)
        self.enter(case, sim)

    def enter(self, case: Case, sim: Simulation) -> None:
        """Use the output settings of a case, or of another stage of it."""
        self.fields = [*ALWAYS, *(name for name in sim.scene.fields if name in case.output.fields)]
        compressed = case.output.compression != "none"
        self._file = ParticleFile(case, sim.scene, self.fields, case.output.precision, compressed)

    def write(self, sim: Simulation) -> None:
        """Write the present state as the next frame, and finish the previous one; collective.

        Parameters
        ----------
        sim : Simulation
            The run; it may continue at once.

        Raises
        ------
        RunError
            On every rank, if the disk is full, or if the previous frame could not be written
            completely. That frame then has no file; the frames before it are intact.
        """
        self.finish()
        path = self.folder / f"particles-{self.written:06d}.h5"
        storage = sim.live()
        rows = self._file.rows(
            self.comm, sim.population.columns.id[storage], storage, sim.count,
            not sim.scene.settings.loses,
        )  # fmt: skip
        time, step = float(sim.time), int(sim.step)
        what = f"write the frame {path} at step {step}"
        file = self._file.write(path, partial(source_at, sim.rank), rows, (time, step), what)
        types, kinds = self._file.types, self._file.kinds
        fields = {name: (kinds[name].columns, dtype) for name, dtype in types.items()}
        mesh = Mesh(path, time, rows.count, rows.count, 1, fields)
        text = particles(path, time, rows.count, types, kinds)
        self._wait_for(file, Entry(time, step, text, mesh))

    def _listed(self, path: Path) -> Entry:
        frame = Frame(path)
        types = {name: frame.types[name] for name in self.fields if name in frame}
        text = particles(path, frame.time, len(frame), types, self._file.kinds)
        return Entry(frame.time, frame.step, text, described(path))
