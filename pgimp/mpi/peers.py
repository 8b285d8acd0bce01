"""Common acts of the ranks of a Python program: all do the same, or the job ends."""

from __future__ import annotations

import atexit
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any
from zlib import crc32

import numpy as np

from pgimp.errors import PgimpError, RunError, UsageError
from pgimp.mpi import comm as communicators
from pgimp.mpi.comm import abort_together, say
from pgimp.mpi.communicator import Communicator

#: Tag of a rank's end; the tags after it belong to the rounds in which all are notified of all.
_ENDED_TAG = 80
#: Seconds after which ranks that wait for others within a simulation end the job: one rank may
#: spend long on results.
_PATIENCE = 3600.0
#: Seconds for the other ranks to end, too, if the cause of this rank's end was common to all.
_AGREEMENT_SECONDS = 20.0
#: Seconds of waiting for others that are part of any step, and between polls after that.
_SHORT, _NAP = 0.02, 0.0005

_keyval: int | None = None


def seconds(default: float) -> float:
    """Time for which ranks wait for others, which PGIMP_PATIENCE may set."""
    return float(os.environ.get("PGIMP_PATIENCE", default))


class Peers:
    """Acts of the ranks of a communicator, and ranks that have ended.

    A rank that ends notifies the next one, in a ring. Where some have ended and others wait, a
    waiting rank follows an ended one, so one is notified. An ending rank waits for all.

    Parameters
    ----------
    comm : mpi4py.MPI.Comm
        Of several ranks.

    Attributes
    ----------
    acts : int
        Number of acts begun together.
    created : int
        Number of simulations among them.
    met : bool
        Whether all ranks have come together once.
    within : str
        The act that this rank has not completed.
    """

    def __init__(self, comm: Communicator) -> None:
        self.acts = self.created = 0
        self.within, self.met = "", False
        self._comm = comm
        self._of_previous: int | None = None
        self._pair, self._every = np.zeros((2, 2), np.int64)
        self._sent: list[Any] = []
        atexit.register(self._leave)

    def require_present(self, what: str) -> None:
        """End the job if the rank before this one has ended without coming to `what`."""
        comm = self._comm
        previous = (comm.rank - 1) % comm.size
        self._hear(previous, _ENDED_TAG)
        if self._of_previous is not None and self._of_previous < self.acts:
            text = f"rank {comm.rank}: rank {previous} has ended, and {what} needs all ranks"
            abort_together(comm, RunError(text), partial(say, text))

    def meet(self, act: str) -> None:
        """Wait for all ranks, and refuse to go on where one does something else; collective.

        Raises
        ------
        UsageError
            On every rank, if not all come to the same act.
        """
        from mpi4py import MPI

        self.acts += 1
        digest = crc32(act.encode())
        self._pair[:] = digest, -digest
        request = self._comm.Iallreduce(self._pair, self._every, MPI.MAX)
        begin = time.monotonic()
        while not request.Test():
            waited = time.monotonic() - begin
            if waited < _SHORT:
                continue
            self.require_present(act)
            if waited > seconds(_PATIENCE):
                text = (
                    f"rank {self._comm.rank}: others have not come to {act} within {waited:.0f} "
                    "seconds; all ranks do it together. For later ranks, PGIMP_PATIENCE is the "
                    "time in seconds"
                )
                abort_together(self._comm, RunError(text), partial(say, text))
            time.sleep(_NAP)
        self.met = True
        if self._every[0] != -self._every[1]:
            acts = self._comm.allgather(act)
            other = next(rank for rank, each in enumerate(acts) if each != acts[0])
            raise UsageError(
                f"rank 0 does {acts[0]}, rank {other} {acts[other]}; all ranks do the same "
                "together. For simulations of their own give each the communicator "
                "pgimp.mpi.comm.Serial()"
            )

    def _leave(self) -> None:
        """Wait, at the program's end, for the others to end: none finalises MPI before.

        Open MPI 4.1's mpirun may hang or crash where a rank aborts while another is in
        MPI_Finalize.
        """
        from mpi4py import MPI

        comm = self._comm
        if MPI.Is_finalized() or comm == MPI.COMM_NULL:
            return
        patience = _PATIENCE if self.met else _AGREEMENT_SECONDS
        last = time.monotonic() + (seconds(_AGREEMENT_SECONDS) if self.within else patience)
        shift, tag = 1, _ENDED_TAG
        while shift < comm.size:  # a dissemination barrier
            following, previous = (comm.rank + shift) % comm.size, (comm.rank - shift) % comm.size
            self._sent.append(comm.Isend(np.array([self.acts]), dest=following, tag=tag))
            while not self._hear(previous, tag):
                if time.monotonic() > last and self.within:
                    say(f"rank {comm.rank} has ended within {self.within}, and others wait for it")
                    comm.Abort(1)
                if time.monotonic() > last:
                    return
                time.sleep(_NAP)
            shift, tag = 2 * shift, tag + 1

    def _hear(self, other: int, tag: int) -> bool:
        """Whether a rank has announced its end."""
        if tag == _ENDED_TAG and self._of_previous is not None:
            return True
        heard: bool = self._comm.Iprobe(source=other, tag=tag)
        if heard:
            count = np.zeros(1, np.int64)
            self._comm.Recv(count, source=other, tag=tag)
            if tag == _ENDED_TAG:
                self._of_previous = int(count[0])
        return heard


def peers_of(comm: Communicator) -> Peers:
    """Record of the other ranks of a communicator, on this rank."""
    from mpi4py import MPI

    global _keyval
    if _keyval is None:
        _keyval = MPI.Comm.Create_keyval()
    peers: Peers | None = comm.Get_attr(_keyval)
    if peers is None:
        peers = Peers(comm)
        comm.Set_attr(_keyval, peers)
    return peers


def world() -> Any:
    """Communicator of all ranks of a Python program, with notice of a rank's end.

    Returns
    -------
    mpi4py.MPI.Intracomm or Serial
        As of `pgimp.mpi.comm.world`, which has the errors raised.
    """
    comm = communicators.world()
    if comm.size > 1:
        peers_of(comm)
    return comm


def created(comm: Communicator) -> int:
    """Number of a simulation that begins, among those of a communicator; 0 on one rank."""
    if comm.size == 1:
        return 0
    peers = peers_of(comm)
    peers.created += 1
    return peers.created


@contextmanager
def together(comm: Communicator, act: str) -> Iterator[None]:
    """Begin an act when all ranks have come to it; collective.

    Parameters
    ----------
    act : str
        The act, with its arguments: equal on all.

    Raises
    ------
    UsageError
        On every rank, if not all do the same.
    """
    if comm.size > 1:
        peers_of(comm).meet(act)
    with within(comm, act):
        yield


@contextmanager
def within(comm: Communicator, act: str) -> Iterator[None]:
    """Context of an act that all ranks begin and end together.

    A rank that leaves it with an exception of its own, and ends, ends the job.
    """
    peers = peers_of(comm) if comm.size > 1 else None
    if peers:
        peers.within = act
    try:
        yield
    except PgimpError:  # raised on every rank
        if peers:
            peers.within = ""
        raise
    if peers:
        peers.within = ""
