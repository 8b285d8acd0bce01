"""Checks of the machine: cores, shared memory, limits; Python and its packages' origin."""

from __future__ import annotations

import os
import platform
import resource
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from pgimp.io.rundir.runinfo import cpu
from pgimp.mpi.node import cores
from pgimp.utilities.doctor.finding import Finding

#: Least shared memory of Open MPI and similar libraries for each rank.
_SHARED_BYTES_PER_RANK = 16 << 20
#: A socket's path has at most 107 letters, and MPI libraries add some 50 to the folder's path.
_LONGEST_TEMPORARY = 56
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def examine() -> Iterator[Finding]:
    """Check the machine and Python."""
    count = len(cores())
    yield Finding("machine", f"{cpu()}, {count} core{'' if count == 1 else 's'} for this process")
    yield python()
    yield from shared_memory(count)
    yield from temporary_folder()
    yield from threads(count, os.environ)


def python() -> Finding:
    """Report the Python version, and packages that hide installed ones."""
    found = f"{platform.python_version()}, {sys.executable}"
    own = Path(sys.prefix).resolve()
    for folder in filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep)):
        path = Path(folder).resolve()
        hiding = [name for name in ("mpi4py", "h5py", "numpy", "numba") if (path / name).is_dir()]
        if hiding and not path.is_relative_to(own):
            return Finding(
                "Python",
                f"{found}; PYTHONPATH has another {', '.join(hiding)} in {folder}",
                "unset PYTHONPATH, or unload the module that sets it: what is in there comes "
                "before the packages that were installed with pgimp",
            )
    return Finding("Python", found)


def shared_memory(ranks: int, folder: str = "/dev/shm") -> Iterator[Finding]:
    """Report too little shared memory for as many ranks as cores."""
    try:
        free = shutil.disk_usage(folder).free
    except OSError:
        return
    if free < ranks * _SHARED_BYTES_PER_RANK:
        yield Finding(
            "shared memory",
            f"{free >> 20} MB are free in {folder}, little for the messages of {ranks} ranks",
            "remove what other programs have left there, or give the container more (docker run "
            "--shm-size=1g); with Open MPI 4, OMPI_MCA_btl_vader_backing_directory=/tmp does "
            "without it",
        )


def temporary_folder() -> Iterator[Finding]:
    """Report a folder for temporary files that MPI libraries cannot use."""
    folder = tempfile.gettempdir()
    if len(folder) > _LONGEST_TEMPORARY:
        yield Finding(
            "temporary",
            f"the path {folder} is longer than MPI libraries can take for their sockets",
            "set TMPDIR to a short path, such as /tmp, before mpirun",
        )
    try:
        free = shutil.disk_usage(folder).free
    except OSError:
        return
    if free < _SHARED_BYTES_PER_RANK:
        yield Finding(
            "temporary",
            f"{free >> 20} MB are free in {folder}, too little for mpirun's files",
            "remove what is not needed there, or set TMPDIR to another folder of this node",
        )


def threads(count: int, environ: Mapping[str, str]) -> Iterator[Finding]:
    """Report a limit of threads too low for a rank on each core."""
    most = resource.getrlimit(resource.RLIMIT_NPROC)[0]
    if any(environ.get(name) for name in _THREADS) or most == resource.RLIM_INFINITY:
        return
    if count * count > most:
        yield Finding(
            "threads",
            f"NumPy starts {count} threads for each of {count} ranks, and the limit is {most} "
            "(ulimit -u)",
            "export OMP_NUM_THREADS=1 where pgimp is started: it needs one thread a rank",
        )
