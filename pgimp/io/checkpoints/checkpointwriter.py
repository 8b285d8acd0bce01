"""Writing a checkpoint: reserve the space, write data and header, sync, and only then rename.

Every rank computes checksums of its data while writing. They are stored in the header, and
verified before the file is renamed and when the checkpoint is read.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from itertools import accumulate, chain, product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pgimp.errors import DamagedError, RunError, explain
from pgimp.io.checkpoints.checkpointheader import KINDS, encode, parse
from pgimp.mpi.collective import agree, on_root
from pgimp.mpi.communicator import Communicator
from pgimp.storage.atomic import publish, temporary
from pgimp.storage.checksums import Written
from pgimp.storage.datasets import Dataset, Layout, bytes_of, lay_out
from pgimp.storage.framefile import FrameFile, blocks
from pgimp.storage.unfinished import explained_errors, removed_on_error

Array = np.ndarray

# Bytes of a piece with a checksum of its own: the unit of reading, larger in large files.
_PIECE = 4 << 20
_PIECES = 4096
# More characters than the header needs for a number not yet known, and for a piece.
_NUMBER, _PIECE_TEXT = 20, 48
_NONE: Mapping[str, Array] = MappingProxyType({})


def write(
    path: Path,
    comm: Communicator,
    about: dict[str, object],
    rows: Mapping[str, Array],
    whole: Mapping[str, Array],
    order: Array | None = None,
    spread: Mapping[str, Array] = _NONE,
    at: Callable[[Array], Mapping[str, Array]] | None = None,
    attributes: Mapping[str, object] = MappingProxyType({}),
) -> int:
    """Write a checkpoint; collective.

    Parameters
    ----------
    path : Path
        The file; replaced if it exists.
    about : dict
        Any data with a JSON form; used on rank 0.
    rows : mapping of str to ndarray, shape (n, ...)
        This rank's block of each dataset of rows; the ranks' blocks are stored consecutively.
        Names, types and row shapes are the same on every rank; n may be 0.
    whole : mapping of str to ndarray
        Further small datasets; used on rank 0.
    order : ndarray of int, optional
        Rows to write, in this order; by default all.
    spread : mapping of str to ndarray, shape (m, ...)
        This rank's block of further datasets of one length, which differs from the rows'. They are
        read like `whole`; a mapping without rows on any rank leaves them out.
    at : callable, optional
        Takes some of `order`; returns columns there in place of those of `rows`, until its next
        call.
    attributes : mapping
        Attributes of the HDF5 file's root, for other programs; used on rank 0.

    Returns
    -------
    int
        Bytes of the file, on rank 0.

    Raises
    ------
    RunError
        On every rank, if it could not be written completely; an older file of this name then stays
        unchanged.
    """
    what = f"write the checkpoint {path}"
    part = temporary(path)
    lengths = {len(array) for array in rows.values()} if order is None else {len(order)}
    shapes = {name: (_little(array).str, array.shape[1:]) for name, array in rows.items()}
    more = max((len(array) for array in spread.values()), default=0)
    told_of = comm.allgather((list(lengths or {0}), shapes, more))
    if any(len(some) > 1 or others != shapes for some, others, _ in told_of):
        raise RunError(f"cannot {what}: the arrays of its ranks do not fit each other")
    shapes = told_of[0][1]  # in the same order on every rank
    mores = [0, *accumulate(some[2] for some in told_of)]
    apart = [
        Dataset(name, _little(array).str, array.shape[1:])
        for name, array in (spread.items() if mores[-1] else ())
    ]
    bounds = [0, *accumulate(some[0][0] for some in told_of)]
    first, count = bounds[comm.rank], told_of[comm.rank][0][0]
    plan = _Plan(part, about, shapes, bounds, attributes)
    file = None
    with removed_on_error(part, comm):
        try:
            offsets = on_root(comm, lambda: plan.create(whole, apart, mores[-1], what))
            file = FrameFile(part, comm, plan.most)
            places = {
                name: offsets[name] + first * Dataset(name, dtype, tail).row_bytes
                for name, (dtype, tail) in shapes.items()
            }
            arrays, buffers = {name: rows[name] for name in shapes}, dict[str, Array]()
            # Columns that `at` finds are found together, others one after the other.
            together = [list(shapes)] if at else [[name] for name in shapes]
            for names, (begin, end) in product(together, list(blocks(count))):
                instead = at(order[begin:end]) if at and order is not None else _NONE
                for name in names:
                    block = instead[name] if name in instead else arrays[name][begin:end]
                    if order is not None and name not in instead:
                        # Reused memory: new pages would cost as much as the rest.
                        if name not in buffers:
                            buffers[name] = np.empty_like(block)
                        # Without "clip" NumPy would not use this buffer.
                        buffer = buffers[name][: end - begin]
                        block = arrays[name].take(order[begin:end], 0, buffer, "clip")
                    file.write(places[name], np.asarray(block, shapes[name][0], order="C"))
                    places[name] += block.nbytes
                if not at and end == count:
                    buffers.clear()
            for dataset in apart:
                place = offsets[dataset.name] + mores[comm.rank] * dataset.row_bytes
                for begin, end in blocks(more):
                    block = np.asarray(spread[dataset.name][begin:end], dataset.dtype, order="C")
                    file.write(place, block)
                    place += block.nbytes
            agree(comm, what, file.error)
            written = comm.gather(file.written)
            on_root(comm, lambda: plan.head(file, written, what))
            file.flush()
            file.close()
            agree(comm, what, file.error)
            file.verify()
            agree(comm, what, file.error)
            on_root(comm, lambda: plan.publish(path, what))
        finally:
            if file is not None:
                file.abandon()
    return plan.size


def _little(array: Array) -> np.dtype:
    return array.dtype.newbyteorder("<")


class _Plan:
    """Part of rank 0: creates the file; writes the header and renames when all have written.

    Attributes
    ----------
    most : int
        Longest piece of the rows.
    size : int
        Bytes of the file, once created.
    """

    def __init__(
        self,
        part: Path,
        about: dict[str, object],
        shapes: dict[str, tuple[str, tuple[int, ...]]],
        bounds: list[int],
        attributes: Mapping[str, object],
    ) -> None:
        self.part, self._attributes = part, attributes
        self.ranks = len(bounds) - 1
        self.datasets = [Dataset(name, dtype, tail) for name, (dtype, tail) in shapes.items()]
        self.count = bounds[-1]
        self.size = 0
        self.row_bytes = sum(dataset.row_bytes for dataset in self.datasets)
        self.most = max(_PIECE, self.count * self.row_bytes // _PIECES)
        self._layout, self._whole = Layout({}, {}, 0), dict[str, Array]()
        places = {d.name: {"dtype": d.dtype, "shape": d.tail, "offset": 0} for d in self.datasets}
        self.content: dict[str, Any] = {
            "size": 0,
            "count": self.count,
            "about": about,
            "rows": places,
        }

    def create(
        self, whole: Mapping[str, Array], apart: list[Dataset], length: int, what: str
    ) -> dict[str, int]:
        """Create the empty file; return the offset of each dataset.

        `apart` are datasets of a `length` of their own, of which each rank writes a part.
        """
        arrays = {name: np.asarray(a, _little(a), order="C") for name, a in whole.items()}
        self._whole = dict(arrays)
        for each in apart:  # without memory
            arrays[each.name] = np.broadcast_to(np.zeros((), each.dtype), (length, *each.tail))
        places = {
            name: {"dtype": array.dtype.str, "shape": array.shape, "offset": 0}
            for name, array in arrays.items()
        }
        self.content |= {"whole": places, "pieces": []}
        places = self.content["rows"] | places
        # Two neighbours are together longer than the longest piece, except at a block's end.
        pieces = 2 * (self.count * self.row_bytes // self.most + len(places) + 1)
        pieces += self.ranks * (len(self.datasets) + len(apart))
        pieces += 2 * sum(length * each.row_bytes for each in apart) // self.most
        try:
            for place in places.values():
                if place["dtype"] not in KINDS:
                    raise ValueError(f"no checkpoint holds numbers of type {place['dtype']}")
            most = len(encode(self.content)) + _NUMBER * (len(places) + 2) + _PIECE_TEXT * pieces
            self.begin = max(512, 1 << (most - 1).bit_length())
            layout = lay_out(
                self.datasets, self.count, self._attributes, arrays, user_block=self.begin
            )
            layout.create(self.part)
        except OSError as error:
            raise RunError(f"cannot {what}: {explain(error)}") from error
        except (ValueError, TypeError, RuntimeError) as error:
            raise RunError(f"cannot {what}: {error}") from error
        for name, place in places.items():
            place["offset"] = layout.offsets[name]
        self._layout, self.size = layout, layout.size
        return layout.offsets

    def head(self, file: FrameFile, written: list[list[Written]], what: str) -> None:
        """Write everything but the rows: the header has the checksums of the ranks' data."""
        offsets, says = self._layout.offsets, self._layout.parts
        whole = [
            Written(offsets[name], array.nbytes, zlib.crc32(bytes_of(array)))
            for name, array in self._whole.items()
            if array.size
        ]
        pieces: list[list[int]] = []
        end = self.begin
        for piece in [*sorted(chain(*written, whole)), Written(self.size, 0, 0)]:
            if piece.start > end:  # HDF5's metadata of the datasets
                between = bytearray(piece.start - end)
                for place, data in says.items():
                    if end <= place < piece.start:
                        between[place - end : place - end + len(data)] = data
                pieces.append([end, len(between), zlib.crc32(between)])
            if piece.size:
                pieces.append(list(piece))
            end = piece.start + piece.size
        try:
            header = encode(self.content | {"size": self.size, "pieces": pieces})
            parse(lambda start, length: header[start : start + length], self.size)
        except DamagedError as error:
            raise RunError(f"cannot {what}: {error}") from error
        file.write(0, header)
        for place, data in says.items():
            file.write(place, data)
        for name, array in self._whole.items():
            file.write(offsets[name], array)

    def publish(self, path: Path, what: str) -> None:
        """Rename the file, once it is completely on the disk."""
        with explained_errors(what):
            publish(self.part, path)
