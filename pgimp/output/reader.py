"""Reading a run directory, during the run and after it, without MPI."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.errors import PgimpError, RunError, UsageError
from pgimp.output import history, runinfo
from pgimp.output.collective import explain
from pgimp.output.hdf5 import open_file
from pgimp.output.probefiles import probe_files
from pgimp.output.rundir import FRAME, RUN

if TYPE_CHECKING:
    from pgimp.case.schema import Case

Array = np.ndarray


def open(directory: str | Path) -> Run:
    """Open a run directory, also of a run that goes on or died.

    Parameters
    ----------
    directory : str or Path
        The run directory.

    Returns
    -------
    Run
        Its results; what the run adds later appears as well.

    Raises
    ------
    UsageError
        If the directory holds no run.
    """
    return Run(Path(directory))


class Frame:
    """The particles at one time; ``frame["stress"]`` reads a field.

    Parameters
    ----------
    path : Path
        The frame's file.

    Attributes
    ----------
    number : int
        Its place among the frames of the run, from 0.
    time : float
        Its simulated time.
    step : int
        The step after which it was written.
    fields : list of str
        The fields it has, in the order of the file format.
    types : dict of str to str
        Their types; those of numbers that are not whole depend on the case's ``output.precision``.
    bodies, materials : list of str
        Names, by the index that the fields ``body`` and ``material`` hold.

    Raises
    ------
    RunError
        If the file cannot be read; later on, when a field cannot.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        match = FRAME.fullmatch(path.name)
        self.number = int(match[1]) if match else 0
        with _Reading(path) as file:
            self.time = float(file.attrs["time"])
            self.step = int(file.attrs["step"])
            self.bodies = [str(name) for name in file.attrs["bodies"]]
            self.materials = [str(name) for name in file.attrs["materials"]]
            self.fields = [name for name in file if name != "connectivity"]
            self.types = {name: file[name].dtype.newbyteorder("<").str for name in self.fields}
            self._count = len(file["id"])

    def __len__(self) -> int:
        """Return the number of particles."""
        return self._count

    def __contains__(self, name: object) -> bool:
        """Tell whether the frame has a field."""
        return name in self.fields

    def __getitem__(self, name: str) -> Array:
        """Read a field of all particles, in ascending id.

        Parameters
        ----------
        name : str
            One of `fields`.

        Returns
        -------
        ndarray, shape (N,) or (N, k)
            The values.

        Raises
        ------
        KeyError
            If the frame does not have the field.
        """
        return self.rows(name, 0, self._count)

    def rows(self, name: str, first: int, last: int) -> Array:
        """Read a stretch of a field.

        Parameters
        ----------
        name : str
            One of `fields`.
        first, last : int
            The rows from `first` up to but not including `last`.

        Returns
        -------
        ndarray, shape (last - first,) or (last - first, k)
            The values.

        Raises
        ------
        KeyError
            If the frame does not have the field.
        """
        if name not in self.fields:
            raise KeyError(f"{self.path.name} has no field {name}; it has {', '.join(self.fields)}")
        with _Reading(self.path) as file:
            return file[name][first:last]


class Run:
    """A run directory.

    Parameters
    ----------
    path : Path
        The directory.

    Raises
    ------
    UsageError
        If it holds no run.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._known: dict[Path, Frame] = {}
        if runinfo.read(path / RUN) is None:
            raise UsageError(f"{path} is no run directory of pgimp: it has no {RUN}.")

    @property
    def info(self) -> dict[str, Any]:
        """What run.json says of the last start: versions, hosts, state, steps and so on."""
        content = runinfo.read(self.path / RUN)
        if content is None:
            raise UsageError(f"{self.path} is no run directory any more: its {RUN} has gone.")
        return content["starts"][-1]

    @property
    def state(self) -> str:
        """One of running, done, stopped and failed, as run.json says."""
        return self.info["state"]

    @cached_property
    def case(self) -> Case:
        """The case as resolved, with every default."""
        from pgimp.case.reader import read_case

        path = self.path / "case.yaml"
        try:
            return read_case(path.read_text(encoding="utf-8"), str(path), [])
        except OSError as error:
            raise RunError(f"cannot read {path}: {explain(error)}") from error

    @property
    def frames(self) -> list[Frame]:
        """All frames so far, in order of time."""
        folder = self.path / "frames"
        found = [path for path in folder.glob("particles-*.h5") if FRAME.fullmatch(path.name)]
        for path in found:
            if path not in self._known:
                self._known[path] = Frame(path)
        return sorted((self._known[path] for path in found), key=lambda frame: frame.number)

    def __len__(self) -> int:
        """Return the number of frames so far."""
        return len(self.frames)

    def __iter__(self) -> Iterator[Frame]:
        """Go through the frames."""
        return iter(self.frames)

    def frame(self, index: int) -> Frame:
        """Return a frame.

        Parameters
        ----------
        index : int
            Its place; -1 is the last.

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
    def history(self) -> Array:
        """history.csv so far, as a structured array: ``run.history["time"]``."""
        return history.read(self.path / "history.csv")

    @property
    def probes(self) -> dict[str, Array]:
        """Each ``probes/NAME.csv`` so far, as `history`: ``run.probes["tip"]["position-x"]``."""
        return {path.stem: history.read(path) for path in sorted(probe_files(self.path))}

    def follow(self, number: int) -> dict[str, Array]:
        """Follow a particle through the frames, to the last one before it left the domain.

        Parameters
        ----------
        number : int
            Its id.

        Returns
        -------
        dict of str to ndarray, each of shape (frames,) or (frames, k)
            ``time``, ``step`` and each field that all frames have; of a particle that was removed
            only for the frames that have it.

        Raises
        ------
        KeyError
            If there is no such particle.
        """
        frames = self.frames
        names = [name for name in frames[0].fields if all(name in frame for frame in frames)]
        values: dict[str, list[Any]] = {name: [] for name in ["time", "step", *names]}
        for frame in frames:
            ids = frame["id"]
            row = int(np.searchsorted(ids, number))
            if row == len(ids) or ids[row] != number:
                if values["time"]:
                    break
                raise KeyError(f"{self.path} has no particle {number} in frame {frame.number}")
            values["time"].append(frame.time)
            values["step"].append(frame.step)
            for name in names:
                values[name].append(frame.rows(name, row, row + 1)[0])
        return {name: np.array(column) for name, column in values.items()}


class _Reading:
    """A file open for reading, whose errors name it."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __enter__(self) -> Any:
        try:
            self._file = open_file(self.path, "r")
        except OSError as error:
            raise self._damage(error) from error
        return self._file

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self._file.close()
        if isinstance(error, OSError | KeyError):
            raise self._damage(error) from error

    def _damage(self, error: OSError | KeyError) -> PgimpError:
        cause = explain(error) if isinstance(error, OSError) else f"it has no {error}"
        return RunError(f"cannot read {self.path}: {cause}")
