"""Reading a run directory, during the run and after it, without MPI."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.errors import RunError, UsageError, explain
from pgimp.io.results import history
from pgimp.io.results.frame import Array, Frame
from pgimp.io.results.tables import Fields, Table, Tables
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import FRAME, RUN
from pgimp.io.rundir.probefiles import probe_files
from pgimp.storage.linereader import so_far
from pgimp.storage.plain import read_plain
from pgimp.terminal import escape

if TYPE_CHECKING:
    from pgimp.case.schema import Case

__all__ = ["Frame", "Run"]

UnitsOf = Callable[["Run", Sequence[str]], dict[str, str]]
ErrorsOf = Callable[["Run", str, Table], dict[str, np.ndarray]]


class Run:
    """A run directory.

    Parameters
    ----------
    path : Path
        The directory.
    units : callable, optional
        Takes the run and names of columns; returns their units.
    errors : callable, optional
        Takes the run, the name of a probe, empty for the history, and its table; returns the
        estimated errors of the table's columns.

    Raises
    ------
    UsageError
        If it has no run.
    """

    def __init__(
        self, path: Path, units: UnitsOf | None = None, errors: ErrorsOf | None = None
    ) -> None:
        self.path, self._units, self._errors = path, units, errors
        self._known: dict[Path, tuple[tuple[int, int], Frame]] = {}
        if runinfo.read(path / RUN) is None:
            there = (path / RUN).exists()
            why = f"its {RUN} is damaged, or not pgimp's" if there else f"it has no {RUN}"
            raise UsageError(f"{path} is no run directory of pgimp: {why}.")

    @property
    def info(self) -> dict[str, Any]:
        """The last start in run.json: versions, hosts, state, steps and so on.

        During the run, steps and time come from the last line of history.csv.
        """
        last = self.starts[-1]
        return last | so_far(self.path) if last["state"] == "running" else last

    @property
    def starts(self) -> list[dict[str, Any]]:
        """All starts in run.json, the last one as in `info`, but without what goes on."""
        content = runinfo.read(self.path / RUN)
        if content is None:
            raise UsageError(f"{self.path} is no run directory any more: its {RUN} has gone.")
        starts: list[dict[str, Any]] = content["starts"]
        return starts

    @property
    def state(self) -> str:
        """State in run.json: running, done, stopped or failed."""
        return self.info["state"]

    @cached_property
    def case(self) -> Case:
        """The case as resolved, with every default."""
        from pgimp.case.reader import read_case
        from pgimp.schema.document import LARGEST_FILE

        path = self.path / "case.yaml"
        try:
            return read_case(read_plain(path, LARGEST_FILE), str(path), [])
        except OSError as error:
            raise RunError(f"cannot read {path}: {explain(error)}") from error

    @property
    def frames(self) -> list[Frame]:
        """Frames so far, in order of time."""
        folder = self.path / "frames"
        found = [path for path in folder.glob("particles-*.h5") if FRAME.fullmatch(path.name)]
        return sorted(map(self._frame, found), key=lambda frame: frame.number)

    def _frame(self, path: Path) -> Frame:
        """Return the frame of a file, read again if another run has replaced the file."""
        try:
            about = path.stat()
        except OSError as error:
            raise RunError(f"cannot read {path}: {explain(error)}") from error
        stamp = about.st_ino, about.st_mtime_ns
        if path not in self._known or self._known[path][0] != stamp:
            self._known[path] = stamp, Frame(path)
        return self._known[path][1]

    def __repr__(self) -> str:
        """Return the progress of the run."""
        info = self.info
        steps = f"{info['steps']} steps{' so far' * (info['state'] == 'running')}"
        return escape(f"<Run {self.path}: {info['state']}, {steps}, {len(self)} frames>")

    def __len__(self) -> int:
        """Return the number of frames so far."""
        return len(self.frames)

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames."""
        return iter(self.frames)

    def frame(self, index: int) -> Frame:
        """Return a frame.

        Parameters
        ----------
        index : int
            Its number; -1 is the last frame.

        Returns
        -------
        Frame
            The frame.

        Raises
        ------
        IndexError
            If there is no such frame (yet).
        """
        frames = self.frames
        try:
            return frames[index]
        except IndexError:
            raise IndexError(f"{self.path} has no frame {index}: it has {len(frames)}") from None

    @property
    def times(self) -> Array:
        """Simulated times of the frames; ndarray of shape (frames,)."""
        return np.array([frame.time for frame in self.frames])

    @property
    def history(self) -> Table:
        """history.csv so far, a structured array: ``run.history["time"]``; `units`, `errors`."""
        return self._table(self.path / "history.csv")

    def _table(self, path: Path) -> Table:
        table: Table = history.read(path).view(Table)
        if self._units is not None:
            table.units_of = partial(self._units, self)
        if self._errors is not None:
            probe = "" if path.parent == self.path else path.stem
            table.errors_of = partial(self._errors, self, probe)
        return table

    @property
    def probes(self) -> Tables:
        """Each ``probes/NAME.csv`` so far, as `history`: ``run.probes["tip"]["position-x"]``."""
        files = sorted(probe_files(self.path))
        return Tables({path.stem: self._table(path) for path in files})

    def follow(self, number: int) -> Fields:
        """Follow a particle through the frames, from when it came to before it left the domain.

        Parameters
        ----------
        number : int
            Its id.

        Returns
        -------
        Fields
            Arrays of shape (frames,) or (frames, k) by name: ``time``, ``step`` and each field
            common to all frames. Only frames with the particle count, if it came or was removed.

        Raises
        ------
        KeyError
            If there is no such particle.
        IndexError
            If there is no frame yet.
        """
        frames = [self.frame(0), *self.frames[1:]]
        names = [name for name in frames[0].fields if all(name in frame for frame in frames)]
        values: dict[str, list[object]] = {name: [] for name in ["time", "step", *names]}
        for frame in frames:
            ids = frame["id"]
            row = int(np.searchsorted(ids, number))
            if row == len(ids) or ids[row] != number:
                if values["time"]:
                    break
                continue  # it may come later
            values["time"].append(frame.time)
            values["step"].append(frame.step)
            for name in names:
                values[name].append(frame.rows(name, row, row + 1)[0])
        if not values["time"]:
            raise KeyError(f"{self.path} has no particle {number} in any frame")
        return Fields({name: np.array(column) for name, column in values.items()})
