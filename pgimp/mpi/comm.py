"""The communicator of a run: MPI's under a launcher, a stand-in for one rank elsewhere."""

from __future__ import annotations

import os
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, TypeVar, cast

from pgimp.errors import CaseError, PgimpError, UsageError
from pgimp.mpi.communicator import Communicator
from pgimp.terminal import escape

T = TypeVar("T")

_FAILURE_TAG = 77
# Ranks that fail in one step do so within this time; the lowest of them reports for all.
_SAME_FAILURE_SECONDS = 0.3
# Time for which a rank with a wrong case waits for the others' verdict before it ends them.
_AGREEMENT_SECONDS = 20.0
# Slurm numbers the batch script's and the interactive shell's own steps from here: no launcher.
_FIRST_SPECIAL_SLURM_STEP = 0xFFFFFFF0


class SharedUsageError(UsageError):
    """An error that every rank finds by itself, so that one report is enough."""


class Launcher(NamedTuple):
    """The program that started this process as one rank of many, by the environment."""

    name: str  #: The name of the launcher, for messages.
    size: int | None  #: Number of ranks it started; None if unknown.
    rank: int  #: Number of this process among them.
    variable: str = ""  #: Where the environment has that number.


def launcher(environ: Mapping[str, str] | None = None) -> Launcher | None:
    """Detect from the environment whether an MPI launcher started this process.

    Parameters
    ----------
    environ : mapping, optional
        The environment to look at; the process's own by default.

    Returns
    -------
    Launcher or None
        None without a launcher, also inside a Slurm batch script outside of ``srun``.
    """
    env = os.environ if environ is None else environ

    def number(key: str) -> int | None:
        value = env.get(key, "")
        return int(value) if value.isdecimal() else None

    pmi = "the mpiexec of MPICH or its kin"
    if any(key.startswith("I_MPI_HYDRA") for key in env) or "I_MPI_MPIRUN" in env:
        pmi = "Intel MPI's mpirun"
    elif "PALS_RANKID" in env or "PALS_APID" in env:
        pmi = "PALS (Cray mpiexec)"
    elif "SLURM_STEP_ID" in env and "MPI_LOCALNRANKS" not in env:
        pmi = "Slurm's srun"
    for name, size_key, rank_key in (
        ("Open MPI's mpirun", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
        ("MVAPICH's mpirun", "MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"),
        (pmi, "PMI_SIZE", "PMI_RANK"),
    ):
        size = number(size_key)
        if size is not None:
            return Launcher(name, size, number(rank_key) or 0, rank_key)

    step, rank = number("SLURM_STEP_ID"), number("SLURM_PROCID")
    if step is None and rank is not None:
        # A batch script is number 0, and has the number of its job.
        task = rank > 0 or "SLURM_JOB_ID" not in env
    else:
        task = step is not None and step < _FIRST_SPECIAL_SLURM_STEP
    if task and rank is not None:
        size = number("SLURM_STEP_NUM_TASKS")
        size = number("SLURM_NTASKS") if size is None else size
        return Launcher("Slurm's srun", size, rank, "SLURM_PROCID")
    for name, rank_key in (
        (pmi, "PALS_RANKID"),
        (pmi, "PMI_RANK"),
        (pmi, "MPI_LOCALRANKID"),
        ("a PMIx launcher", "PMIX_RANK"),
    ):
        rank = number(rank_key)
        if rank is not None:
            # On this node, so that one does not mean that there are no others.
            size = number("MPI_LOCALNRANKS")
            return Launcher(name, None if size == 1 else size, rank, rank_key)
    return None


def world() -> Communicator:
    """Return the communicator of all ranks of this run.

    Returns
    -------
    mpi4py.MPI.Intracomm or Serial
        ``COMM_WORLD`` when a launcher started several ranks, which initialises MPI; otherwise
        `Serial`, which needs no MPI library, and MPI stays uninitialised.

    Raises
    ------
    UsageError
        If mpi4py finds no MPI library.
    SharedUsageError
        If its MPI library is not the launcher's.
    """
    started = launcher()
    if started is None or started.size == 1:
        quiet_mpi()
        return Serial()
    count = "several" if started.size is None else str(started.size)
    try:
        with warnings.catch_warnings():
            # About the mismatch that is checked below.
            warnings.filterwarnings("ignore", "suspicious MPI execution environment")
            from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        raise UsageError(
            f"{started.name} started {count} processes, but mpi4py cannot load an MPI library:\n"
            f"  {' '.join(str(error).split())}\n"
            "Install the MPI library that the launcher belongs to, or load its module (on Debian:\n"
            "apt-get install openmpi-bin), or name it: MPI4PY_LIBMPI=/path/to/libmpi.so. Without\n"
            "mpirun, pgimp runs on one rank and needs no MPI. `pgimp doctor` checks the pieces."
        ) from None
    comm = cast(Communicator, MPI.COMM_WORLD)
    if comm.size == 1 and (started.size is not None or started.rank > 0):
        library = MPI.Get_library_version().strip("\0 \n").splitlines()[0].split(",")[0]
        number = f", of which this is number {started.rank} ({started.variable})"
        srun = started.variable == "SLURM_PROCID"
        # Number 0 speaks for all, unless it takes itself for a batch script.
        silent = launcher({**os.environ, "SLURM_PROCID": "0"}) is None and started.rank == 1
        raise (UsageError if silent else SharedUsageError)(
            f"{started.name} started {count} processes{number},\n"
            f"but the MPI library of mpi4py, {library}, does not know\n"
            "that launcher: it sees a world of 1 rank, so every process would run the whole case\n"
            "on its own. Start pgimp with the mpirun that belongs to that library"
            f"{', or with srun --mpi=pmix' * srun},\n"
            "or name the launcher's own library: MPI4PY_LIBMPI=/path/to/libmpi.so.\n"
            "`pgimp doctor` shows which launcher and library are found."
        )
    return comm


def quiet_mpi() -> None:
    """Keep imports from initialising MPI in this process.

    An h5py built with MPI imports ``mpi4py.MPI``, which initialises MPI by default.
    To be called before h5py is imported, by every command except a run on several ranks.
    """
    import mpi4py

    mpi4py.rc.initialize = False
    mpi4py.rc.finalize = False


def _message(*args: Any, **more: Any) -> Any:
    """Stand in for members that only several ranks have."""
    raise NotImplementedError("a run on one rank has no messages")


class Serial(Communicator):
    """A communicator of one rank, which needs no MPI library.

    It has the part of mpi4py's interface that makes sense on one rank; buffers are only ever sent
    between several.
    """

    rank = 0
    size = 1
    alltoall = send = isend = recv = irecv = Send = Isend = Recv = Irecv = _message
    Send_init = Recv_init = Iprobe = Allreduce = Iallreduce = Allgather = _message
    Alltoall = Alltoallv = Bcast = Dup = Split_type = Get_attr = Set_attr = _message

    def Barrier(self) -> None:
        """Return at once."""

    def bcast(self, obj: T, root: int = 0) -> T:
        """Return `obj`."""
        return obj

    def gather(self, sendobj: T, root: int = 0) -> list[T]:
        """Return a list of `sendobj` alone."""
        return [sendobj]

    def allgather(self, sendobj: T) -> list[T]:
        """Return a list of `sendobj` alone."""
        return [sendobj]

    def allreduce(self, sendobj: T, op: object = None) -> T:
        """Return `sendobj`."""
        return sendobj

    def Abort(self, errorcode: int = 0) -> None:
        """Leave the interpreter with status `errorcode`."""
        sys.exit(errorcode)


def describe(error: BaseException) -> str:
    """Text of an exception for the user: pgimp's own as is, others with the way to a traceback."""
    if os.environ.get("PGIMP_TRACEBACK", "") not in ("", "0"):
        return "".join(traceback.format_exception(error)).rstrip()
    if isinstance(error, PgimpError):
        return str(error)
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, MemoryError):
        return "out of memory" + (f": {error}" if str(error) else "")
    text = " ".join(str(error).split())
    text = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return f"unexpected {text} (set PGIMP_TRACEBACK=1 for the traceback)"


