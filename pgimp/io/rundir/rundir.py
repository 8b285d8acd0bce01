"""The run directory: one run at a time, no accidental loss of results."""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import time
from collections.abc import Collection, Mapping
from contextlib import suppress
from pathlib import Path

from pgimp.errors import RunError, UsageError, explain
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import (
    COARSE,
    FAILED,
    FAILURE,
    FOLDERS,
    PART,
    RUN,
    TOP,
    companion_files,
    own_files,
    probes_so_far,
    remove_empty,
    require_room,
)
from pgimp.io.rundir.probefiles import PROBES
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.storage.atomic import write
from pgimp.storage.linereader import so_far
from pgimp.terminal import escape

#: State of a run while files of the previous run are still in its directory.
STARTING = "starting"
# Errors for a name that no disk can have as a directory.
_NO_PLACE = (errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP)
_LOCK = ".lock"
# If ranks fail together, the lowest reports, here as on the terminal.
_HEAD_START_SECONDS = 0.01
_LONGEST_HEAD_START_SECONDS = 0.2


class RunDirectory:
    """The directory of a run, locked until `release`.

    Parameters
    ----------
    path : Path
        Created with its parents if it does not exist.
    comm : communicator
        Of all ranks; creation is collective.
    overwrite : bool
        Whether an existing run may be replaced.
    resume : bool
        Whether an existing run is continued.
    probes : collection of str
        Names of the case's probes.

    Attributes
    ----------
    before : dict or None
        The last start of an existing run from run.json, with the step of the last checkpoint of all
        starts. Its state is "lost" if only the checkpoints are left.

    Raises
    ------
    UsageError
        On every rank, if the directory must not be used: it has a run, or foreign files of the
        same names or in the way, or is locked by another run.
    RunError
        On every rank, if it cannot be used: a full disk, no permission.
    """

    def __init__(
        self,
        path: Path,
        comm: Communicator,
        overwrite: bool = False,
        resume: bool = False,
        probes: Collection[str] = (),
    ) -> None:
        self.path, self.overwrite = path, overwrite
        self.comm = comm
        self._probes = probes
        self._lock = -1
        self._created = False
        self._accompanied = False
        self.before = on_root(comm, lambda: self._claim(overwrite, resume))

    def _claim(self, overwrite: bool, resume: bool) -> dict[str, object] | None:
        try:
            str(self.path).encode()
        except UnicodeEncodeError:
            raise UsageError(
                f"the name of the run directory, {str(self.path)!a}, is no text; choose another "
                "with -o"
            ) from None
        try:
            if self.path.exists() and not self.path.is_dir():
                raise UsageError(f"{self.path} is a file; name a directory with -o.")
            self._created = not self.path.exists()
            self.path.mkdir(parents=True, exist_ok=True)
            self._take_lock()
            before = self._examine(overwrite, resume)
            require_room(self.path, resume, self._probes)
            return before
        except OSError as error:
            self.release()
            raise self._refusal("use", error) from error
        except UsageError:
            self.release()
            raise

    def _take_lock(self) -> None:
        """Lock the directory; a dead run leaves its file behind, but no lock."""
        name = self.path / _LOCK
        while self._lock < 0:
            descriptor = os.open(name, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                holder = os.read(descriptor, 200).decode(errors="replace").strip()
                os.close(descriptor)
                raise UsageError(
                    f"a run is writing to {self.path}: {holder or 'of unknown process'}.\n"
                    "Wait for it, stop it, or choose another directory with -o."
                ) from None
            except OSError:
                # No locks on this file system: one run at a time is then up to the user.
                pass
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), name.stat()):
                    self._lock = descriptor
                    break
            os.close(descriptor)  # the run that held it has just removed the file
        os.ftruncate(self._lock, 0)
        line = f"process {os.getpid()} on {socket.gethostname()}, since {runinfo.now()}\n"
        os.write(self._lock, line.encode())

    def _examine(self, overwrite: bool, resume: bool) -> dict[str, object] | None:
        """Return the last start of an existing run; raise if the directory may not be used."""
        there = [name for name in (*TOP, *FOLDERS, PROBES) if os.path.lexists(self.path / name)]
        run = runinfo.read(self.path / RUN)
        if run is None and resume and any((self.path / "checkpoints").glob("step-*.h5")):
            return {"state": "lost", "checkpoint": 0}
        if run is None and there:
            raise UsageError(
                f"{self.path} has a {there[0]}, but no run of pgimp: a run there would replace it."
                "\nChoose another directory with -o."
            )
        if run is None:
            return None
        last = run["starts"][-1]
        if not (overwrite or resume):
            state, steps = last["state"], last["steps"]
            if state == "running":
                state, steps = "running or killed", so_far(self.path).get("steps", 0)
            raise UsageError(
                f"{self.path} holds a run ({state}, begun {last['began']}, {steps} steps).\n"
                "Add --resume to go on with it, --overwrite to replace it, or choose another "
                "directory with -o."
            )
        made = [start.get("checkpoint") for start in run["starts"]]
        made = [step for step in made if step is not None]
        return last | {"checkpoint": made[-1] if made else None}

    def prepare(
        self, texts: dict[str, bytes], start: dict[str, object], resume: bool = False
    ) -> None:
        """Write the initial files of a run; collective.

        An older run is deleted; if it is resumed, only its half-written files are.

        Parameters
        ----------
        texts : dict of str to bytes
            Files and their content.
        start : dict
            Entry of run.json for this start.
        resume : bool
            Whether to continue the existing run.

        Raises
        ------
        UsageError, RunError
            On every rank, if that is not possible; a UsageError changes nothing.
        """
        on_root(self.comm, lambda: self._prepare(texts, start, resume))

    def accompany(self, start: dict[str, object]) -> None:
        """Keep the companions of the run from here on; collective.

        Unless the run is resumed, those of an older one are deleted with it.

        Parameters
        ----------
        start : dict
            Entry of run.json until the run itself starts.

        Raises
        ------
        UsageError, RunError
            As from `prepare`.
        """
        if self.before is None or self.overwrite:
            self.prepare({}, start | {"state": STARTING})
        self._accompanied = True

    def _prepare(self, texts: dict[str, bytes], start: dict[str, object], resume: bool) -> None:
        try:
            require_room(self.path, resume, self._probes)
            start = start | {PROBES: sorted(self._probes)}
            # Dropped probes are only in run.json.
            both = {PROBES: sorted({*self._probes, *probes_so_far(self.path)})}
            for name in FOLDERS:
                (self.path / name).mkdir(exist_ok=True)
            own = list(own_files(self.path))
            if not (resume or self._accompanied):
                own += companion_files(self.path)
            if resume:
                runinfo.append(self.path / RUN, start | both)
            else:
                # From here to the end of this block the directory has parts of two runs.
                runinfo.write(self.path / RUN, start | both | {"state": STARTING})
            for path in own:
                past = path.name == FAILED or path.parent.name == FAILURE
                if not resume or past or PART.fullmatch(path.name):
                    path.unlink(missing_ok=True)
            if not (resume or self._accompanied):
                remove_empty(self.path / COARSE)
            for name, text in texts.items():
                write(self.path / name, text)
            if not resume:
                runinfo.write(self.path / RUN, start)
        except OSError as error:
            raise self._refusal("write to", error) from error

    def _refusal(self, action: str, error: OSError) -> RunError | UsageError:
        message = f"cannot {action} the run directory {self.path}: {explain(error)}"
        return UsageError(message) if error.errno in _NO_PLACE else RunError(message)

    def record_failure(
        self, state: str, step: int, when: float, message: str, seconds: float | None = None
    ) -> None:
        """Record the reason for an early end in run.json and log.txt, on the first rank to fail.

        The `state` is "failed" or "stopped"; otherwise as in `finish`, but not collective.
        """
        time.sleep(min(self.comm.rank * _HEAD_START_SECONDS, _LONGEST_HEAD_START_SECONDS))
        # If the disk is full or missing, only the terminal has the message.
        with suppress(OSError):
            os.close(os.open(self.path / FAILED, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
            self._end(state, step, when, seconds, message)
            with open(self.path / "log.txt", "a", encoding="utf-8") as stream:
                stream.write(f"{state} at step {step}, t = {when!r}: {escape(message)}\n")

    def finish(
        self,
        state: str,
        step: int,
        when: float,
        seconds: float,
        message: str | None = None,
        figures: Mapping[str, object] | None = None,
    ) -> None:
        """Record the normal end of the run in run.json; collective.

        Parameters
        ----------
        state, step, when : str, int, float
            "done" or "stopped"; last step and simulated time.
        seconds : float
            Wall time of the steps, without set-up and output.
        message, figures : str, mapping, optional
            Reason for stopping; further entries, such as timings.

        Raises
        ------
        RunError
            On every rank, if it cannot be written, or the directory has gone.
        """

        def action() -> None:
            try:
                self._end(state, step, when, seconds, message, **(figures or {}))
            except OSError as error:
                raise self._refusal("write to", error) from error

        on_root(self.comm, action)

    def note(self, **entries: object) -> None:
        """Record entries of this start in run.json; collective.

        Raises
        ------
        RunError
            On every rank, if it cannot be written, or the directory has gone.
        """

        def action() -> None:
            try:
                runinfo.update(self.path / RUN, **entries)
            except OSError as error:
                raise self._refusal("write to", error) from error

        on_root(self.comm, action)

    def _end(self, *entries: object, **figures: object) -> None:
        names = ("state", "steps", "time", "seconds", "message")
        changes = dict(zip(names, entries, strict=True)) | figures
        runinfo.update(self.path / RUN, ended=runinfo.now(), **changes)

    def release(self) -> None:
        """Release the directory for other runs; delete it if this run made it and it is empty."""
        if self._lock >= 0:
            with suppress(OSError):
                (self.path / _LOCK).unlink()
            os.close(self._lock)
            self._lock = -1
        if self._created:
            with suppress(OSError):
                self.path.rmdir()
