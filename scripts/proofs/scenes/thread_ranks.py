"""Ranks as threads of this process, with a communicator that does what pgimp asks of MPI's.

What one rank sends is copied, so that ranks share no memory but what is constant. Ranks that wait
for one that has failed are released, and one that waits for ever ends with an error: so a run in
which ranks disagree is an outcome like any other, and does no harm to the process.
"""

import pickle
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
from proofs.scenes.thread_messages import Message, Reduction, Request, World

from pgimp.mpi.comm import quiet_mpi


def prepare():
    """Put a stand-in in the place of MPI's constants, so that no MPI library is initialised."""
    quiet_mpi()
    import h5py  # noqa: F401  # one that is built with MPI needs mpi4py's own module
    import mpi4py

    row = SimpleNamespace(Commit=lambda: None, Free=lambda: None)
    constants = SimpleNamespace(
        MAX="max",
        MIN="min",
        SUM="sum",
        BOR="bor",
        COMM_TYPE_SHARED="shared",
        BYTE=SimpleNamespace(Create_contiguous=lambda size: row),
        Comm=SimpleNamespace(Create_keyval=lambda: "key"),
        Is_initialized=lambda: False,
        Is_finalized=lambda: True,  # threads have nothing to tell each other as the process ends
    )
    mpi4py.MPI = sys.modules["mpi4py.MPI"] = constants


class Comm:
    """One rank's communicator in a world that all ranks share.

    The name tells communicators of the same ranks apart.
    """

    def __init__(self, rank, size, world, name=""):
        self.rank, self.size, self.world, self._name = rank, size, world, name
        self.stop_at, self._attributes = None, {}

    def _box(self, source, to, tag):
        return self.world.box(self._name, source, to, tag)

    def spread(self, tag, values):
        """Send each rank, this one too, its own of `values`."""
        for to, value in enumerate(values):
            self._box(self.rank, to, tag).put(value)

    def collect(self, tag):
        """What all ranks have spread, in their order."""
        return [self.world.take(self._box(rank, self.rank, tag)) for rank in range(self.size)]

    # -- objects

    def allgather(self, value):
        self.spread("objects", [pickle.dumps(value)] * self.size)
        return [pickle.loads(each) for each in self.collect("objects")]

    def alltoall(self, values):
        self.spread("objects", [pickle.dumps(value) for value in values])
        return [pickle.loads(each) for each in self.collect("objects")]

    def gather(self, value, root=0):
        every = self.allgather(value)
        return every if self.rank == root else None

    def bcast(self, value=None, root=0):
        return self.allgather(value if self.rank == root else None)[root]

    def allreduce(self, value):
        return sum(self.allgather(value))

    def Barrier(self):
        self.allgather(None)

    def send(self, value, dest, tag=0):
        self._box(self.rank, dest, tag).put(pickle.dumps(value))

    def isend(self, value, dest, tag=0):
        """Send a value, too: none waits for its receiver."""
        self.send(value, dest, tag)
        return SimpleNamespace(wait=lambda: None)

    def irecv(self, source, tag=0):
        return Message(self.world, self._box(source, self.rank, tag))

    def Iprobe(self, source, tag=0):
        """Whether a message has come: none does from ranks that end, whose failures are known."""
        return False

    def recv(self, source, tag=0):
        return pickle.loads(self.world.take(self._box(source, self.rank, tag)))

    # -- arrays

    def Send_init(self, array, to, tag=0):
        return Request(self.world, self._box(self.rank, to, tag), array, False)

    def Recv_init(self, array, source, tag=0):
        return Request(self.world, self._box(source, self.rank, tag), array, True)

    def Isend(self, array, dest, tag=0):
        request = self.Send_init(array, dest, tag)
        request.Start()
        return request

    def Irecv(self, array, source, tag=0):
        request = self.Recv_init(array, source, tag)
        request.Start()
        return request

    def Recv(self, array, source, tag=0):
        self.Irecv(array, source, tag).Wait()

    def Allgather(self, mine, every):
        every[...] = np.array(self.allgather(mine)).reshape(every.shape)

    def Allreduce(self, mine, every, operation="sum"):
        parts = self.allgather(mine.copy())
        if operation == "sum":
            every[...] = sum(parts)
        else:
            unite = {"max": np.maximum, "min": np.minimum, "bor": np.bitwise_or}[operation]
            every[...] = unite.reduce(parts)

    def Bcast(self, array, root=0):
        array[...] = self.bcast(array.copy(), root)

    def Alltoall(self, sent, received):
        self.spread("numbers", sent.copy())
        received[:] = self.collect("numbers")

    def Alltoallv(self, sent, received):
        """Exchange parts of buffers of bytes, whose rows are counted."""
        (values, counts, _), (room, *_) = sent, received
        values, room = values.reshape(-1), room.reshape(-1)
        size = values.size // max(int(np.sum(counts)), 1)
        ends = size * np.cumsum(counts)[:-1]
        self.spread("parts", [part.copy() for part in np.split(values, ends)])
        parts = np.concatenate(self.collect("parts"))
        if parts.size != room.size:
            raise RuntimeError(f"{parts.size} bytes arrive where {room.size} are expected")
        room[:] = parts

    def Iallreduce(self, mine, every, _):
        self.spread("reduction", [mine.copy()] * self.size)
        return Reduction(self, every)

    # -- communicators

    def Get_attr(self, key):
        return self._attributes.get(key)

    def Set_attr(self, key, value):
        self._attributes[key] = value

    def Dup(self):
        return Comm(self.rank, self.size, self.world, f"{self._name}+")

    def Split_type(self, _):
        """Return one of the same ranks: all are on one node."""
        return self.Dup()

    def Free(self):
        """Do nothing."""


def together(size, task):
    """Run ``task(comm)`` on some ranks; what it returned, or what it raised, by rank."""
    world, results = World(), [None] * size

    def work(rank):
        try:
            results[rank] = task(Comm(rank, size, world))
        except BaseException as error:
            results[rank] = error
            world.failed = world.failed or time.monotonic()

    threads = [threading.Thread(target=work, args=(rank,), daemon=True) for rank in range(size)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    world.forget()
    return results
