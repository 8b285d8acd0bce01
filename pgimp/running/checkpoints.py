"""Checkpoints of a run: schedule, number kept, and search for an intact one."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from time import monotonic
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pgimp.case.output import WallTime
from pgimp.case.writer import dump_case
from pgimp.errors import DamagedError, RunError, explain
from pgimp.io.checkpoints import checkpointwriter
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.io.rundir import runinfo
from pgimp.mpi.collective import all_or_none, on_root
from pgimp.mpi.communicator import Communicator
from pgimp.running.probes import Record
from pgimp.running.schedule import Schedule
from pgimp.scene.bodies.saved_state import checkpoint_attributes
from pgimp.solver.state.state import capture

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.solver.simulation import Simulation

CHECKPOINT = re.compile(r"step-(\d{9,})\.h5")
DAMAGED = ".damaged"
# Bytes per second of a slow disk, assumed before the first checkpoint.
_SLOW = 100e6


class About(BaseModel):
    """Header of a checkpoint: the checkpoint itself and the output, without the state."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    program: Literal["pgimp"]
    case: str
    frames: int = Field(ge=0, le=2**53)
    history: int = Field(ge=-1, le=2**53)
    lines: int | None = Field(default=None, ge=0, le=2**53)
    probes: dict[str, Record] = {}
    written: str
    made_by: dict[str, str | None]
    seconds: float | None = Field(ge=0.0, allow_inf_nan=False)
    state: dict[str, object]

    @classmethod
    def of(cls, file: CheckpointFile) -> Self:
        """Return a checkpoint's header.

        Raises
        ------
        DamagedError
            If it has no valid header.
        """
        try:
            return cls.model_validate(file.about)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, first["loc"]))
            raise DamagedError(f"its {where} is not what it must be: {first['msg']}") from None


