"""Ranks as threads of one process that send each other messages, in place of MPI."""

import queue
import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


class _Request:
    """Of a message that is sent or received, as often as it is started."""

    active = False

    def __init__(self, box: queue.Queue, buffer: np.ndarray, receives: bool) -> None:
        self.box, self.buffer, self.receives = box, buffer, receives

    def Start(self) -> None:
        assert not self.active
        self.active = True
        if not self.receives:
            self.box.put(self.buffer.copy())

    def Test(self) -> None:
        pass

    def Wait(self) -> None:
        if self.receives and self.active:
            message = self.box.get(timeout=20)
            assert message.size <= self.buffer.size
            self.buffer[: message.size] = message
        self.active = False

    def Free(self) -> None:
        assert not self.active


class Comm:
    """One rank's end of the messages between the threads of `together`."""

    def __init__(self, rank: int, boxes: dict) -> None:
        self.rank, self.boxes = rank, boxes

    def _box(self, sender: int, receiver: int, tag: int) -> queue.Queue:
        return self.boxes.setdefault((sender, receiver, tag), queue.Queue())

    def Send_init(self, array: np.ndarray, receiver: int, tag: int) -> _Request:
        return _Request(self._box(self.rank, receiver, tag), array, False)

    def Recv_init(self, array: np.ndarray, sender: int, tag: int) -> _Request:
        return _Request(self._box(sender, self.rank, tag), array, True)

    def Isend(self, array: np.ndarray, receiver: int, tag: int) -> _Request:
        request = self.Send_init(array, receiver, tag)
        request.Start()
        return request

    def Recv(self, array: np.ndarray, sender: int, tag: int) -> None:
        request = self.Recv_init(array, sender, tag)
        request.Start()
        request.Wait()


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
