"""One HDF5 file, written by all ranks at once or by rank 0 for all, and checked."""

from __future__ import annotations

import errno
import math
import os
import socket
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np

from pgimp.output.collective import explain
from pgimp.output.hdf5 import load_h5py, open_file

Array = np.ndarray

# Rows go through rank 0, and are read back, in blocks of about this many bytes.
_BLOCK = 4 << 20
# More than HDF5 needs for the headers of all fields.
_HEADERS = 1 << 16
_CANNOT_RESERVE = {errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS}
_NONE: Mapping[str, Any] = MappingProxyType({})


class Dataset(NamedTuple):
    """A dataset to be made: its name, type, shape of a row and attributes."""

    name: str
    dtype: str
    tail: tuple[int, ...]
    attributes: Mapping[str, Any] = _NONE

    @property
    def row_bytes(self) -> int:
        """Bytes of a row."""
        return np.dtype(self.dtype).itemsize * math.prod(self.tail)


class Share(Protocol):
    """Which rows are whose: `bounds` has where each rank's rows start, and the number of rows."""

    @property
    def comm(self) -> Any:
        """Communicator of all ranks."""

    @property
    def bounds(self) -> Sequence[int]:
        """Of one more entry than there are ranks."""


def create(
    path: Path,
    datasets: list[Dataset],
    count: int,
    attributes: Mapping[str, Any] = _NONE,
    whole: Mapping[str, Array] = _NONE,
    user_block: int = 0,
) -> dict[str, int]:
    """Make a file whose datasets lie in one piece each, with their space on the disk reserved.

    On a full disk a parallel write loses data without an error; so the space is there before any
    rank writes.

    Parameters
    ----------
    path : Path
        The file; replaced if there.
    datasets : list of Dataset
        What it holds.
    count : int
        Rows of each dataset.
    attributes : mapping
        Of the file's root.
    whole : mapping of str to ndarray
        Further datasets, small ones, written here and now.
    user_block : int
        Bytes before what is HDF5's, left zero: none, or a power of two from 512 on.

    Returns
    -------
    dict of str to int
        Where in the file each dataset's first byte lies; 0 if it has none.

    Raises
    ------
    OSError
        If there is no room, or the file cannot be made.
    """
    h5py = load_h5py()
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    properties.set_obj_track_times(False)
    size = count * sum(dataset.row_bytes for dataset in datasets)
    size += sum(array.nbytes for array in whole.values())
    shapes = [(dataset, (count, *dataset.tail)) for dataset in datasets]
    shapes += [(Dataset(name, array.dtype.str, ()), array.shape) for name, array in whole.items()]
    with open(path, "wb"):
        # HDF5 that meets a full disk half way can crash the process later; find out first.
        _reserve(path, user_block + _HEADERS + size)
    offsets = {}
    try:
        with open_file(path, "w", userblock_size=user_block) as file:
            file.attrs.update(attributes)
            for dataset, shape in shapes:
                made = h5py.h5d.create(
                    file.id,
                    dataset.name.encode(),
                    h5py.h5t.py_create(np.dtype(dataset.dtype)),
                    h5py.h5s.create_simple(shape),
                    properties,
                )
                h5py.Dataset(made).attrs.update(dataset.attributes)
                offsets[dataset.name] = made.get_offset() if math.prod(shape) else 0
    except RuntimeError as error:  # closing a file that could not be flushed
        raise OSError(str(error)) from error
    _reserve(path, path.stat().st_size)
    if whole:
        with open(path, "r+b") as stream:
            for name, array in whole.items():
                stream.seek(offsets[name])
                stream.write(np.ravel(array).view(np.uint8).data)
    return offsets


def _reserve(path: Path, size: int) -> None:
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.posix_fallocate(descriptor, 0, size)
    except OSError as error:
        if error.errno not in _CANNOT_RESERVE:
            raise
    finally:
        os.close(descriptor)


def reachable(path: Path) -> str | None:
    """Find out whether this rank sees a file, before it enters a collective call for it.

    Returns
    -------
    str or None
        Why it does not.
    """
    try:
        os.close(os.open(path, os.O_RDWR))
    except OSError as error:
        return (
            f"{explain(error)} on {socket.gethostname()}; the run directory must be on a file "
            "system that all ranks share"
        )
    return None


class Written(NamedTuple):
    """A stretch of a file with the checksum (CRC-32) of what was written there."""

    start: int
    size: int
    checksum: int


class FrameFile:
    """A file made by `create`, open for writing on every rank that writes to it.

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
        From `create`.
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
