"""Kernels of cases compiled before they are run: ``python -m pgimp.running.compile_ahead CASE ..``.

As many processes as there are cores take the cases in turn, up to the first step. A run of one of
them then begins at once, on any number of ranks. What is stopped leaves whole files in the cache,
as kernels get their names when they are written.
"""

import os
import signal
import sys
import time
from collections.abc import Sequence
from multiprocessing import get_context

from pgimp.case.load import load
from pgimp.errors import PgimpError
from pgimp.jit.compiled.cache import messages
from pgimp.mpi.comm import Serial
from pgimp.mpi.node import cores
from pgimp.solver.simulation import Simulation


def compile_case(path: str) -> str:
    """Compile all kernels of a case that are not in the cache.

    Returns
    -------
    str
        Why that was not possible, or why they could not be kept; empty if all is well.
    """
    try:
        Simulation(load(path), Serial())
    except PgimpError as error:
        return str(error)
    return "\n".join(messages())


def compile_cases(paths: Sequence[str], processes: int) -> dict[str, str]:
    """Compile the kernels of several cases; return what went wrong, by the case's path."""
    # Each has imported what it needs. All end with this process, at once where it is interrupted.
    with get_context("fork").Pool(processes, _begin) as pool:
        found = dict(zip(paths, pool.imap(compile_case, paths), strict=True))
    return {path: why for path, why in found.items() if why}


def _begin() -> None:
    """Leave Ctrl-C to the first process, and the cores to what is more urgent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.nice(10)


def main(words: Sequence[str]) -> int:
    """Compile the kernels of the cases named; exit status."""
    if not words or any(word.startswith("-") for word in words):
        print(__doc__)
        return 0 if {*words} & {"-h", "--help"} else 2
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that all end with this process
    began = time.monotonic()
    wrong = compile_cases(words, min(len(cores()), len(words)))
    for path, why in wrong.items():
        print(f"{path}: {why}", file=sys.stderr)
    done, spent = len(words) - len(wrong), time.monotonic() - began
    print(f"{done} of {len(words)} cases have all their kernels, after {spent:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit("interrupted; kernels that were compiled are kept")
