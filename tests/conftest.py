"""Helpers for every test: processes on several ranks or on one, in an environment of their own."""

import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import pytest

LAUNCHER_VARIABLES = ("OMPI_", "PMIX_", "PMI_", "PALS_", "MPI_LOCAL", "SLURM_")


class Launch(Protocol):
    """What the fixture `mpirun` returns."""

    def __call__(
        self,
        n: int,
        args: Sequence[str],
        timeout: float = 120.0,
        cwd: str | Path | None = None,
        env: Mapping[str, str] | None = None,
    ) -> subprocess.CompletedProcess[str]: ...


def clean_env(more: Mapping[str, str] | None = None) -> dict[str, str]:
    """Environment of a process that no launcher started, in which root may use mpirun.

    A process that has initialised MPI has its launcher's variables, which its children must not
    inherit.
    """
    env = {k: v for k, v in os.environ.items() if not k.startswith(LAUNCHER_VARIABLES)}
    env |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
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


@pytest.fixture(scope="session")
def mpirun() -> Launch:
    """``mpirun(n, args)`` runs ``python ARGS...`` on n ranks, say ``["-m", "pgimp", case]``.

    The result has `returncode`, `stdout` and `stderr`; mpirun's own remarks are left out.
    """

    def launch(n, args, timeout=120.0, cwd=None, env=None):
        options = ["-q", "--oversubscribe", "--bind-to", "none", "-n", str(n)]
        return run(["mpirun", *options, sys.executable, *map(str, args)], timeout, cwd, env)

    return launch


@pytest.fixture(scope="session")
def python():
    """``python(args)`` runs ``python ARGS...`` as one process without a launcher, like `mpirun`."""

    def launch(args, timeout=120.0, cwd=None, env=None):
        return run([sys.executable, *map(str, args)], timeout, cwd, env)

    return launch
