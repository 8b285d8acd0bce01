"""One HDF5 file, written by all ranks at once or by rank 0 for all, and checked."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from pgimp.errors import RunError
from pgimp.output.collective import explain
from pgimp.output.hdf5 import load_h5py, open_file

Array = np.ndarray

# Rows go through rank 0, and are read back, in blocks of about this many bytes.
_BLOCK = 4 << 20


class Share(Protocol):
    """Which rows are whose: `bounds` has where each rank's rows start, and the number of rows."""

    @property
    def comm(self) -> Any:
        """Communicator of all ranks."""

    @property
    def bounds(self) -> Sequence[int]:
        """Of one more entry than there are ranks."""


class Written(NamedTuple):
    """A stretch of a file with the checksum (CRC-32) of what was written there."""

    start: int
    size: int
    checksum: int


class FrameFile:
    """A file made by `datasets.create`, open for writing on every rank that writes to it.

    An error is kept, not raised, so that all ranks go on to the next collective call; the first
    one is in `error`.

    Parameters
    ----------
    path : Path
        The file.
    rows : Share
        Which rows each rank has.
    parallel : bool
        Whether every rank writes its own rows; else rank 0 writes those of all.
    offsets : dict of str to int
        From `datasets.create`.
    most : int, optional
        A stretch with a checksum of its own gets no longer than this, in bytes, or hardly.

    Attributes
    ----------
    written : list of Written
        What this rank wrote, in the order of writing.
    error : str or None
        What went wrong first on this rank.
    """

    def __init__(
        self,
        path: Path,
        rows: Share,
        parallel: bool,
        offsets: dict[str, int],
        most: float = math.inf,
    ) -> None:
        self.path = path
        self.comm = rows.comm
        self.bounds = rows.bounds
        self.parallel = parallel
        self.offsets = offsets
        self.error: str | None = None
        self.written: list[Written] = []
        self._most = max(_BLOCK, most)
        self._file: Any = None
        self._transfer: Any = None
        if parallel or self.comm.rank == 0:
            try:
                self._open()
            except Exception as error:
                self._keep(error)
                if parallel:
                    # The others may still wait for this rank within the call: end the job.
                    raise RunError(f"cannot open {path} on all ranks: {self.error}") from error

    def _open(self) -> None:
        if not self.parallel:
            self._file = open_file(self.path, "r+")
            return
        h5py = load_h5py()
        self._transfer = h5py.h5p.create(h5py.h5p.DATASET_XFER)
        self._transfer.set_dxpl_mpio(h5py.h5fd.MPIO_COLLECTIVE)
        self._file = h5py.File(
            self.path, "r+", driver="mpio", comm=self.comm, libver=("earliest", "v110")
        )

    def _keep(self, error: Exception) -> None:
        """Remember the first error; HDF5's come as exceptions of many types."""
        if self.error is None:
            text = " ".join(str(error).split()) or type(error).__name__
            self.error = explain(error) if isinstance(error, OSError) else text

    def write(self, name: str, block: Array) -> None:
        """Write this rank's rows of a dataset; collective.

        Parameters
        ----------
        name : str
            The dataset.
        block : ndarray, shape (n, ...)
            The rows, of the dataset's type, in C order.
        """
        if not self.bounds[-1]:
            return  # no rank has a row, and HDF5 fails to write nothing to nothing
        row_bytes = block.dtype.itemsize * math.prod(block.shape[1:])
        at_once = max(1, _BLOCK // max(1, row_bytes))
        if self.comm.rank > 0 and not self.parallel:
            for start in range(0, len(block), at_once):
                self.comm.Send(block[start : start + at_once], dest=0)
            return
        row = self.bounds[self.comm.rank]
        self._put(name, block, row)
        for start in range(0, len(block), at_once):
            self._note(name, block[start : start + at_once], row + start)
        if not self.parallel and self.comm.size > 1:
            some = np.empty((at_once, *block.shape[1:]), block.dtype)
            for rank in range(1, self.comm.size):
                row, last = self.bounds[rank : rank + 2]
                while row < last:
                    part = some[: min(at_once, last - row)]
                    self.comm.Recv(part, source=rank)
                    self._put(name, part, row)
                    self._note(name, part, row)
                    row += len(part)

    def _note(self, name: str, block: Array, first: int) -> None:
        """Remember what lies in the file from row `first` on, as one stretch with that before it.

        Rows of no bytes leave no trace.
        """
        start, size, checksum = self.offsets[name] + first * (block.nbytes // len(block)), 0, 0
        if self.written:
            before = self.written[-1]
            if before.start + before.size == start and before.size + block.nbytes <= self._most:
                start, size, checksum = self.written.pop()
        if size + block.nbytes:
            checksum = zlib.crc32(np.ravel(block).view(np.uint8).data, checksum)
            self.written.append(Written(start, size + block.nbytes, checksum))

    def _put(self, name: str, block: Array, first: int) -> None:
        """Write rows from `first` on; with all ranks at once where they write in parallel."""
        try:
            h5py = load_h5py()
            dataset = self._file[name].id
            there = dataset.get_space()
            if block.size:
                here = h5py.h5s.create_simple(block.shape)
                there.select_hyperslab((first, *(0,) * (block.ndim - 1)), block.shape)
            else:
                # h5py's own slicing would skip the call; the other ranks wait (h5py issue 965).
                block = np.empty((1, *block.shape[1:]), block.dtype)
                here = h5py.h5s.create_simple(block.shape)
                here.select_none()
                there.select_none()
            dataset.write(here, there, block, dxpl=self._transfer)
        except Exception as error:
            self._keep(error)

    def close(self) -> None:
        """Close the file; collective if all ranks write."""
        if self._file is None:
            return
        for action in (self._file.flush, self._file.close):
            try:
                action()
            except Exception as error:
                self._keep(error)

    def check(self) -> str | None:
        """Read back what this rank wrote; return what is wrong with it, or None."""
        try:
            with open(self.path, "rb", buffering=0) as stream:
                for start, size, checksum in self.written:
                    stream.seek(start)
                    if checksum != checksum_of(stream, size):
                        return "it reads back different: the disk may be full or faulty"
        except OSError as error:
            return explain(error)
        return None


def checksum_of(stream: Any, size: int) -> int:
    """CRC-32 of the next `size` bytes of a stream, or of what is left of it."""
    checksum = 0
    while size > 0:
        part = stream.read(min(size, _BLOCK))
        if not part:
            break
        checksum = zlib.crc32(part, checksum)
        size -= len(part)
    return checksum
