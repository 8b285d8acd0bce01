"""Writing a checkpoint: reserve the space, write, read back, and only then the header and name."""

from __future__ import annotations

import os
import zlib
from collections.abc import Mapping
from contextlib import suppress
from itertools import accumulate, chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pgimp.errors import DamagedError, RunError
from pgimp.output.checkpointheader import KINDS, encode, parse
from pgimp.output.collective import agree, explain, on_root
from pgimp.output.datasets import Dataset, create
from pgimp.output.files import publish, temporary
from pgimp.output.framefile import FrameFile, Written, checksum_of

Array = np.ndarray

# A piece with a checksum of its own: what is read at once, more in files of many of them.
_PIECE = 4 << 20
_PIECES = 4096
# More characters than the header needs for a number that is not known yet, and for a piece.
_NUMBER, _PIECE_TEXT = 20, 48


class _Blocks(NamedTuple):
    comm: Any
    bounds: list[int]


def write(
    path: Path,
    comm: Any,
    about: dict[str, Any],
    rows: Mapping[str, Array],
    whole: Mapping[str, Array],
) -> None:
    """Write a checkpoint; collective.

    Parameters
    ----------
    path : Path
        The file; replaced if there.
    comm : communicator
        Of all ranks.
    about : dict
        Anything that JSON can say; of use on rank 0.
    rows : mapping of str to ndarray, shape (n, ...)
        This rank's block of each dataset of rows; the ranks' blocks lie one after the other. The
        same names, types and shapes of a row on every rank; n may be 0. Each is asked for twice,
        for its shape and when its turn comes, so it may be made on asking.
    whole : mapping of str to ndarray
        Further datasets, small ones; of use on rank 0.

    Raises
    ------
    RunError
        On every rank, if it could not be written whole; then there is no file of this name but an
        older one, as it was.
    """
    what = f"write the checkpoint {path}"
    part = temporary(path)
    lengths: set[int] = set()
    shapes = {}
    cause = None
    try:
        for name in rows:
            array = rows[name]
            lengths.add(len(array))
            shapes[name] = (_little(array).str, array.shape[1:])
            del array
    except MemoryError:
        cause = "out of memory"
    agree(comm, what, cause)
    told = comm.allgather((list(lengths or {0}), shapes))
    if any(len(some) > 1 or others != shapes for some, others in told):
        raise RunError(f"cannot {what}: the arrays of its ranks do not fit each other")
    shapes = told[0][1]  # in the same order on every rank
    share = _Blocks(comm, [0, *accumulate(some[0] for some, _ in told)])
    plan = _Plan(part, about, shapes, share)
    try:
        offsets = on_root(comm, lambda: plan.create(whole, what))
        file = FrameFile(part, share, offsets, plan.most)
        agree(comm, what, file.error)
        for name in shapes:
            try:
                block = np.asarray(rows[name], shapes[name][0], order="C")
            except MemoryError:
                file.error = file.error or "out of memory"
            if any(comm.allgather(file.error)):
                break
            file.write(name, block)
            del block
        file.close()
        agree(comm, what, file.error)
        if comm.rank == 0:
            file.written += plan.written
        agree(comm, what, file.check())
        written = comm.gather(file.written)
        on_root(comm, lambda: plan.finish(path, written, what))
    except BaseException:
        if comm.rank == 0:
            with suppress(OSError):
                part.unlink(missing_ok=True)
        raise


def _little(array: Array) -> np.dtype:
    return array.dtype.newbyteorder("<")


class _Plan:
    """What rank 0 does: makes the file and, when all have written to it, header and name.

    Attributes
    ----------
    most : int
        Longest piece of the rows.
    written : list of Written
        The whole datasets.
    """

    def __init__(
        self,
        part: Path,
        about: dict[str, Any],
        shapes: dict[str, tuple[str, tuple[int, ...]]],
        share: _Blocks,
    ) -> None:
        self.part = part
        self.ranks = share.comm.size
        self.datasets = [Dataset(name, dtype, tail) for name, (dtype, tail) in shapes.items()]
        self.count = share.bounds[-1]
        self.row_bytes = sum(dataset.row_bytes for dataset in self.datasets)
        self.most = max(_PIECE, self.count * self.row_bytes // _PIECES)
        self.written: list[Written] = []
        places = {d.name: {"dtype": d.dtype, "shape": d.tail, "offset": 0} for d in self.datasets}
        self.content: dict[str, Any] = {
            "size": 0,
            "count": self.count,
            "about": about,
            "rows": places,
        }

    def create(self, whole: Mapping[str, Array], what: str) -> dict[str, int]:
        """Make the file, with the whole datasets in it; return where each dataset begins."""
        arrays = {name: np.asarray(a, _little(a), order="C") for name, a in whole.items()}
        places = {
            name: {"dtype": array.dtype.str, "shape": array.shape, "offset": 0}
            for name, array in arrays.items()
        }
        self.content |= {"whole": places, "pieces": []}
        places = self.content["rows"] | places
        # Two neighbours are together longer than the longest piece, but at the end of a block.
        pieces = 2 * (self.count * self.row_bytes // self.most + len(places) + 1)
        pieces += self.ranks * len(self.datasets)
        try:
            for place in places.values():
                if place["dtype"] not in KINDS:
                    raise ValueError(f"no checkpoint holds numbers of type {place['dtype']}")
            room = len(encode(self.content)) + _NUMBER * (len(places) + 2) + _PIECE_TEXT * pieces
            self.begin = max(512, 1 << (room - 1).bit_length())
            offsets = create(
                self.part, self.datasets, self.count, whole=arrays, user_block=self.begin
            )
        except OSError as error:
            raise RunError(f"cannot {what}: {explain(error)}") from error
        except (ValueError, TypeError, RuntimeError) as error:
            raise RunError(f"cannot {what}: {error}") from error
        for name, place in places.items():
            place["offset"] = offsets[name]
        for name, array in arrays.items():
            if array.size:
                checksum = zlib.crc32(np.ravel(array).view(np.uint8).data)
                self.written.append(Written(offsets[name], array.nbytes, checksum))
        return offsets

    def finish(self, path: Path, written: list[list[Written]], what: str) -> None:
        """Write the header, with the checksums of what the ranks wrote, and name the file."""
        try:
            with open(self.part, "r+b") as stream:
                size = stream.seek(0, os.SEEK_END)
                pieces: list[list[int]] = []
                end = self.begin
                for piece in [*sorted(chain(*written)), Written(size, 0, 0)]:
                    if (gap := piece.start - end) > 0:  # what HDF5 says about the datasets
                        stream.seek(end)
                        pieces.append([end, gap, checksum_of(stream, gap)])
                    if piece.size:
                        pieces.append(list(piece))
                    end = piece.start + piece.size
                header = encode(self.content | {"size": size, "pieces": pieces})
                parse(lambda start, length: header[start : start + length], size)
                stream.seek(0)
                stream.write(header)
            publish(self.part, path)
        except OSError as error:
            raise RunError(f"cannot {what}: {explain(error)}") from error
        except DamagedError as error:
            raise RunError(f"cannot {what}: {error}") from error
