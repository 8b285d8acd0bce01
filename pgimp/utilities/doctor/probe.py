"""Scripts in separate processes that answer with a JSON object."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

_SECONDS = 120
_LINES_OF_ERROR = 5
_LAUNCHER_VARIABLES = ("OMPI_", "PMIX_", "PMI_", "PALS_", "MPI_LOCAL", "SLURM_STEP")
#: Settings of the user, in contrast to mpirun's settings for its ranks.
_SETTINGS = ("OMPI_MCA_", "OMPI_ALLOW_", "PMIX_MCA_")

#: Beginning of scripts: imports do not initialise MPI; list of the loaded MPI libraries.
PREAMBLE = """
import json, os, re, sys
import mpi4py
mpi4py.rc(initialize=False, finalize=False)
def mpi_libraries():
    maps = open("/proc/self/maps").read() if os.path.exists("/proc/self/maps") else ""
    return sorted(set(re.findall(r"/\\S*/libmpi(?:ch|_cray)?\\.so\\S*", maps)))
"""

Answer = dict[str, Any] | str


def environment() -> dict[str, str]:
    """Return the environment of a probe: without a rank's variables, mpirun allowed for root."""
    env = {
        key: value
        for key, value in os.environ.items()
        if key.startswith(_SETTINGS) or not key.startswith(_LAUNCHER_VARIABLES)
    }
    if hasattr(os, "getuid") and os.getuid() == 0:
        env |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return env


def run(words: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run a program.

    Raises
    ------
    OSError
        If it cannot be started.
    subprocess.TimeoutExpired
        If it takes longer than two minutes.
    """
    return subprocess.run(
        list(words),
        env=environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=_SECONDS,
    )


def ask(script: str, *argv: str, launch: Sequence[str] = ()) -> Answer:
    """Run a script.

    Parameters
    ----------
    script : str
        Python that prints a JSON object on one line.
    *argv : str
        Its arguments.
    launch : sequence of str
        The launcher with its options, if any.

    Returns
    -------
    dict or str
        The object, the last one if there are several; or the reason for none, as text.
    """
    answers = ask_all(script, *argv, launch=launch)
    return answers if isinstance(answers, str) else answers[-1]


def ask_all(script: str, *argv: str, launch: Sequence[str] = ()) -> list[dict[str, Any]] | str:
    """As `ask`, for scripts that print an object on every rank: returns all, at least one."""
    try:
        done = run([*launch, sys.executable, "-c", script, *argv])
    except subprocess.TimeoutExpired:
        return f"does not come back (waited {_SECONDS} s)"
    except OSError as error:
        return str(error)
    answers = _objects(done.stdout)
    if done.returncode == 0 and answers:
        return answers
    # The message of an exception follows the indented lines of its traceback.
    said: list[str] = []
    for line in done.stderr.splitlines():
        said = [] if line.startswith(" ") else [*said, line.strip("- ")]
    words = " ".join(" ".join(said[-_LINES_OF_ERROR:]).split())
    if done.returncode < 0:
        return f"crashes (signal {-done.returncode}) {words}".rstrip()
    return words or f"fails with status {done.returncode}"


def _objects(text: str) -> list[dict[str, object]]:
    """Return the objects at the beginning of lines, and objects after them on the same line.

    Without a buffer Python writes the end of a line separately: another rank's line may come
    before it.
    """
    decoder, found = json.JSONDecoder(), []
    for line in text.splitlines():
        while line.startswith("{"):
            answer, end = decoder.raw_decode(line)
            found.append(answer)
            line = line[end:]
    return found


def names(files: Sequence[str]) -> str:
    """Return paths in brackets; empty if there are none."""
    return f"({', '.join(files)})" if files else ""
