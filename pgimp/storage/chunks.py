"""Compressed datasets: every rank compresses its rows and writes them to their offset in HDF5.

A dataset is cut into chunks by row number, not by rank. The chunks are in the order of datasets and
rows, so the file is the same for any number of ranks. No data pass through rank 0 or the HDF5
library; both only get the lengths of the chunks.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pgimp.storage.datasets import Dataset, make, reserve
from pgimp.storage.hdf5 import load_h5py, open_file
from pgimp.storage.image import Image

Array = np.ndarray

#: Rows of a chunk: below HDF5's cache of 1 MB for every field but the deformation.
ROWS = 1 << 14
# Higher levels do not pay: level 4 makes frames of particles 1 % smaller, in 20 % more time.
_LEVEL = 1
# Bytes for HDF5's list of the chunks: in total, and per chunk.
_HEADERS, _ENTRY = 1 << 16, 256


def compress(block: Array, rows: int) -> bytes:
    """Compress a chunk like HDF5's filters shuffle and deflate (gzip).

    Parameters
    ----------
    block : ndarray, shape (n, ...)
        Rows of the chunk, in C order.
    rows : int
        Rows of a chunk; if there are fewer, zeros follow.

    Returns
    -------
    bytes
        The bytes in the file.
    """
    size = block.dtype.itemsize
    items = rows * (block.size // len(block))
    # Shuffled: the first bytes of all numbers, then the second ones, which are similar.
    planes = np.zeros((size, items), np.uint8)
    planes[:, : block.size] = np.ravel(block).view(np.uint8).reshape(-1, size).T
    return zlib.compress(planes.data, _LEVEL)


class Chunks:
    """A file of compressed datasets, laid out by rank 0 as the lengths of chunks become known.

    Parameters
    ----------
    path : Path
        The file; replaced if it exists.
    datasets : list of Dataset
        Datasets of the file, in the order of their chunks.
    count : int
        Rows of each dataset, at least one.
    attributes : mapping
        Attributes of the file's root.

    Raises
    ------
    OSError
        If the file cannot be created; the methods raise it likewise.
    """

    def __init__(
        self, path: Path, datasets: list[Dataset], count: int, attributes: Mapping[str, object]
    ) -> None:
        h5py = load_h5py()
        self._image = Image()
        self._rows = chunk_rows(count)
        self._reserved = 0
        self._descriptor = os.open(
            path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666
        )
        self._file = open_file(self._image, "w")
        self._file.attrs.update(attributes)
        self._made = {}
        for dataset in datasets:
            properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            properties.set_chunk((self._rows, *dataset.tail))
            properties.set_shuffle()
            properties.set_deflate(_LEVEL)
            properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
            properties.set_obj_track_times(False)
            shape = (count, *dataset.tail)
            self._made[dataset.name] = (make(self._file, dataset, shape, properties), len(shape))

    def place(self, name: str, sizes: Array) -> Array:
        """Assign offsets to the chunks of a dataset, and reserve their space on the disk.

        Parameters
        ----------
        name : str
            The dataset.
        sizes : ndarray of int64, shape (chunks,)
            Bytes of each chunk.

        Returns
        -------
        ndarray of int64, shape (chunks,)
            Offset of each chunk.
        """
        made, dimensions = self._made[name]
        places = np.empty_like(sizes)
        nothing = bytes(int(sizes.max(initial=0)))
        for chunk, size in enumerate(sizes.tolist()):
            before = set(self._image.parts)
            made.write_direct_chunk((chunk * self._rows, *[0] * (dimensions - 1)), nothing[:size])
            # HDF5 may write some of its own metadata at the same time.
            places[chunk], _ = key = next(
                key
                for key in self._image.parts.keys() - before
                if key[1] == size and self._image.parts[key] == nothing[:size]
            )
            del self._image.parts[key]
        self._reserve(self._image.size + _HEADERS + _ENTRY * len(sizes))
        return places

    def _reserve(self, end: int) -> None:
        reserve(self._descriptor, self._reserved, end, keep_size=True)
        self._reserved = max(self._reserved, end)

    def finish(self, more: Callable[[Any], None]) -> dict[int, bytes]:
        """Set the file's size and close it; return HDF5's metadata of the datasets, by offset.

        First, `more` adds what else the file has, as for `pgimp.storage.datasets.lay_out`.
        """
        more(self._file)
        self._file.close()
        self._reserve(self._image.size)
        os.ftruncate(self._descriptor, self._image.size)
        # Truncating frees reserved space beyond the size, even if the size is right already.
        os.ftruncate(self._descriptor, self._image.size)
        self.close()
        return self._image.stretches()

    def close(self) -> None:
        """Close the file, finished or not."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
        self._file.close()


def chunk_rows(count: int) -> int:
    """Rows of a chunk in a dataset of `count` rows; HDF5 allows no longer chunk."""
    return min(ROWS, count)
