"""Other processes in tests: their environment, and one that hangs fails the test."""

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

#: Where the programs are that tests start.
PROGRAMS = Path(__file__).parents[1] / "programs"
#: For a file of tests that is started as a program.
HERE = {
    "PYTHONPATH": os.pathsep.join(
        [str(PROGRAMS.parents[2]), *(str(path) for path in sorted(PROGRAMS.parent.iterdir()))]
    )
}

LAUNCHER_VARIABLES = ("OMPI_", "PMIX_", "PMI_", "PALS_", "MPI_LOCAL", "SLURM_")


def interruptible() -> None:
    """Let Ctrl-C have its default effect, also on processes that are started later.

    Shells without job control, as in job scripts, ignore it for what they start with ``&``.
    """
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def clean_env(more: Mapping[str, str] | None = None) -> dict[str, str]:
    """Environment of a process that no launcher started, in which root may use mpirun.

    A process that has initialised MPI has its launcher's variables, which its children must not
    inherit. Ranks that wait leave the cores to other tests: two would not otherwise on two cores.
    """
    env = {k: v for k, v in os.environ.items() if not k.startswith(LAUNCHER_VARIABLES)}
    env |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    env |= {"OMPI_MCA_mpi_yield_when_idle": "1"}
    return env | dict(more or {})


def run(
    words: Sequence[str],
    timeout: float = 120.0,
    cwd: str | Path | None = None,
    env: Mapping[str, str] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run a program with all it starts, and fail the test, with what it said, if it hangs."""
    process = subprocess.Popen(
        list(words),
        cwd=cwd,
        env=clean_env(env),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        process.terminate()  # mpirun then ends its ranks, which have sessions of their own
        try:
            out, err = process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            out, err = process.communicate()
        pytest.fail(f"no end within {timeout} s: {' '.join(words)}\n{out[-4000:]}\n{err[-4000:]}")
    return subprocess.CompletedProcess(list(words), process.returncode, out, err)