def say(message: str) -> None:
    """Write a message to stderr in one piece, so that messages of several ranks do not mix."""
    for stream, text in ((sys.stdout, ""), (sys.stderr, escape(f"pgimp: {message}\n"))):
        # Without a stream, only the status remains.
        with suppress(OSError, ValueError, AttributeError):
            stream.write(text)
            stream.flush()


@contextmanager
def abort_on_error(comm: Communicator) -> Iterator[None]:
    """End all ranks together, with one message, when any of them raises.

    A `CaseError` or `UsageError` that every rank raises is printed by rank 0, and all ranks leave
    with status 2. Anything else is printed by the lowest of the ranks that failed together, which
    then aborts the job with status 1. On one rank alone exceptions pass through.

    Parameters
    ----------
    comm : communicator
        Of all ranks; entering is collective.

    Raises
    ------
    SystemExit
        With status 2, on every rank, for a wrong case or command line.
    """
    if comm.size == 1:
        yield
        return
    private = comm.Dup()
    try:
        yield
    except (CaseError, UsageError) as error:
        agreement = private.Ibarrier()
        patience = time.monotonic() + _AGREEMENT_SECONDS
        while not agreement.Test():
            if time.monotonic() > patience or private.Iprobe(tag=_FAILURE_TAG):
                _abort(private, error)
            time.sleep(0.005)
        if comm.rank == 0:
            say(describe(error))
        raise SystemExit(error.exit_status) from None
    except (Exception, KeyboardInterrupt) as error:
        _abort(private, error)
    private.Free()


def _abort(private: Any, error: BaseException) -> None:
    """End all ranks; of the ranks that fail together only the lowest prints."""
    abort_together(private, error, lambda: say(f"rank {private.rank}: {describe(error)}"))


def abort_together(comm: Communicator, error: BaseException, speak: Callable[[], None]) -> None:
    """End all ranks; of the ranks that fail together only the lowest reports.

    Parameters
    ----------
    error : BaseException
        The reason; it has the exit status.
    speak : callable
        Reports it.
    """
    for above in range(comm.rank + 1, comm.size):
        comm.Isend(bytearray(), dest=above, tag=_FAILURE_TAG)
    first = time.monotonic() + _SAME_FAILURE_SECONDS
    while time.monotonic() < first:
        if comm.Iprobe(tag=_FAILURE_TAG):
            time.sleep(10 * _SAME_FAILURE_SECONDS)  # the lower rank ends the job meanwhile
            break
        time.sleep(0.005)
    else:
        speak()
    comm.Abort(130 if isinstance(error, KeyboardInterrupt) else getattr(error, "exit_status", 1))
