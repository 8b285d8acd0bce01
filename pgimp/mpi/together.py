"""Meeting of ranks: all of them, with one case, or none waits for ever."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from hashlib import sha256
from types import TracebackType
from typing import Any

from pgimp.errors import UsageError
from pgimp.mpi.comm import abort_together, say
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.peers import Peers, peers_of, seconds

_DIGEST_TAG, _ANSWER_TAG = 78, 79
#: Seconds after which a rank reports that it waits for others, and after which it ends the job.
_REMARK, _PATIENCE = 20.0, 300.0


def require_same(comm: Communicator, what: str, content: str) -> None:
    """Refuse to begin with ranks missing, or with another content on some; collective.

    Ranks that do not come within `_PATIENCE`, or the seconds of PGIMP_PATIENCE, end the job. They
    do so by messages from rank to rank, which cannot be mistaken for other communication.

    Parameters
    ----------
    what : str
        The ranks' common act, for messages.
    content : str
        Content that must be equal on all.

    Raises
    ------
    UsageError
        On every rank, where contents differ.
    """
    if comm.size == 1:
        return
    mine = sha256(content.encode()).digest()
    peers = peers_of(comm)
    peers.acts += 1
    if comm.rank == 0:
        requests = [comm.irecv(source=rank, tag=_DIGEST_TAG) for rank in range(1, comm.size)]
        others = _wait(comm, what, dict(enumerate(requests, 1)), peers)
        differ = [rank for rank, digest in others.items() if digest != mine]
        for rank in range(1, comm.size):
            comm.send(differ, dest=rank, tag=_ANSWER_TAG)
    else:
        sent = comm.isend(mine, dest=0, tag=_DIGEST_TAG)
        answer = comm.irecv(source=0, tag=_ANSWER_TAG)
        differ = _wait(comm, what, {0: answer}, peers)[0]
        sent.wait()
    peers.met = True
    if differ:
        names = ", ".join(map(str, differ[:5])) + (", ..." if len(differ) > 5 else "")
        raise UsageError(
            f"{what}: rank{'s' * (len(differ) > 1)} {names} would do it with another case or other "
            "arguments than rank 0; all ranks work on one case together. For cases of their own "
            "give each the communicator pgimp.mpi.comm.Serial()"
        )


def _wait(comm: Communicator, what: str, requests: dict[int, Any], peers: Peers) -> dict[int, Any]:
    """Messages of the ranks, by rank; ends the job if some are missing."""
    patience = seconds(_PATIENCE)
    begin, found, said = time.monotonic(), {}, False
    while True:
        for rank in [rank for rank in requests if rank not in found]:
            done, value = requests[rank].test()
            if done:
                found[rank] = value
        if len(found) == len(requests):
            return found
        peers.require_present(what)
        spent = time.monotonic() - begin
        missing = min(set(requests) - set(found))
        if spent > patience:
            say(
                f"rank {comm.rank}: rank {missing} has not come to {what} within {patience:g} "
                "seconds; all ranks do it together. For one rank alone give it the communicator "
                "pgimp.mpi.comm.Serial(); for later ranks, PGIMP_PATIENCE is the time in seconds"
            )
            comm.Abort(1)
        if spent > _REMARK and not said:
            say(f"rank {comm.rank}: waiting for rank {missing} to come to {what}")
            said = True
        time.sleep(0.0005 if spent < 1.0 else 0.01)


def end_all_on_exceptions(comm: Communicator) -> None:
    """Let an exception uncaught on one rank end all ranks, as they would wait for it."""
    before: Callable[..., Any] = sys.excepthook
    if comm.size == 1 or getattr(before, "ends_all", False):
        return

    def hook(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        def speak() -> None:
            before(kind, error, trace)
            say(f"rank {comm.rank} failed, which ends all ranks")

        abort_together(comm, error, speak)

    hook.ends_all = True  # type: ignore[attr-defined]
    sys.excepthook = hook
