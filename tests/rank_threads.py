"""Ranks as threads of one process that send each other messages, in place of MPI."""

import queue
import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


class _Done:
    def Wait(self) -> None:
        pass


class _Receipt:
    def __init__(self, box: queue.Queue, buffer: np.ndarray) -> None:
        self.box, self.buffer = box, buffer

    def Wait(self) -> None:
        message = self.box.get(timeout=20)
        assert message.size == self.buffer.size
        self.buffer[:] = message


class _Message:
    def __init__(self, content: np.ndarray) -> None:
        self.content = content

    def Recv(self, buffer: np.ndarray) -> None:
        assert self.content.size == buffer.size
        buffer.reshape(-1)[:] = self.content.reshape(-1)


class _Status:
    count = 0

    def Get_count(self, datatype: object) -> int:
        return self.count


class MPI:
    """The names of mpi4py.MPI that `migrate` uses."""

    Status = _Status
    DOUBLE = "double"


class Comm:
    """One rank's end of the messages between the threads of `together`."""

    def __init__(self, rank: int, boxes: dict) -> None:
        self.rank, self.boxes = rank, boxes

    def _box(self, sender: int, receiver: int, tag: int) -> queue.Queue:
        return self.boxes.setdefault((sender, receiver, tag), queue.Queue())

    def Isend(self, array: np.ndarray, receiver: int, tag: int) -> _Done:
        self._box(self.rank, receiver, tag).put(array.copy())
        return _Done()

    def Irecv(self, array: np.ndarray, sender: int, tag: int) -> _Receipt:
        return _Receipt(self._box(sender, self.rank, tag), array)

    def Mprobe(self, sender: int, tag: int, status: _Status) -> _Message:
        content = self._box(sender, self.rank, tag).get(timeout=20)
        status.count = content.size
        return _Message(content)


def together(tasks: Sequence[Callable[[], Any]]) -> list:
    """Results of tasks that wait for each other's messages, each run in a thread."""
    results: list = [None] * len(tasks)
    failures: list[BaseException] = []

    def work(i: int) -> None:
        try:
            results[i] = tasks[i]()
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=work, args=(i,), daemon=True) for i in range(len(tasks))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]
    return results
