"""Files that ranks on several nodes write through caches of whole pages, as clients of NFS do."""

import os
import random
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from particle_source import make_case, make_sim
from rank_threads import together

from pgimp.errors import RunError
from pgimp.io.checkpoints.checkpointfile import write
from pgimp.io.results.reader import Frame
from pgimp.running.frames import Frames
from pgimp.running.meshes.gridframes import GridFrames
from pgimp.solver.state import grid_state
from pgimp.storage import chunks, framefile
from pgimp.storage.rows import _Exchange

KINDS = ("checkpoint", "frame", "float32", "gzip", "grid")


class Comm:
    """One of several ranks that are threads."""

    def __init__(self, rank: int, box: list, barrier: threading.Barrier) -> None:
        self.rank, self.size = rank, len(box)
        self._box, self._barrier = box, barrier

    def allgather(self, thing):
        self._box[self.rank] = thing
        self._barrier.wait(20)
        things = list(self._box)
        self._barrier.wait(20)
        return things

    def bcast(self, thing):
        return self.allgather(thing)[0]

    def gather(self, thing):
        return self.allgather(thing) if self.rank == 0 else self.allgather(thing) and None

    def alltoall(self, things):
        return [of_one[self.rank] for of_one in self.allgather(things)]

    def Alltoall(self, sent, received):
        received[:] = self.alltoall(sent.copy())


def move(self, values, sent, arrived, received):
    """Stands for MPI's Alltoallv in `_Exchange`."""
    parts = self._comm.alltoall(np.split(values.copy(), np.cumsum(sent)[:-1]))
    arrived[:] = np.concatenate(parts)


class Server:
    """A file system whose clients keep pages and write each as a whole when they close a file.

    It stands for `os` and `put` in `framefile`. Each client takes what it does not write for what
    was there when it opened the file. Pages arrive in any order once all clients have closed.
    """

    def __init__(self, clients: int, page: int, seed: int) -> None:
        self.clients, self.page = clients, page
        self._random = random.Random(seed)
        self._lock = threading.Lock()
        self._open: dict[int, tuple[Path, bytes, dict[int, bytearray]]] = {}
        self._closed: list[tuple[int, bytearray]] = []
        self._closings = 0

    def __getattr__(self, name: str):
        return getattr(os, name)

    def open(self, path: Path, flags: int) -> int:
        if not flags & os.O_WRONLY:
            return os.open(path, flags)
        with self._lock:
            descriptor = 100_000 + len(self._open)
            self._open[descriptor] = path, path.read_bytes(), {}
        return descriptor

    def put(self, descriptor: int, data: memoryview, place: int) -> None:
        _, before, pages = self._open[descriptor]
        while data:
            number, begin = divmod(place, self.page)
            if number not in pages:
                old = before[number * self.page :][: self.page]
                pages[number] = bytearray(old.ljust(self.page, b"\0"))
            some = data[: self.page - begin]
            pages[number][begin : begin + len(some)] = some
            data, place = data[len(some) :], place + len(some)

    def fdatasync(self, descriptor: int) -> None:
        pass

    def close(self, descriptor: int) -> None:
        if descriptor not in self._open:
            os.close(descriptor)
            return
        with self._lock:
            path, _, pages = self._open[descriptor]
            self._closed += pages.items()
            self._closings += 1
            if self._closings % self.clients == 0:
                self._random.shuffle(self._closed)
                size = path.stat().st_size
                with open(path, "r+b") as file:
                    for number, data in self._closed:
                        file.seek(number * self.page)
                        file.write(data[: max(0, size - file.tell())])
                self._closed.clear()


