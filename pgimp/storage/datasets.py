"""Creation of HDF5 files with reserved space on the disk, before any rank writes to them."""

from __future__ import annotations

import ctypes
import errno
import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from pgimp.storage.hdf5 import load_h5py, open_file
from pgimp.storage.image import Image

Array = np.ndarray

_CANNOT_RESERVE = {errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS}
# Not POSIX's function: without support it writes to every page, also to other ranks' pages.
_fallocate = ctypes.CDLL(None, use_errno=True).fallocate
_fallocate.argtypes = ctypes.c_int, ctypes.c_int, ctypes.c_int64, ctypes.c_int64
_KEEP_SIZE = 1
_NONE: Mapping[str, Any] = MappingProxyType({})


class Dataset(NamedTuple):
    """A dataset to create: name, type, shape of a row and attributes."""

    name: str
    dtype: str
    tail: tuple[int, ...]
    attributes: Mapping[str, object] = _NONE

    @property
    def row_bytes(self) -> int:
        """Bytes of a row."""
        return np.dtype(self.dtype).itemsize * math.prod(self.tail)


class Layout(NamedTuple):
    """Layout of a file with contiguous datasets."""

    offsets: dict[str, int]  #: Offset of each dataset's first byte in the file; 0 if it is empty.
    parts: dict[int, bytes]  #: HDF5's metadata of the datasets, by offset.
    size: int  #: Bytes of the file.

    def create(self, path: Path) -> None:
        """Create the file, with its space on the disk reserved.

        On a full disk a parallel write may lose data without an error, so the space is reserved
        before any rank writes. Nothing is written here: `FrameFile` writes each byte.

        Parameters
        ----------
        path : Path
            The file; replaced if it exists.

        Raises
        ------
        OSError
            If the disk is full, or the file cannot be created.
        """
        with open(path, "wb", buffering=0) as stream:
            reserve(stream.fileno(), 0, self.size)
            os.ftruncate(stream.fileno(), self.size)


def lay_out(
    datasets: list[Dataset],
    count: int,
    attributes: Mapping[str, object] = _NONE,
    whole: Mapping[str, Array] = _NONE,
    user_block: int = 0,
    more: Callable[[Any], None] | None = None,
    of_cells: Sequence[Dataset] = (),
) -> Layout:
    """Lay out a file.

    Parameters
    ----------
    datasets : list of Dataset
        Datasets of the file.
    count : int
        Rows of each dataset.
    attributes : mapping
        Attributes of the file's root.
    whole : mapping of str to ndarray
        Further datasets; only their types and shapes matter.
    user_block : int
        Zero bytes before HDF5's own: none, or a power of two from 512 on.
    more : callable, optional
        Adds what else the file has, given the open h5py.File: metadata and small datasets.
    of_cells : sequence of Dataset
        Datasets with a row for each row of `whole["connectivity"]`.

    Returns
    -------
    Layout
        Layout of the file.
    """
    h5py = load_h5py()
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    properties.set_obj_track_times(False)
    shapes = [(dataset, (count, *dataset.tail)) for dataset in datasets]
    shapes += [(each, (len(whole["connectivity"]), *each.tail)) for each in of_cells]
    shapes += [(Dataset(name, array.dtype.str, ()), array.shape) for name, array in whole.items()]
    offsets, image = {}, Image()
    with open_file(image, "w", userblock_size=user_block) as file:
        file.attrs.update(attributes)
        for dataset, shape in shapes:
            made = make(file, dataset, shape, properties)
            offsets[dataset.name] = made.get_offset() if math.prod(shape) else 0
        if more:
            more(file)
    return Layout(offsets, image.stretches(), image.size)


def make(file: Any, dataset: Dataset, shape: tuple[int, ...], properties: Any) -> Any:
    """Create a dataset of a shape in an HDF5 file and return its identifier."""
    h5py = load_h5py()
    made = h5py.h5d.create(
        file.id,
        dataset.name.encode(),
        h5py.h5t.py_create(np.dtype(dataset.dtype)),
        h5py.h5s.create_simple(shape),
        properties,
    )
    h5py.Dataset(made).attrs.update(dataset.attributes)
    return made


def reserve(descriptor: int, start: int, end: int, keep_size: bool = False) -> None:
    """Reserve space on the disk for a part of a file.

    Parameters
    ----------
    descriptor : int
        The file, open for writing.
    start, end : int
        Offsets of the part's beginning and end.
    keep_size : bool
        Whether the size of the file stays the same.

    Raises
    ------
    OSError
        If there is no space. On file systems without reservation a full disk shows on writing.
    """
    mode, code = _KEEP_SIZE if keep_size else 0, errno.EINTR
    while end > start and code == errno.EINTR:
        done = _fallocate(descriptor, mode, start, end - start)
        code = ctypes.get_errno() if done < 0 else 0
    if end > start and code and code not in _CANNOT_RESERVE:
        raise OSError(code, os.strerror(code))


def bytes_of(array: Array) -> memoryview:
    """Return the bytes of an array in C order."""
    return np.ravel(array).view(np.uint8).data


def put(descriptor: int, data: memoryview, place: int) -> None:
    """Write all data at an offset of a file.

    Raises
    ------
    OSError
        If that is not possible.
    """
    while data:
        count = os.pwrite(descriptor, data, place)
        data, place = data[count:], place + count
