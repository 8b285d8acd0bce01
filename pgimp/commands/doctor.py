"""``pgimp doctor``: are MPI, HDF5, h5py and Numba there, do they fit each other, what to do if not.

Every library is tried in a process of its own: a library that crashes is then a finding, and the
doctor itself never initialises MPI.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

_PROBE_SECONDS = 120
_LINES_OF_ERROR = 5
_LAUNCHER_VARIABLES = ("OMPI_", "PMIX_", "PMI_", "PALS_", "MPI_LOCAL", "SLURM_STEP")

_GET_MPI = (
    "for several ranks install MPI (on Debian: apt-get install openmpi-bin) or load its module"
)

_PREAMBLE = """
import json, os, re, sys
import mpi4py
mpi4py.rc(initialize=False, finalize=False)
def mpi_libraries():
    maps = open("/proc/self/maps").read() if os.path.exists("/proc/self/maps") else ""
    return sorted(set(re.findall(r"/\\S*/libmpi(?:ch|_cray)?\\.so\\S*", maps)))
"""

_MPI_PROBE = f"""{_PREAMBLE}
from mpi4py import MPI
print(json.dumps({{
    "version": mpi4py.__version__,
    "library": MPI.Get_library_version().strip("\\0 \\n").splitlines()[0].split(",")[0],
    "files": mpi_libraries(),
}}))
"""

_H5PY_PROBE = f"""{_PREAMBLE}
import h5py, numpy
with h5py.File(sys.argv[1], "w") as file:
    file["x"] = numpy.arange(10.0)
with h5py.File(sys.argv[1]) as file:
    assert file["x"][9] == 9.0
print(json.dumps({{
    "version": h5py.version.version,
    "hdf5": h5py.version.hdf5_version,
    "mpi": bool(h5py.get_config().mpi),
    "files": mpi_libraries(),
}}))
"""

_NUMBA_PROBE = """
import json
from pgimp.kernels import jit
import llvmlite.binding, numba
assert numba.njit(lambda x: x + 1)(1) == 2
print(json.dumps({
    "version": numba.__version__,
    "cpu": llvmlite.binding.get_host_cpu_name(),
    "folder": str(jit.cache_folder()),
}))
"""

_RANKS_PROBE = """
import json, sys
from mpi4py import MPI
import numpy
comm = MPI.COMM_WORLD
there, other = numpy.full(1 << 17, comm.rank, float), numpy.empty(1 << 17)
if comm.size == 2:
    comm.Sendrecv(there, 1 - comm.rank, recvbuf=other, source=1 - comm.rank)
    assert (other == 1 - comm.rank).all(), "a message of 1 MiB came through damaged"
ranks = comm.allreduce(1)
parallel = False
if ranks == 2:
    import h5py
    parallel = bool(h5py.get_config().mpi)
    if parallel:
        with h5py.File(sys.argv[1], "w", driver="mpio", comm=comm) as file:
            data = file.create_dataset("x", (2,))
            with data.collective:
                data[comm.rank] = comm.rank
if comm.rank == 0:
    print(json.dumps({"ranks": ranks, "parallel": parallel}))
"""


class Finding(NamedTuple):
    """One line of the report.

    Attributes
    ----------
    part : str
        What was looked at.
    found : str
        What is there.
    cure : str
        What to do; empty if all is well.
    broken : bool
        Whether it has to be done before pgimp works as installed.
    """

    part: str
    found: str
    cure: str = ""
    broken: bool = False


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add nothing: the command has no options."""


def execute(args: argparse.Namespace) -> int:
    """Print the report.

    Returns
    -------
    int
        0 if what is installed works, 1 if something is broken.
    """
    findings: list[Finding] = []

    def report(finding: Finding) -> None:
        mark = "WRONG" if finding.broken else "note" if finding.cure else "ok"
        print(f"{mark:<6} {finding.part:<12} {finding.found}", flush=True)
        findings.append(finding)

    report(Finding("machine", _machine()))
    report(Finding("Python", f"{platform.python_version()}, {sys.executable}"))
    report(_numba())
    mpi = _try(_MPI_PROBE)
    with tempfile.TemporaryDirectory() as folder:
        h5py = _try(_H5PY_PROBE, os.path.join(folder, "serial.h5"))
        report(_mpi4py(mpi))
        report(_h5py(h5py, mpi))
        report(_mpirun())
        if shutil.which("mpirun") and isinstance(mpi, dict):
            report(_two_ranks(mpi, os.path.join(folder, "parallel.h5")))
    wrong = [finding for finding in findings if finding.broken]
    for title, some in (
        ("What to do:", wrong),
        ("What could be better:", [f for f in findings if f.cure and not f.broken]),
    ):
        if some:
            print(f"\n{title}")
            for finding in some:
                print(f"  {finding.part}: {finding.cure}")
    if not wrong:
        print("\npgimp works here.")
    return 1 if wrong else 0


def _machine() -> str:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    name = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                name = line.partition(":")[2].strip()
                break
    except OSError:
        pass
    return f"{name}, {cores} core{'' if cores == 1 else 's'} for this process"