def write_file(kind: str, shares: list[int], seed: int, folder: Path, comm: Comm) -> None:
    """Write a file of a kind, with so many rows on each rank or in all."""
    rng = np.random.default_rng([seed, comm.rank])
    count = shares[comm.rank]
    if kind == "checkpoint":
        widths = np.random.default_rng(seed).integers(0, 12, 5).tolist()
        rows = {f"field{i}": rng.random((count, width)) for i, width in enumerate(widths)}
        rows["body"] = rng.integers(9, size=count).astype(np.int32)
        write(folder / "file.h5", comm, {"a": 1}, rows, {"b": rng.random(seed % 3000)})
        return
    if kind == "grid":
        grid = SimpleNamespace(
            first=(sum(shares[: comm.rank]),) * 2,
            total=(sum(shares),) * 2,
            cells=rng.integers(count + 1, size=(count, 8)),
            position=rng.random((count, 3)),
            mass=rng.random(count),
            force=rng.random((count, 3)),
        )
        rank = SimpleNamespace(grid=grid)
        sim = SimpleNamespace(comm=comm, time=0.5, step=3, rank=rank)
        case = make_case(grid=["mass", "force"])
        case.dimensions = 3
        files = GridFrames(folder, case, sim)
        files.write(sim, 0)
    else:
        options = {"precision": kind} if kind == "float32" else {}
        options |= {"compression": kind} if kind == "gzip" else {}
        sim, _ = make_sim(comm, sum(shares), 3)
        files = Frames(folder, make_case(**options), sim)
        files.write(sim)
    files.finish()


def on_ranks(kind, shares, seed, folder) -> dict[str, bytes]:
    """Files that are there when ranks have written one."""
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    box, barrier = [None] * len(shares), threading.Barrier(len(shares))
    together(
        [
            partial(write_file, kind, shares, seed, folder, Comm(rank, box, barrier))
            for rank in range(len(shares))
        ]
    )
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def small(monkeypatch) -> None:
    """A few rows at a time, and chunks of few rows, so that there are many edges."""
    monkeypatch.setattr(chunks, "ROWS", 400)
    monkeypatch.setattr(framefile, "_ROWS", 700)
    monkeypatch.setattr(_Exchange, "_move", move)
    monkeypatch.setattr(grid_state, "active_grid", lambda rank, time, dt: rank.grid)


@contextmanager
def served(server: Server) -> Iterator[None]:
    """Let the ranks write through a server."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(framefile, "os", server)
        patch.setattr(framefile, "put", server.put)
        yield


@given(
    kind=st.sampled_from(KINDS),
    shares=st.lists(st.integers(0, 3) | st.integers(0, 4000), min_size=2, max_size=6),
    page=st.sampled_from([1 << 12, 1 << 14, 1 << 16]),
    seed=st.integers(0, 9999),
)
@settings(
    max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None
)
def test_no_page_has_two_writers(tmp_path_factory, small, kind, shares, page, seed):
    """Whatever the ranks write, in whichever order it arrives, the file is as without caches."""
    first, second = (tmp_path_factory.mktemp(name) for name in ("plain", "cached"))
    wanted = on_ranks(kind, shares, seed, first)
    with served(Server(len(shares), page, seed)):
        assert on_ranks(kind, shares, seed, second) == wanted


@pytest.mark.parametrize("kind", KINDS)
def test_lost_bytes_are_noticed(tmp_path, small, monkeypatch, kind):
    """Ranks that write each its own bytes lose some; there is then no file, and those before stay.

    A block of one byte has one writer whatever happens.
    """
    shares = [900, 0, 2100]
    before = on_ranks(kind, shares, 1, tmp_path)
    monkeypatch.setattr(framefile, "BLOCK", 1)
    if kind == "checkpoint":
        where, lost = tmp_path, "file.h5"
    else:
        where, lost = tmp_path / "frames", next(name for name in before if name.endswith(".h5"))
        (where / lost).rename(where / "kept.h5")
    kept = {path: path.read_bytes() for path in where.iterdir() if path.is_file()}
    said = rf"bytes \d+ to \d+ of .*{lost}\.part .* has lost some"
    with served(Server(3, 1 << 12, 5)), pytest.raises(RunError, match=said):
        on_ranks(kind, shares, 2, tmp_path)
    assert {path: path.read_bytes() for path in where.iterdir() if path.is_file()} == kept


def test_a_frame_on_several_nodes_is_read_from_the_server(tmp_path, small, monkeypatch):
    """Where hosts differ, what a node has in its memory is given up before it reads."""
    given_up = []
    monkeypatch.setattr(os, "posix_fadvise", lambda *words: given_up.append(words[1:]))
    on_ranks("frame", [300, 300], 1, tmp_path)
    assert not given_up
    names = iter("ab" * 9)
    monkeypatch.setattr(framefile.socket, "gethostname", lambda: next(names))
    on_ranks("frame", [300, 300], 1, tmp_path)
    assert given_up == [(0, 0, os.POSIX_FADV_DONTNEED)] * 2
    assert len(Frame(tmp_path / "frames" / "particles-000000.h5")) == 600
