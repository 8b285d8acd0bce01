"""HDF5 files with their space on the disk, before any rank writes to them."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from pgimp.output.hdf5 import load_h5py, open_file
from pgimp.output.image import Image

Array = np.ndarray

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


class Layout(NamedTuple):
    """A file whose datasets lie in one piece each.

    Attributes
    ----------
    offsets : dict of str to int
        Where in the file each dataset's first byte lies; 0 if it has none.
    parts : dict of int to bytes
        What HDF5 says about the datasets, by its place.
    size : int
        Bytes of the file.
    """

    offsets: dict[str, int]
    parts: dict[int, bytes]
    size: int

    def create(self, path: Path, whole: Mapping[str, Array] = _NONE) -> None:
        """Make the file, with its space on the disk reserved.

        On a full disk a parallel write may lose data without an error; so the space is there before
        any rank writes.

        Parameters
        ----------
        path : Path
            The file; replaced if there.
        whole : mapping of str to ndarray
            Datasets that are written here and now.

        Raises
        ------
        OSError
            If there is no room, or the file cannot be made.
        """
        with open(path, "wb", buffering=0) as stream:
            reserve(stream.fileno(), 0, self.size)
            for place, data in self.parts.items():
                put(stream.fileno(), memoryview(data), place)
            for name, array in whole.items():
                put(stream.fileno(), bytes_of(array), self.offsets[name])


def lay_out(
    datasets: list[Dataset],
    count: int,
    attributes: Mapping[str, Any] = _NONE,
    whole: Mapping[str, Array] = _NONE,
    user_block: int = 0,
) -> Layout:
    """Find out where everything goes in a file.

    Parameters
    ----------
    datasets : list of Dataset
        What it holds.
    count : int
        Rows of each dataset.
    attributes : mapping
        Of the file's root.
    whole : mapping of str to ndarray
        Further datasets, of which only types and shapes matter.
    user_block : int
        Bytes before what is HDF5's, left zero: none, or a power of two from 512 on.

    Returns
    -------
    Layout
        The file to be.
    """
    h5py = load_h5py()
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    properties.set_obj_track_times(False)
    shapes = [(dataset, (count, *dataset.tail)) for dataset in datasets]
    shapes += [(Dataset(name, array.dtype.str, ()), array.shape) for name, array in whole.items()]
    offsets, image = {}, Image()
    with open_file(image, "w", userblock_size=user_block) as file:
        file.attrs.update(attributes)
        for dataset, shape in shapes:
            made = make(file, dataset, shape, properties)
            offsets[dataset.name] = made.get_offset() if math.prod(shape) else 0
    parts: dict[int, bytes] = {}
    last = -1
    for (place, _), data in sorted(image.parts.items()):
        if last >= 0 and place == last + len(parts[last]):
            parts[last] += data
        else:
            parts[place], last = data, place
    return Layout(offsets, parts, image.size)


def make(file: Any, dataset: Dataset, shape: tuple[int, ...], properties: Any) -> Any:
    """Make a dataset of a shape in an HDF5 file and return its identifier."""
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


def reserve(descriptor: int, start: int, end: int) -> None:
    """See to it that there is room on the disk for a stretch of a file.

    Raises
    ------
    OSError
        If there is none. File systems that know no reservation are taken at their word later.
    """
    try:
        if end > start:
            os.posix_fallocate(descriptor, start, end - start)
    except OSError as error:
        if error.errno not in _CANNOT_RESERVE:
            raise


def bytes_of(array: Array) -> memoryview:
    """Return the bytes of an array in C order."""
    return np.ravel(array).view(np.uint8).data


def put(descriptor: int, data: memoryview, place: int) -> None:
    """Write all of the data to a place of a file.

    Raises
    ------
    OSError
        If that is not possible.
    """
    while data:
        count = os.pwrite(descriptor, data, place)
        data, place = data[count:], place + count