class Checkpoints:
    """Writes the checkpoints of a run and deletes older ones.

    Parameters
    ----------
    directory : Path
        The run directory; the same on every rank.
    case : Case
        Gives interval and number.
    sim : Simulation
        The run, at its start or as resumed.

    Attributes
    ----------
    latest : int
        Step of the last checkpoint; -1 before the first.
    seconds : float
        Longest time of a checkpoint so far. Before the first it is an estimate, or the time from
        before the run was resumed.
    size : int
        Bytes of the checkpoints written by this process, on rank 0.
    """

    def __init__(self, directory: Path, case: Case, sim: Simulation) -> None:
        self.folder = directory / "checkpoints"
        self.latest, self.size = -1, 0
        every = case.checkpoint.every
        self._keep = int(case.checkpoint.keep)
        self._case = dump_case(case)
        self._made_by = made_by()
        self._schedule = Schedule(None if isinstance(every, WallTime) else every)
        self._schedule.skip(sim.time, sim.step, sim.dt)
        self._pause = every.wall if isinstance(every, WallTime) else math.inf
        self._next = monotonic() + self._pause
        row = sum(array[0].nbytes for array in sim.population.columns)
        self.seconds = sim.count * row / _SLOW
        self._measured = False
        self._stands_for: tuple[int, int, Mapping[str, Record]] = (-1, -1, {})

    def resume(self, comm: Communicator, step: int, about: About) -> None:
        """Continue after the checkpoint of a step; collective.

        Later checkpoints are damaged; they are renamed, so that they do not count as kept ones.
        """
        self.latest, self._stands_for = step, (about.frames, about.history, about.probes)
        if about.seconds is not None:
            self.seconds, self._measured = about.seconds, True
        on_root(comm, self._set_aside)

    def _set_aside(self) -> None:
        for path in present(self.folder):
            if number_of(path) > self.latest:
                with suppress(OSError):
                    path.rename(path.with_name(path.name + DAMAGED))

    def due(self, sim: Simulation) -> bool:
        """Return whether a checkpoint is due by step or simulated time; call it after each step."""
        return self._schedule.due(sim.time, sim.step, sim.dt)

    @property
    def overdue(self) -> bool:
        """Whether a checkpoint is due by wall-clock time; call it on one rank."""
        return monotonic() >= self._next

    def write(
        self,
        sim: Simulation,
        frames: int,
        line: int,
        probes: Mapping[str, Record] = MappingProxyType({}),
        lines: int | None = None,
    ) -> bool:
        """Write a checkpoint, unless it exists for this step and this output; collective.

        Parameters
        ----------
        sim : Simulation
            The run, between two steps.
        frames, line : int
            Number of frames, and step of the last line of the history, that are safe on disk.
        probes : mapping of str to Record
            Likewise for the probes.
        lines : int, optional
            Number of lines of the history.

        Returns
        -------
        bool
            Whether a checkpoint was written.

        Raises
        ------
        RunError
            On every rank, if it could not be written completely; previous checkpoints stay.
        """
        stands_for = (frames, line, probes)
        if sim.step == self.latest and stands_for == self._stands_for:
            return False
        began = monotonic()
        path = self.folder / f"step-{sim.step:09d}.h5"
        records = sim.diagnostic_sums
        state, rows, whole, spread = capture(
            sim.rank,
            sim.now,
            sim.rate,
            sim.count,
            records,
            sim.watch,
            sim.stage,
            sim.clock,
            sim.settling,
            sim.calls.stored() if sim.calls else None,
        )
        about = {
            "program": "pgimp",
            "case": self._case,
            "frames": frames,
            "history": line,
            "lines": lines,
            "probes": {name: record.model_dump() for name, record in probes.items()},
            "written": runinfo.now(),
            "made_by": self._made_by,
            "seconds": self.seconds if self._measured else None,
            "state": state,
        }
        self.size += checkpointwriter.write(
            path, sim.comm, about, rows.columns, whole, rows.order, spread,
            rows.at if sim.population.released else None,
            checkpoint_attributes(sim.scene, sim.rank.grid.fields)
            | {"time": float(sim.time), "step": np.int64(sim.step)},
        )  # fmt: skip
        self.latest, self._stands_for = sim.step, stands_for
        on_root(sim.comm, self._delete_older)
        now = monotonic()
        self.seconds = max(self.seconds if self._measured else 0.0, now - began)
        self._measured = True
        self._next = now + self._pause
        return True

    def _delete_older(self) -> None:
        paths = [path for path in present(self.folder) if number_of(path) <= self.latest]
        for path in paths[self._keep :]:
            with suppress(OSError):
                path.unlink()


def made_by() -> dict[str, str | None]:
    """Return the versions, commit and CPU type that determine a run's bits."""
    versions = runinfo.versions()
    names = (runinfo.PROGRAM, "numpy", "numba", "llvmlite")
    found = {name: versions[name] for name in names}
    return found | {"commit": runinfo.commit(), "cpu": runinfo.cpu()}


def present(folder: Path) -> list[Path]:
    """List the checkpoints of a folder, intact or not, the newest first."""
    try:
        if not os.path.lexists(folder):
            return []
        names = [name for name in os.listdir(folder) if CHECKPOINT.fullmatch(name)]
    except OSError as error:
        raise RunError(f"cannot read {folder}: {explain(error)}") from error
    return sorted((folder / name for name in names), key=number_of, reverse=True)


def number_of(path: Path) -> int:
    """Return the step of a checkpoint from its name."""
    return int(path.stem.removeprefix("step-"))


def intact(
    paths: list[Path], comm: Communicator
) -> Iterator[tuple[Path, CheckpointFile | DamagedError]]:
    """Yield checkpoints, each with its content or its error; collective.

    Parameters
    ----------
    paths : list of Path
        The files, the same on every rank.
    comm : communicator
        Of all ranks, which check the checksums together.

    Yields
    ------
    (Path, CheckpointFile or DamagedError)
        The same on every rank.
    """
    for path in paths:
        try:
            file = all_or_none(comm, partial(CheckpointFile, path), DamagedError)
            all_or_none(comm, partial(file.verify, comm.rank, comm.size), DamagedError)
        except DamagedError as error:
            yield path, error
        else:
            yield path, file
