"""Stopping a run before its end: signals, the wall time, the limit of the batch job."""

from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from math import inf
from typing import Any

from pgimp import signals
from pgimp.mpi.communicator import Communicator

# Margin before a limit besides the checkpoint, over the whole time: for closing files, and for the
# exit of interpreter and launcher.
_MARGIN_PART = 0.05
_SHORTEST_MARGIN, _LONGEST_MARGIN = 1.0, 60.0
_SQUEUE_SECONDS = 5.0
# In a shell, the status of a process that a signal ended is this plus the signal's number.
_SIGNAL_STATUS = 128

_WALL_TIME = re.compile(r"(?:(\d{1,5})-(\d\d?)|(\d{1,7}))(?::(\d\d))?(?::(\d\d))?", re.ASCII)
_SLURM_TIME = re.compile(r"(?:(\d+)-)?(?:(\d+):)?(\d+):(\d\d)", re.ASCII)


def wall_time(text: str) -> float:
    """Read a wall time, as a type for `argparse`.

    Parameters
    ----------
    text : str
        ``HH:MM:SS`` with any number of hours, or with days as in Slurm, ``D-HH:MM:SS``. After
        days, minutes and seconds are optional. Without days all three are needed: schedulers
        differ in the meaning of ``90:00`` and ``90``.

    Returns
    -------
    float
        Seconds.

    Raises
    ------
    argparse.ArgumentTypeError
        If it has another form, or is zero.
    """
    match = _WALL_TIME.fullmatch(text.strip())
    seconds = 0
    if match is not None and (match[1] is not None or match[5] is not None):
        days, hours, minutes = int(match[1] or 0), int(match[2] or match[3]), int(match[4] or 0)
        rest = int(match[5] or 0)
        if minutes < 60 and rest < 60 and (match[1] is None or hours < 24):
            seconds = ((24 * days + hours) * 60 + minutes) * 60 + rest
    if seconds == 0:
        raise argparse.ArgumentTypeError(
            f"'{text}' is no wall time; write HH:MM:SS or D-HH:MM:SS, for example 2:00:00"
        )
    return float(seconds)


def clock(seconds: float) -> str:
    """Format a time in hours, minutes and seconds, readable by `wall_time`.

    Parameters
    ----------
    seconds : float
        The time; rounded to whole seconds.
    """
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"


