"""Checks of mpi4py and the launchers: MPI library, mpirun, and a run with two ranks."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path

from pgimp.utilities.doctor.finding import Finding
from pgimp.utilities.doctor.probe import PREAMBLE, Answer, ask, ask_all, names, run

PROBE = f"""{PREAMBLE}
from mpi4py import MPI
library = MPI.Get_library_version().strip("\\0 \\n").splitlines()[0].split(",")[0]
print(json.dumps({{
    "version": mpi4py.__version__,
    "library": " ".join(library.split()),
    "files": mpi_libraries(),
    "chooses": not os.path.basename(MPI.__file__).startswith("MPI.cpython"),
}}))
"""

_RANKS_PROBE = """
import json
from mpi4py import MPI
import numpy
comm = MPI.COMM_WORLD
there, other = numpy.full(1 << 17, comm.rank, float), numpy.empty(1 << 17)
if comm.size == 2:
    comm.Sendrecv(there, 1 - comm.rank, recvbuf=other, source=1 - comm.rank)
    assert (other == 1 - comm.rank).all(), "a message of 1 MiB came through damaged"
ranks = comm.allreduce(1)
if comm.rank == 0:
    print(json.dumps({"ranks": ranks}))
"""

_NODES_PROBE = """
import json, socket, llvmlite.binding as llvm
cpu = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
print(json.dumps({"host": socket.gethostname(), "cpu": cpu}))
"""

_GET_MPI = (
    "for several ranks install MPI (on Debian: apt-get install openmpi-bin) or load its module"
)

#: Options of Open MPI's mpirun; options of any other.
_MPIRUN = (("-q", "--oversubscribe", "--bind-to", "none"), ())
#: Options of srun: sharing the resources of salloc's shell; ways to reach the library.
_SRUN = (
    ("--overlap",),
    ("--overlap", "--mpi=pmix"),
    ("--overlap", "--mpi=pmi2"),
    (),
    ("--mpi=pmix",),
    ("--mpi=pmi2",),
)


def examine() -> tuple[Answer, list[Finding]]:
    """Check mpi4py.

    Returns
    -------
    dict or str
        The answer of `PROBE`.
    list of Finding
        Findings from the answer.
    """
    mpi = ask(PROBE)
    return mpi, [_mpi4py(mpi)]


def _mpi4py(mpi: Answer) -> Finding:
    if isinstance(mpi, dict):
        return Finding("mpi4py", f"{mpi['version']} with {mpi['library']} {names(mpi['files'])}")
    if "cannot load MPI library" in mpi and not _launcher():
        return Finding("mpi4py", "finds no MPI library: one rank only", _GET_MPI)
    return Finding(
        "mpi4py",
        mpi,
        "load the module, or install the MPI library, that the launcher belongs to, or name it: "
        "MPI4PY_LIBMPI=/path/to/libmpi.so",
        broken=bool(_launcher()) or "cannot load MPI library" not in mpi,
    )


def _launcher() -> str | None:
    """Return the path of mpirun, or of mpiexec if there is no mpirun."""
    return shutil.which("mpirun") or shutil.which("mpiexec")


def launchers(mpi: Answer) -> Iterator[Finding]:
    """Check mpirun and srun, and try two ranks with each.

    Parameters
    ----------
    mpi : dict or str
        The answer of `PROBE`.
    """
    mpirun, srun = _launcher(), shutil.which("srun")
    if mpirun:
        yield _version(mpirun)
        if isinstance(mpi, dict):
            yield _two_ranks(mpi, mpirun, _MPIRUN)
    elif not srun:
        yield Finding("mpirun", "not found: one rank only", _GET_MPI)
    if srun and os.environ.get("SLURM_JOB_ID"):
        if isinstance(mpi, dict) and int(os.environ.get("SLURM_NTASKS") or 1) > 1:
            yield _two_ranks(mpi, srun, _SRUN)
        else:
            yield Finding("srun", f"{srun}; this job has one task: salloc -n 2 pgimp doctor")
        yield from nodes([srun, "--overlap", "--ntasks-per-node=1"], "SLURM_JOB_NUM_NODES")
    elif srun:
        yield Finding("srun", f"{srun}; to try it, in a job: salloc -n 2 pgimp doctor")


def _version(mpirun: str) -> Finding:
    name = os.path.basename(mpirun)
    try:
        said = run([mpirun, "--version"]).stdout.strip().splitlines()
    except (OSError, subprocess.SubprocessError) as error:
        return Finding(name, f"{mpirun}: {error}", "install MPI again", broken=True)
    words = " ".join(said[: 1 if "(" in said[0] else 2]).split() if said else ["unknown version"]
    return Finding(name, f"{' '.join(words)}, {mpirun}")


def _two_ranks(mpi: dict[str, object], launcher: str, ways: Sequence[Sequence[str]]) -> Finding:
    """Start two ranks, with each set of options until they can communicate."""
    name = os.path.basename(launcher)
    part = "two ranks" if name != "srun" else "srun"
    answers: list[Answer] = []
    for options in ways:
        # By its name, as users start it: Open MPI's refuses to run as /bin/mpirun, because it
        # uses the part before /bin as its prefix.
        tried = ask(_RANKS_PROBE, launch=[name, *options, "-n", "2"])
        answers.append(tried)
        if isinstance(tried, dict) and tried["ranks"] == 2:
            found = "exchange messages"
            mode = " ".join(word for word in options if word.startswith("--mpi"))
            if mode and any(isinstance(answer, dict) for answer in answers[:-1]):
                return Finding(
                    part,
                    f"two ranks {found} with {mode}, without each is alone",
                    f"start pgimp with: srun {mode}; in batch scripts: pgimp batch CASE.yaml "
                    f"--launcher 'srun {mode}'",
                )
            return Finding(part, found if part != name else f"two ranks {found}")
    alone = any(isinstance(answer, dict) for answer in answers)
    return Finding(
        part,
        f"{name} and mpi4py's {mpi['library']} do not belong together: each process is alone"
        if alone
        else str(answers[0]),
        cure(mpi, launcher),
        broken=part != "srun",
    )


def cure(mpi: dict[str, object], launcher: str) -> str:
    """Return the remedy for a launcher that does not fit mpi4py's library.

    Parameters
    ----------
    mpi : dict
        The answer of `PROBE`.
    launcher : str
        Path of mpirun or srun.
    """
    words = f"start pgimp with the mpirun that belongs to {mpi['library']}"
    if os.path.basename(launcher) == "srun":
        words += f", not with srun (pgimp batch does), or with what `{launcher} --mpi=list` lists"
    elif mpi["chooses"]:
        own = library_of(launcher) or "/path/to/libmpi.so"
        words += f", or name the library of this one: export MPI4PY_LIBMPI={own}"
    return (
        words + "; or remove .venv and run scripts/setup, which builds mpi4py with the mpicc it"
        " finds, where its wheel does not fit mpirun"
    )


def library_of(launcher: str) -> str | None:
    """Return the MPI library beside a launcher, if one is found."""
    prefix = Path(launcher).resolve().parent.parent
    for name in ("libmpi.so", "libmpi.so.*"):
        for folder in ("lib", "lib64", "lib/release", "lib/*-linux-gnu"):
            for path in sorted(prefix.glob(f"{folder}/{name}")):
                return str(path)
    return None


def nodes(launch: Sequence[str], count: str) -> Iterator[Finding]:
    """Report nodes of this job with different CPUs.

    Parameters
    ----------
    launch : sequence of str
        The launcher that starts a process on each node.
    count : str
        Environment variable with the number of nodes.
    """
    number = int(os.environ.get(count) or 1)
    if number == 1:
        return
    answers = ask_all(_NODES_PROBE, launch=[*launch, "-N", str(number), "-n", str(number)])
    if isinstance(answers, str):
        yield Finding("nodes", answers, "see what this says: a run would meet it too")
        return
    types: dict[tuple[str, ...], list[str]] = {}
    for answer in answers:
        types.setdefault(tuple(answer["cpu"]), []).append(answer["host"])
    found = "; ".join(f"{cpu[0]}: {', '.join(hosts)}" for cpu, hosts in sorted(types.items()))
    if len(types) == 1:
        yield Finding("nodes", found)
    else:
        yield Finding(
            "nodes",
            f"CPUs of {len(types)} types, {found}",
            "results are the same bit for bit on nodes of one type only, and the slowest sets the "
            "pace; ask for one, as in: pgimp batch CASE.yaml --extra=--constraint=TYPE",
        )
