"""pgimp's command line in forked children: what it needs is imported once; each is limited."""

import importlib
import os
import re
import resource
import signal
import sys
import time
from pathlib import Path
from typing import NamedTuple

import pgimp.cli
from pgimp.mpi.comm import quiet_mpi

#: Where programs find these modules.
SCRIPTS = Path(__file__).resolve().parents[1]
#: Seconds after which a run is considered hung.
PATIENCE = 90.0
#: Memory that a child may take besides what it begins with; what asks for more gets an error.
ROOM = 1_500_000_000
#: Steps after which a run that would go on is done.
STEPS = 3


class Result(NamedTuple):
    """What became of a command: status, what it wrote to stderr, time, and its greatest memory.

    The status is negative for a signal, None if it hung.
    """

    status: int | None
    said: str
    seconds: float
    megabytes: float


def prepare():
    """Import all that a run needs, without MPI, into a process whose children run pgimp."""
    quiet_mpi()
    for name in ("run", "check", "study"):
        importlib.import_module(f"pgimp.commands.{name}")
    for name in ("running", "resume", "frames", "checkpoints"):
        importlib.import_module(f"pgimp.running.{name}")
    importlib.import_module("pgimp.storage.hdf5")
    importlib.import_module("h5py")
    shorten()


def shorten():
    """Let no run take more than a few steps."""
    simulation = importlib.import_module("pgimp.solver.simulation")
    simulation.Simulation.finished = property(
        lambda self: self.clock.finished(self.now) or self.step >= STEPS
    )


def size():
    """Addresses of this process, bytes."""
    with open("/proc/self/statm") as stream:
        return int(stream.read().split()[0]) * resource.getpagesize()


def run(words, folder, before=None):
    """Run ``pgimp WORDS`` in a child, in `folder`; `before` is called in the child first."""
    said = folder / "stderr"
    began = time.monotonic()
    child = os.fork()
    if child == 0:
        status = 70
        try:
            signal.alarm(0)
            os.setsid()
            os.chdir(folder)
            for name, number in (("stdout", 1), ("stderr", 2)):
                descriptor = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
                os.dup2(descriptor, number)
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            limit = size() + ROOM
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if before:
                before()
            status = pgimp.cli.main(words)
        except SystemExit as stop:
            status = stop.code if isinstance(stop.code, int) else 71
        except BaseException as error:  # main let it through
            os.write(2, f"Traceback: {error!r}".encode(errors="replace"))
        finally:
            for stream in (sys.stdout, sys.stderr):
                try:
                    stream.flush()
                except (OSError, ValueError):
                    status = 72
            os._exit(status)
    while True:
        pid, code, usage = os.wait4(child, os.WNOHANG)
        if pid or time.monotonic() - began > PATIENCE:
            break
        time.sleep(0.002)
    if not pid:
        os.kill(child, signal.SIGKILL)
        _, _, usage = os.wait4(child, 0)
    seconds = time.monotonic() - began
    status = os.waitstatus_to_exitcode(code) if pid else None
    text = said.read_text(encoding="utf-8", errors="replace") if said.exists() else ""
    return Result(status, text, seconds, usage.ru_maxrss / 1e3)


_WRONG = re.compile(
    r"Traceback|unexpected [A-Z]\w+|out of memory|Segmentation|Fatal Python|Warning:"
)


def complaint(result, statuses, lines=12):
    """What is wrong with how pgimp refused something; nothing if it did as it should."""
    if result.status is None:
        return f"hung for {PATIENCE:.0f} s"
    if found := _WRONG.search(result.said):
        return f"status {result.status}, {found[0]}: {result.said[-500:]}"
    if result.status == 0:
        return ""
    if result.status not in statuses:
        return f"status {result.status}: {result.said[-300:]}"
    said = result.said.split("\n")
    if not result.said.startswith("pgimp: "):
        return f"not pgimp's own words: {result.said[:300]}"
    if len(said) > lines + 1 or max(map(len, said)) > 1000:
        return f"{len(said)} lines of up to {max(map(len, said))} characters: {result.said[:300]}"
    if any((c < " " and c != "\n") or c == "\x7f" for c in result.said):
        return f"control characters: {result.said[:300]!r}"
    return ""
