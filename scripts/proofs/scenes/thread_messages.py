"""Messages of ranks that are threads: each is copied, and who waits for ever gets an error."""

import pickle
import queue
import threading
import time

import numpy as np

#: Seconds that a rank waits for another: the first one may have to compile.
PATIENCE = 300.0
#: Seconds that ranks still wait for others after one has failed, which may fail alike.
GRACE = 3.0


class DesertedError(Exception):
    """A rank has waited for another that will never come."""


class World:
    """What the ranks of one run share: the messages on their way, and whether a rank has failed."""

    def __init__(self):
        self._boxes, self._lock = {}, threading.Lock()
        self.failed = None

    def box(self, *key):
        """The messages on one way."""
        with self._lock:
            return self._boxes.setdefault(key, queue.SimpleQueue())

    def forget(self):
        """Drop what nobody has received: communicators are kept until the process ends."""
        self._boxes.clear()

    def take(self, box):
        end = time.monotonic() + PATIENCE
        while True:
            try:
                return box.get(timeout=0.2)
            except queue.Empty:
                now = time.monotonic()
                if now > end or (self.failed is not None and now > self.failed + GRACE):
                    raise DesertedError("waits for a rank that has ended") from None


class Request:
    """A message of an array, sent or received as often as it is started."""

    def __init__(self, world, box, array, receives):
        self._world, self._box, self._array, self._receives = world, box, array, receives
        self._active = False

    def Start(self):
        """Begin to receive, or send a copy."""
        if self._active:
            raise RuntimeError("a request is started before its last message has arrived")
        self._active = True
        if not self._receives:
            self._box.put(self._array.copy())

    def Test(self):
        """Whether it is done: that only `Wait` knows."""
        return False

    def Wait(self):
        if self._receives and self._active:
            message = self._world.take(self._box)
            if message.size > self._array.size:
                raise RuntimeError("a message is longer than its receiver's room")
            self._array.reshape(-1)[: message.size] = message.reshape(-1)
        self._active = False

    def Free(self):
        self._box = None


class Message:
    """A value that is received."""

    def __init__(self, world, box):
        self._world, self._box = world, box

    def test(self):
        """Whether it has come, and the value."""
        if self._box.empty() and self._world.failed is None:
            return False, None
        return True, pickle.loads(self._world.take(self._box))


class Reduction:
    """The greatest of all ranks' numbers, once all have said theirs."""

    def __init__(self, comm, result):
        self._comm, self._result = comm, result

    def Wait(self):
        self._result[:] = np.max(self._comm.collect("reduction"), axis=0)