def slurm_seconds_left() -> float | None:
    """Return the time left for the Slurm job around this process.

    Returns
    -------
    float or None
        Seconds; None outside of a job, if the job has no limit, or if it is unknown.
    """
    job = os.environ.get("SLURM_JOB_ID", "")
    if not job:
        return None
    # In newer versions; a past time belongs to an ended job, in a shell that it left behind.
    end = os.environ.get("SLURM_JOB_END_TIME", "")
    if end.isdecimal():
        left = int(end) - time.time()
        return left if left > 0.0 else None
    with suppress(OSError, ValueError, subprocess.SubprocessError):
        # The job's id is printed too, because an array's id lists all of its jobs.
        lines = subprocess.run(
            ["squeue", "--noheader", f"--jobs={job}", "--format=%A %L"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=_SQUEUE_SECONDS,
        ).stdout.splitlines()
        for number, text in (line.split() for line in lines):
            match = _SLURM_TIME.fullmatch(text)
            if number == job and match is not None:
                days, hours, minutes, rest = (int(part or 0) for part in match.groups())
                return float(((24 * days + hours) * 60 + minutes) * 60 + rest)
    return None


class Held:
    """Defers signals, for example during a write; a context manager.

    They are recorded in `pgimp.signals.received`. Only signals with their default effect are
    deferred: handlers of the calling program stay. A second SIGINT takes effect at once. Outside
    the main thread, where Python allows no handlers, nothing is deferred.

    Parameters
    ----------
    numbers : sequence of int
        The signals.

    Attributes
    ----------
    came : list of int
        Signals that arrived, complete when the context has ended.
    """

    def __init__(self, numbers: Sequence[int]) -> None:
        self.came: list[int] = []
        self._numbers = tuple(numbers)
        self._usual: dict[int, Any] = {}

    def __enter__(self) -> Held:
        """Install the handlers."""
        if threading.current_thread() is threading.main_thread():
            for number in self._numbers:
                usual = signal.getsignal(number)
                if usual in (signal.default_int_handler, signal.SIG_DFL):
                    self._usual[number] = usual
                    signals.catch(number)
        return self

    def __exit__(self, *_: object) -> None:
        """Restore the signals' usual effect."""
        for number, usual in self._usual.items():
            signal.signal(number, usual)
        self.came = [number for number in signals.received if number in self._usual]
        for number in self.came:
            signals.received.remove(number)

    def check(self) -> None:
        """Raise an error if a signal arrived.

        Raises
        ------
        KeyboardInterrupt
            If a signal arrived.
        """
        if any(number in self._usual for number in signals.received):
            raise KeyboardInterrupt


class Stop:
    """Decision to stop a run before its end; a context manager around all its output.

    In the command ``pgimp`` signals are recorded from its start. Called from Python, they are
    recorded within this context, unless the calling program has handlers of its own. That program
    gets the signals, too, when the context ends normally, after the files are closed. It gets a
    KeyboardInterrupt after SIGINT, a SystemExit after SIGTERM.

    Parameters
    ----------
    comm : communicator
        Of all ranks; rank 0 reads the clock for all.
    wall_time : float or None
        Longest time of the run, in seconds from the start of the command, or from now if called
        from Python. Inside a Slurm job the limit of the job counts as well.

    Attributes
    ----------
    reason : str
        Reason to stop: a signal's name, or the limit; empty while there is none.
    signal : int
        The signal that arrived; 0 if none.
    """

    def __init__(self, comm: Communicator, wall_time: float | None) -> None:
        self.reason = ""
        self.signal = 0
        self._comm = comm
        self._held = Held(() if signals.installed else signals.STOPPING)
        self._listens = threading.current_thread() is threading.main_thread()
        self._latest, self._limit = inf, ""
        if comm.rank == 0:
            now = time.monotonic()
            began = signals.BEGAN if signals.installed else now
            if wall_time is not None:
                self._stop_before(began + wall_time, wall_time, f"the wall time {clock(wall_time)}")
            left = slurm_seconds_left()
            if left is not None:
                self._stop_before(now + left, left, "Slurm's limit")

    def _stop_before(self, end: float, whole: float, name: str) -> None:
        margin = max(_SHORTEST_MARGIN, min(_MARGIN_PART * whole, _LONGEST_MARGIN))
        latest = end - margin
        if latest < self._latest:
            self._latest, self._limit = latest, name

    def __enter__(self) -> Stop:
        """Install the handlers that the calling program does not have."""
        self._held.__enter__()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        """Restore the handlers, and pass the signals on to the calling program.

        Raises
        ------
        KeyboardInterrupt, SystemExit
            If the context ends normally, after SIGINT and SIGTERM; never in the command.
        """
        self._held.__exit__()
        if kind is None and not signals.installed:
            came = (self.signal, *self._held.came)
            if signal.SIGINT in came:
                raise KeyboardInterrupt
            if signal.SIGTERM in came:
                raise SystemExit(_SIGNAL_STATUS + signal.SIGTERM)

    def requested(self, reserve: float) -> bool:
        """Return whether there is a reason to stop on this rank.

        Parameters
        ----------
        reserve : float
            Seconds of a checkpoint. A margin is added for the actions after it: 5 % of the whole
            time, at least a second and at most a minute.
        """
        if self.reason:
            return True
        if signals.received and self._listens:
            self.signal = signals.received[0]
            self.reason = signal.Signals(self.signal).name
        elif time.monotonic() + reserve >= self._latest:
            self.reason = self._limit
        return bool(self.reason)

    @property
    def left(self) -> float:
        """Seconds until a limit stops the run; inf without any, and on ranks but the first."""
        return self._latest - time.monotonic()

    def agree(self, reserve: float) -> bool:
        """Return whether there is a reason to stop on any rank, and share it; collective.

        Parameters
        ----------
        reserve : float
            As for `requested`.
        """
        self.requested(reserve)
        for reason, number in self._comm.allgather((self.reason, self.signal)):
            if reason:
                self.reason, self.signal = reason, number
                return True
        return False

    def __str__(self) -> str:
        """The reason in words: ``on SIGUSR1``, ``before the wall time 2:00:00``."""
        return f"{'on' if self.signal else 'before'} {self.reason}"
