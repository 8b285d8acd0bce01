"""One HDF5 file of a frame, written by all ranks at once or by rank 0 for all, and checked."""

from __future__ import annotations

import errno
import os
import zlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pgimp.output.collective import explain
from pgimp.output.hdf5 import load_h5py, open_file
from pgimp.output.rows import Rows

Array = np.ndarray

# Rows go through rank 0, and are read back, in blocks of about this many bytes.
_BLOCK = 4 << 20
# More than HDF5 needs for the headers of all fields.
_HEADERS = 1 << 16
_CANNOT_RESERVE = {errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS}


class Dataset(NamedTuple):
    """A dataset to be made: its name, type, number of columns (0: a vector) and attributes."""

    name: str
    dtype: str
    columns: int
    attributes: dict[str, Any]

    @property
    def row_bytes(self) -> int:
        """Bytes of a row."""
        return np.dtype(self.dtype).itemsize * max(1, self.columns)


def create(
    path: Path, datasets: list[Dataset], count: int, attributes: dict[str, Any]
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
    attributes : dict
        Of the file's root.

    Returns
    -------
    dict of str to int
        Where in the file each dataset's first byte lies.

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
    with open(path, "wb"):
        # HDF5 that meets a full disk half way can crash the process later; find out first.
        _reserve(path, _HEADERS + count * sum(dataset.row_bytes for dataset in datasets))
    offsets = {}
    try:
        with open_file(path, "w") as file:
            file.attrs.update(attributes)
            for dataset in datasets:
                shape = (count, dataset.columns) if dataset.columns else (count,)
                made = h5py.h5d.create(
                    file.id,
                    dataset.name.encode(),
                    h5py.h5t.py_create(np.dtype(dataset.dtype)),
                    h5py.h5s.create_simple(shape),
                    properties,
                )
                h5py.Dataset(made).attrs.update(dataset.attributes)
                offsets[dataset.name] = made.get_offset()
    except RuntimeError as error:  # closing a file that could not be flushed
        raise OSError(str(error)) from error
    _reserve(path, path.stat().st_size)
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


class Written(NamedTuple):
    """A stretch of a file with the checksum of what was written there."""

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
    rows : Rows
        Which rows each rank has.
    parallel : bool
        Whether every rank writes its own rows; else rank 0 writes those of all.
    offsets : dict of str to int
        From `create`.
    """

    def __init__(self, path: Path, rows: Rows, parallel: bool, offsets: dict[str, int]) -> None:
        self.path = path
        self.rows = rows
        self.comm = rows.comm
        self.parallel = parallel
        self.offsets = offsets
        self.error: str | None = None
        self.written: list[Written] = []
        self._file: Any = None
        self._transfer: Any = None
        if parallel or self.comm.rank == 0:
            try:
                self._open()
            except OSError as error:
                self.error = explain(error)

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

    def write(self, name: str, block: Array) -> None:
        """Write this rank's rows of a dataset; collective.

        Parameters
        ----------
        name : str
            The dataset.
        block : ndarray, shape (n,) or (n, k)
            The rows, of the dataset's type.
        """
        row_bytes = block.dtype.itemsize * int(np.prod(block.shape[1:]))
        at_once = max(1, _BLOCK // row_bytes)
        if self.comm.rank > 0 and not self.parallel:
            for start in range(0, len(block), at_once):
                self.comm.Send(block[start : start + at_once], dest=0)
            return
        checksum = zlib.crc32(block.data) if len(block) else 0
        size = block.nbytes
        self._put(name, block, self.rows.first)
        if not self.parallel and self.comm.size > 1:
            some = np.empty((at_once, *block.shape[1:]), block.dtype)
            for rank in range(1, self.comm.size):
                row, last = self.rows.bounds[rank : rank + 2]
                while row < last:
                    part = some[: min(at_once, last - row)]
                    self.comm.Recv(part, source=rank)
                    checksum = zlib.crc32(part.data, checksum)
                    size += part.nbytes
                    self._put(name, part, row)
                    row += len(part)
        start = self.offsets[name] + self.rows.first * row_bytes
        self.written.append(Written(start, size, checksum))

    def _put(self, name: str, block: Array, first: int) -> None:
        """Write rows from `first` on; with all ranks at once where they write in parallel."""
        h5py = load_h5py()
        dataset = self._file[name].id
        there = dataset.get_space()
        if len(block):
            here = h5py.h5s.create_simple(block.shape)
            there.select_hyperslab((first, *(0,) * (block.ndim - 1)), block.shape)
        else:
            # h5py's own slicing would skip the call, and the other ranks wait (h5py issue 965).
            block = np.empty((1, *block.shape[1:]), block.dtype)
            here = h5py.h5s.create_simple(block.shape)
            here.select_none()
            there.select_none()
        try:
            dataset.write(here, there, block, dxpl=self._transfer)
        except OSError as error:
            self.error = self.error or explain(error)

    def close(self) -> None:
        """Close the file; collective if all ranks write."""
        if self._file is None:
            return
        try:
            self._file.flush()
        except OSError as error:
            self.error = self.error or explain(error)
        try:
            self._file.close()
        except (OSError, RuntimeError) as error:
            self.error = self.error or " ".join(str(error).split())

    def check(self) -> str | None:
        """Read back what this rank wrote; return what is wrong with it, or None."""
        try:
            with open(self.path, "rb", buffering=0) as stream:
                for start, size, checksum in self.written:
                    stream.seek(start)
                    if checksum != _checksum(stream, size):
                        return "it reads back different: the disk may be full or faulty"
        except OSError as error:
            return explain(error)
        return None


def _checksum(stream: Any, size: int) -> int:
    checksum = 0
    while size > 0:
        part = stream.read(min(size, _BLOCK))
        if not part:
            break
        checksum = zlib.crc32(part, checksum)
        size -= len(part)
    return checksum