def _numba() -> Finding:
    tried = _try(_NUMBA_PROBE)
    if isinstance(tried, str):
        return Finding("Numba", tried, "run scripts/setup again, or: pip install numba", True)
    found = f"{tried['version']} for {tried['cpu']}, kernels kept in {tried['folder']}"
    if Path(tried["folder"]).is_relative_to(tempfile.gettempdir()) and not os.environ.get(
        "PGIMP_CACHE_DIR"
    ):
        return Finding(
            "Numba",
            found,
            "the kernel cache of your home folder cannot be written, so kernels are compiled anew "
            "on every fresh machine; set PGIMP_CACHE_DIR to a folder that can",
        )
    return Finding("Numba", found)


def _mpi4py(mpi: dict[str, Any] | str) -> Finding:
    if isinstance(mpi, dict):
        return Finding("mpi4py", f"{mpi['version']} with {mpi['library']} {_names(mpi['files'])}")
    if "cannot load MPI library" in mpi and not shutil.which("mpirun"):
        return Finding("mpi4py", "finds no MPI library: one rank only", _GET_MPI)
    return Finding(
        "mpi4py",
        mpi,
        "install the MPI library that mpirun belongs to, load its module, or name it: "
        "MPI4PY_LIBMPI=/path/to/libmpi.so",
        broken=bool(shutil.which("mpirun")) or "cannot load MPI library" not in mpi,
    )


def _h5py(h5py: dict[str, Any] | str, mpi: dict[str, Any] | str) -> Finding:
    rebuild = "remove .venv and run scripts/setup, which builds h5py with the mpicc it finds"
    if isinstance(h5py, str):
        return Finding("h5py", h5py, f"{rebuild}; or: pip install --force-reinstall h5py", True)
    kind = "with MPI" if h5py["mpi"] else "without MPI"
    found = f"{h5py['version']} {kind}, HDF5 {h5py['hdf5']}"
    if len(h5py["files"]) > 1:
        both = _names(h5py["files"])
        return Finding("h5py", f"{found}, brings in a second MPI library {both}", rebuild, True)
    if not h5py["mpi"] and isinstance(mpi, dict):
        return Finding(
            "h5py",
            found,
            "pgimp does without: all ranks write to its files. What else needs parallel HDF5 gets "
            "it from scripts/setup, which builds h5py with MPI",
        )
    return Finding("h5py", found)


def _mpirun() -> Finding:
    mpirun = shutil.which("mpirun")
    if mpirun is None:
        return Finding("mpirun", "not found: one rank only", _GET_MPI)
    try:
        said = _run([mpirun, "--version"]).stdout.strip().splitlines()
    except (OSError, subprocess.SubprocessError) as error:
        return Finding("mpirun", f"{mpirun}: {error}", "install MPI again", broken=True)
    words = " ".join(said[: 1 if "(" in said[0] else 2]).split() if said else ["unknown version"]
    return Finding("mpirun", f"{' '.join(words)}, {mpirun}")


def _two_ranks(mpi: dict[str, Any], path: str) -> Finding:
    for options in (["-q", "--oversubscribe", "--bind-to", "none"], []):  # Open MPI's; any other's
        tried = _try(_RANKS_PROBE, path, launch=["mpirun", *options, "-n", "2"])
        if isinstance(tried, dict):
            break
    cure = f"start pgimp with the mpirun that belongs to {mpi['library']}, or name mpirun's own "
    cure += "library: MPI4PY_LIBMPI=/path/to/libmpi.so"
    if isinstance(tried, str):
        return Finding("two ranks", tried, cure, broken=True)
    if tried["ranks"] != 2:
        return Finding(
            "two ranks",
            f"mpirun and mpi4py's {mpi['library']} do not belong together: each process is alone",
            cure,
            broken=True,
        )
    return Finding(
        "two ranks",
        "exchange messages" + (" and write one HDF5 file together" if tried["parallel"] else ""),
    )


def _names(files: list[str]) -> str:
    return f"({', '.join(files)})" if files else ""


def _environment() -> dict[str, str]:
    """Environment of a probe: not that of a rank, and with mpirun's leave to be used by root."""
    env = {k: v for k, v in os.environ.items() if not k.startswith(_LAUNCHER_VARIABLES)}
    if hasattr(os, "getuid") and os.getuid() == 0:
        env |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return env


def _run(words: list[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        words,
        env=_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=_PROBE_SECONDS,
    )


def _try(script: str, *argv: str, launch: list[str] | None = None) -> dict[str, Any] | str:
    """Run a script that prints a JSON object; return that, or in words why there is none."""
    try:
        done = _run([*(launch or []), sys.executable, "-c", script, *argv])
    except subprocess.TimeoutExpired:
        return f"does not come back (waited {_PROBE_SECONDS} s)"
    except OSError as error:
        return str(error)
    for line in reversed(done.stdout.splitlines()):
        if done.returncode == 0 and line.startswith("{"):
            return json.loads(line)
    # The message of an exception is what follows the indented lines of its traceback.
    said: list[str] = []
    for line in done.stderr.splitlines():
        said = [] if line.startswith(" ") else [*said, line.strip("- ")]
    words = " ".join(" ".join(said[-_LINES_OF_ERROR:]).split())
    if done.returncode < 0:
        return f"crashes (signal {-done.returncode}) {words}".rstrip()
    return words or f"fails with status {done.returncode}"
