"""Frames of the grid: cells with particles, and values at their vertices."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pgimp.io.frames.mesh import Mesh, columns, described
from pgimp.io.frames.particlefile import FORMAT_VERSION
from pgimp.io.frames.series import Series
from pgimp.io.frames.writers import begin_frame
from pgimp.io.results.gridreader import GridFrame
from pgimp.io.rundir.ownfiles import GRID_FRAME
from pgimp.mpi.collective import on_root
from pgimp.physics.columns import GRID
from pgimp.storage.atomic import temporary
from pgimp.storage.datasets import Dataset, lay_out
from pgimp.storage.framefile import FrameFile
from pgimp.storage.unfinished import Unfinished, explained_errors, removed_on_error

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.simulation import Simulation
    from pgimp.solver.state.grid_state import ActiveGrid

Array = np.ndarray


class GridFrames(Series):
    """Writes the frames of the grid, if the case has any, and the files that list them.

    They have the numbers of the particles' frames. Each rank writes its own vertices and cells;
    the ranks' parts are consecutive in the file.

    Parameters
    ----------
    directory : Path
        The run directory; the same on every rank.
    case : Case
        Gives the title, the units and the quantities.
    """

    def __init__(self, directory: Path, case: Case, sim: Simulation) -> None:
        super().__init__(sim.comm, directory / "grid", GRID_FRAME)
        self.enter(case, sim)

    def enter(self, case: Case, sim: Simulation) -> None:
        """Use the output settings of a case, or of another stage of it."""
        self.fields = [name for name in GRID if name in case.output.grid]
        self._type = np.dtype(case.output.precision).newbyteorder("<").str
        self._dimension = case.dimensions
        self._attributes = {
            "format": FORMAT_VERSION,
            "title": str(case.title),
            "units": str(case.units),
            "dimensions": case.dimensions,
        }

    def write(self, sim: Simulation, number: int) -> None:
        """Write the grid as the next frame, and finish the previous one; collective.

        Parameters
        ----------
        sim : Simulation
            The run; it may continue at once.
        number : int
            Number of the particles' frame.

        Raises
        ------
        RunError
            On every rank, if there is no space for it, or if the previous frame could not be
            written completely.
        """
        if not self.fields:
            return
        from pgimp.solver.state.grid_state import active_grid

        self.finish()
        path = self.folder / f"grid-{number:06d}.h5"
        part, what = temporary(path), f"write the frame {path} at step {sim.step}"
        time, step = float(sim.time), int(sim.step)
        dt = 0.0
        if "contact" in self.fields:
            dt = float(sim.dt or sim.clock.next(sim.done, sim.fastest).dt)
        state = active_grid(sim.rank, time, dt)
        attributes = self._attributes | {"time": time, "step": np.int64(step)}

        says: dict[int, bytes] = {}

        def create() -> dict[str, int]:
            shape = (state.total[1], 2**self._dimension)
            cells = {"connectivity": np.broadcast_to(np.int64(0), shape)}
            layout = lay_out(self._datasets, state.total[0], attributes, cells, more=begin_frame)
            with explained_errors(what):
                layout.create(part)
            says.update(layout.parts)
            return layout.offsets

        with removed_on_error(part, self.comm):
            offsets = on_root(self.comm, create)
            file = FrameFile(part, self.comm)
            for place, data in says.items():
                file.write(place, data)
            for dataset in self._datasets:
                values = self._rounded(dataset.name, _values(dataset.name, state), file)
                place = offsets[dataset.name] + state.first[0] * dataset.row_bytes
                file.write(place, np.ascontiguousarray(values))
            place = offsets["connectivity"] + state.first[1] * 8 * 2**self._dimension
            file.write(place, state.cells)
            unfinished = Unfinished(part, path, file, self.comm, what)
        shapes = {name: (0 if name == "mass" else 3, self._type) for name in self._names}
        self._wait_for(
            unfinished, Mesh(path, time, step, *state.total, 2**self._dimension, columns(shapes))
        )

    @property
    def _names(self) -> list[str]:
        return ["position", *self.fields]

    @property
    def _datasets(self) -> list[Dataset]:
        meaning = {"position": "position of the vertex [length]"}
        meaning |= {name: GRID[name].meaning for name in self.fields}
        return [
            Dataset(name, self._type, (3,) if name != "mass" else (), {"meaning": meaning[name]})
            for name in self._names
        ]

    def _rounded(self, name: str, values: Array, file: FrameFile) -> Array:
        try:
            with np.errstate(over="raise", under="ignore"):
                return np.asarray(values, self._type)
        except FloatingPointError:
            file.error = file.error or (
                f"the {name} of a vertex is beyond the range of float32; go on with --resume "
                "--set output.precision=float64"
            )
            return np.zeros(values.shape, self._type)

    def resume(self, number: int) -> list[str]:
        """See `Series.resume`; nothing is done if there have never been frames of the grid."""
        there = on_root(self.comm, self._writers[0].path.exists)
        return super().resume(number) if self.fields or there else []

    def _missing(self, number: int, there: int) -> list[str]:
        """No messages: frames of the grid may have been requested only later."""
        return []

    def _listed(self, path: Path) -> Mesh:
        GridFrame(path)
        return described(path, self._names)


def _values(name: str, state: ActiveGrid) -> Array:
    return state.position if name == "position" else GRID[name].values(state)
