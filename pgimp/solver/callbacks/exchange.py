"""What ranks do together within a function of a program, where any of them may fail.

Each act of all is one exchange, and so is the end of the function. A rank that fails, or does
something else than the others, is heard of in the next exchange by all: none waits for ever.
"""

from __future__ import annotations

from typing import TypeVar

from pgimp.errors import RunError
from pgimp.mpi.communicator import Communicator

T = TypeVar("T")

_FAILED = "fails"


class Exchange:
    """The acts of one call of the function, on all ranks.

    Parameters
    ----------
    where : str
        The call, for messages.
    """

    def __init__(self, comm: Communicator, where: str) -> None:
        self._comm, self._where = comm, where
        self._broken: RunError | None = None
        self._number = 0

    def gather(self, act: str, value: T) -> list[T]:
        """Return the values of all ranks, which come to the same act; collective.

        Raises
        ------
        RunError
            On every rank, if one has failed, or does something else.
        """
        if self._broken is not None:
            raise self._broken
        self._number += 1
        every = self._comm.allgather((act, value))
        for rank, (other, what) in enumerate(every):
            if other == _FAILED:
                where = f"on rank {rank}" if self._comm.size > 1 else "here"
                self._broken = RunError(f"{self._where} fails {where}: {what}")
                raise self._broken
        for rank, (other, _) in enumerate(every):
            if other != every[0][0]:
                self._broken = RunError(
                    f"{self._where}: its act {self._number} is {every[0][0]} on rank 0, but "
                    f"{other} on rank {rank}; sums and the like are for all ranks together"
                )
                raise self._broken
        return [each for _, each in every]

    def fail(self, text: str) -> RunError:
        """Tell the others of a failure, and return the error of all; collective with their act."""
        if self._broken is None:
            try:
                self.gather(_FAILED, text)
            except RunError as error:
                return error
        assert self._broken is not None
        return self._broken
