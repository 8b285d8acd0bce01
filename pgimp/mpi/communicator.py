"""The part of mpi4py's communicator that pgimp uses, for type checkers; see `pgimp.mpi.comm`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

T = TypeVar("T")

#: A function of mpi4py that takes buffers or requests, whose types it does not declare.
Message = Callable[..., Any]


class Request(Protocol):
    """A message under way, or one that is sent again and again."""

    Start: Message
    Wait: Message
    Test: Message
    Free: Message


class Communicator(Protocol):
    """All ranks of a run: mpi4py's ``Intracomm``, or `pgimp.mpi.comm.Serial` for one rank.

    Members of the type `Message` exist only with several ranks.
    """

    rank: int
    size: int
    alltoall: Message
    send: Message
    isend: Message
    recv: Message
    irecv: Message
    Send: Message
    Isend: Message
    Recv: Message
    Irecv: Message
    Send_init: Message
    Recv_init: Message
    Iprobe: Message
    Allreduce: Message
    Iallreduce: Message
    Allgather: Message
    Alltoall: Message
    Alltoallv: Message
    Bcast: Message
    Dup: Message
    Split_type: Message
    Get_attr: Message
    Set_attr: Message

    def Barrier(self) -> None:
        """Wait until all ranks have come here."""

    def Abort(self, errorcode: int = 0) -> object:
        """End all ranks."""

    def bcast(self, obj: T, root: int = 0) -> T:
        """Return the object of rank `root`."""

    def gather(self, sendobj: object, root: int = 0) -> Any:
        """Return the objects of all ranks on rank `root`, None elsewhere."""

    def allgather(self, sendobj: T) -> list[T]:
        """Return the objects of all ranks."""

    def allreduce(self, sendobj: T, op: object = None) -> T:
        """Return the reduction of the objects of all ranks; by default their sum."""
