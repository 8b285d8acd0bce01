"""The group ``/VTKHDF`` of a frame, by which VTK and ParaView read its own datasets.

The group has hard links to the frame's datasets, and the cells as VTK counts them. Nothing is
copied. Single frames have version 1.0 of the format, which VTK from 9.1 on (ParaView 5.10) reads.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from pgimp.io.results.frame import cell_fields
from pgimp.storage.chunks import compress
from pgimp.storage.hdf5 import load_h5py

Array = np.ndarray

ROOT = "VTKHDF"
#: Particles of a part, in ascending id. Readers share whole parts among their processes.
PART = 1 << 17
# VTK's number of the cell with so many vertices: vertex, line, quadrilateral, hexahedron.
_CELLS = {1: 1, 2: 3, 4: 9, 8: 12}
# A chunked dataset costs 2 kB besides its data.
_SMALL = 2048


def add_group(file: Any) -> None:
    """Add the group to a frame.

    Parameters
    ----------
    file : h5py.File
        The frame, open for writing, with all its datasets; their values need not be there yet.
    """
    position, connectivity = file["position"], file["connectivity"]
    names = [name for name in file if name not in ("position", "connectivity")]
    cells, nodes = len(connectivity), 1 if connectivity.ndim == 1 else connectivity.shape[1]
    cut = "id" in names
    parts = cut_in_parts(cells) if cut else [cells]
    group = begin(file, (1, 0))
    small(group, "NumberOfCells", parts)
    if cut:
        group["NumberOfPoints"] = group["NumberOfConnectivityIds"] = group["NumberOfCells"]
    else:
        small(group, "NumberOfPoints", [len(position)])
        small(group, "NumberOfConnectivityIds", [nodes * cells])
    group["Points"] = position
    if connectivity.ndim == 1 and len(parts) == 1:
        group["Connectivity"] = connectivity
    elif cut:
        repeated(group, "Connectivity", PART, 1, cells)
    else:
        views = Views(group, "Connectivity", cells * nodes, np.dtype("<i8"))
        views.add(0, cells * nodes, b".", b"/connectivity", connectivity.shape)
        views.create()
    repeated(group, "Offsets", max(parts) + 1, nodes, cells + len(parts))
    cell_types(group, cells, nodes)
    of_cells = cell_fields(file.attrs)
    data = {False: group.create_group("PointData")}
    if of_cells:
        data[True] = group.create_group("CellData")
    for name in names:
        data[name in of_cells][name] = file[name]


def cut_in_parts(count: int) -> list[int]:
    """Return the number of particles in each part, all but the last of the same size."""
    return [min(PART, count - begin) for begin in range(0, max(count, 1), PART)]


def begin(file: Any, version: tuple[int, int]) -> Any:
    """Create the group, of a version of the format, and return it."""
    kind = np.bytes_("UnstructuredGrid")
    group = file.create_group(ROOT, track_order=True)  # a compact group of HDF5 1.8
    group.attrs["Version"] = np.array(version, "<i8")
    group.attrs.create("Type", kind, dtype=load_h5py().string_dtype("ascii", len(kind)))
    return group


def small(group: Any, name: str, values: Sequence[float] | Array, dtype: str = "<i8") -> None:
    """Create a dataset of a few values, within its header if they fit there."""
    array = np.ascontiguousarray(values, dtype)
    fits = array.nbytes <= _SMALL
    made = _make(group, name, array.shape, array.dtype, _properties(compact=fits))
    everything = load_h5py().h5s.ALL
    made.id.write(everything, everything, array)


def cell_types(group: Any, count: int, nodes: int) -> None:
    """Create the types of the cells, all the same: a fill value that takes no space."""
    made = _properties(compact=False)
    made.set_alloc_time(load_h5py().h5d.ALLOC_TIME_LATE)
    made.set_fill_value(np.array(_CELLS[nodes], np.uint8))
    _make(group, "Types", (count,), np.dtype(np.uint8), made)


def repeated(group: Any, name: str, period: int, step: int, length: int) -> None:
    """Create a dataset of multiples of `step` from 0 on, again after each `period` of them."""
    h5py = load_h5py()
    if 8 * length <= _SMALL:
        small(group, name, step * (np.arange(length) % period))
        return
    rows = min(period, length)
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_chunk((rows,))
    made.set_shuffle()
    made.set_deflate(1)
    made.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    made.set_obj_track_times(False)
    dataset, chunk = _make(group, name, (length,), np.dtype("<i8"), made).id, _chunk(rows, step)
    for first in range(0, length, rows):
        dataset.write_direct_chunk((first,), chunk)


@lru_cache(maxsize=4)
def _chunk(rows: int, step: int) -> bytes:
    return compress(np.arange(0, rows * step, step, dtype="<i8"), rows)


class Views:
    """A dataset of rows of other datasets; rows without any have the fill value.

    Parameters
    ----------
    group : h5py.Group
        The group for it.
    name : str
        Its name.
    length : int
        Number of its rows.
    dtype : dtype
        Type of its values; those of the other datasets are converted.
    columns : int
        Number of columns; 0 for scalars.
    fill : float
        The fill value.
    """

    def __init__(
        self, group: Any, name: str, length: int, dtype: Any, columns: int = 0, fill: float = 0
    ) -> None:
        self._group, self._name, self._dtype = group, name, np.dtype(dtype)
        self._shape = (length, columns) if columns else (length,)
        h5py = load_h5py()
        self._made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        self._made.set_obj_track_times(False)
        self._made.set_fill_value(np.array(fill, self._dtype))
        self._space = h5py.h5s.create_simple(self._shape)
        self._any = False

    def add(self, first: int, count: int, file: bytes, name: bytes, shape: tuple[int, ...]) -> None:
        """Show a whole dataset, of `shape`, in `count` rows from `first` on."""
        if not count:
            return
        self._any = True
        tail = len(self._shape) - 1
        self._space.select_hyperslab((first, *[0] * tail), (count, *self._shape[1:]))
        whole = load_h5py().h5s.create_simple(shape)
        self._made.set_virtual(self._space, file, name, whole)

    def create(self) -> None:
        """Create the dataset."""
        made = self._made
        if not self._any:
            made.set_layout(load_h5py().h5d.CONTIGUOUS)
            made.set_alloc_time(load_h5py().h5d.ALLOC_TIME_LATE)
        _make(self._group, self._name, self._shape, self._dtype, made)


def _properties(compact: bool) -> Any:
    h5py = load_h5py()
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_layout(h5py.h5d.COMPACT if compact else h5py.h5d.CONTIGUOUS)
    made.set_obj_track_times(False)
    return made


def _make(group: Any, name: str, shape: tuple[int, ...], dtype: Any, made: Any) -> Any:
    h5py = load_h5py()
    kind, space = h5py.h5t.py_create(np.dtype(dtype)), h5py.h5s.create_simple(shape)
    return h5py.Dataset(h5py.h5d.create(group.id, name.encode(), kind, space, made))
