"""The header of a checkpoint: layout of the file, with checksums of its whole content.

A file from elsewhere may be damaged or malicious, so its header is checked against the size of the
file before use.
"""

from __future__ import annotations

import json
import math
import re
import zlib
from collections.abc import Callable
from typing import Annotated, Literal, get_args

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError

from pgimp.errors import DamagedError

#: Version of the file's layout and content.
LAYOUT = 3

Kind = Literal["<f8", "<i8", "<i4"]
KINDS: tuple[str, ...] = get_args(Kind)

# Enough for checksums of 300,000 pieces; a text of this size takes less than 0.5 GB when read.
_LARGEST = 16 << 20
_DEEPEST = 32
_LINE = b"pgimp checkpoint, layout %d, header of %d bytes, CRC-32 %08x\n"
_PATTERN = re.compile(
    rb"pgimp checkpoint, layout ([1-9]\d{0,8}), header of ([1-9]\d{0,8}) bytes, "
    rb"CRC-32 ([\da-f]{8})\n"
)
# The first line is no longer than this.
_LINE_BYTES = 128

_Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9._-]{0,99}$")]
_Size = Annotated[int, Field(ge=0, lt=2**63)]
_MODEL = ConfigDict(strict=True, extra="forbid", frozen=True)


class Place(BaseModel):
    """A dataset: its type, the shape of a row or of the whole, and its offset in the file."""

    model_config = _MODEL

    dtype: Kind
    shape: Annotated[list[_Size], Field(max_length=8)]
    offset: _Size

    def extent(self, count: int | None = None) -> int:
        """Size of the dataset in bytes, with `count` rows or whole."""
        items = math.prod(self.shape) * (1 if count is None else count)
        return items * np.dtype(self.dtype).itemsize


class Header(BaseModel):
    """The content of the JSON text."""

    model_config = _MODEL

    size: _Size  #: int: Bytes of the file.
    count: _Size  #: int: Rows of each dataset in `rows`.
    about: dict[str, object]  #: The run's own data.
    #: rows, whole: dict of str to Place: Datasets with a row for each particle, and others.
    rows: dict[_Name, Place]
    whole: dict[_Name, Place]
    #: list of [start, size, CRC-32]: In order and without gaps, from the end of the user block to
    #: the end of the file.
    pieces: list[Annotated[list[_Size], Field(min_length=3, max_length=3)]]

    @property
    def begin(self) -> int:
        """End of the user block."""
        return self.pieces[0][0]


def encode(content: dict[str, object]) -> bytes:
    """Return the first line and the JSON text with the fields of a `Header`.

    Raises
    ------
    ValueError, TypeError
        If a value has no JSON form.
    """
    text = _dump(content)
    return _LINE % (LAYOUT, len(text), zlib.crc32(text)) + text


def _dump(content: object) -> bytes:
    return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def parse(read: Callable[[int, int], bytes], size: int) -> tuple[Header, int]:
    """Read the header of a file and check it against the file.

    Parameters
    ----------
    read : callable
        ``read(start, length)`` returns `length` bytes of the file, fewer at its end.
    size : int
        Bytes of the file.

    Returns
    -------
    header : Header
        The header.
    length : int
        Size of the header in bytes, at the beginning of the file.

    Raises
    ------
    DamagedError
        If the file is no checkpoint, or has another layout. Or if the header is not pgimp's, or
        belongs to a file of another size.
    """
    if size == 0:
        raise DamagedError("it is empty")
    found = _PATTERN.match(read(0, _LINE_BYTES))
    if found is None:
        raise DamagedError("it does not begin like a checkpoint of pgimp")
    layout, length = int(found[1]), int(found[2])
    if layout != LAYOUT:
        raise DamagedError(f"it has layout {layout}, and this version of pgimp reads {LAYOUT}")
    if length > _LARGEST:
        raise DamagedError(f"its header claims {length} bytes; {_LARGEST} is the most there can be")
    text = read(found.end(), length)
    if len(text) < length or zlib.crc32(text) != int(found[3], 16):
        raise DamagedError("its header does not have its checksum")
    header = _decode(text)
    if header.size != size:
        raise DamagedError(f"it has {size} bytes, not the {header.size} that were written")
    _check_pieces(header, found.end() + length)
    _check_places(header)
    return header, found.end() + length


def _decode(text: bytes) -> Header:
    try:
        tree = json.loads(text)
        _check_depth(tree)
        # Rules out duplicate keys, NaN and text that is no Unicode.
        if _dump(tree) != text:
            raise DamagedError("its header is not written as pgimp writes it")
        return Header.model_validate(tree)
    except ValidationError as error:  # which is a ValueError
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(ascii(part).strip("'")[:40] for part in first["loc"][:3])
        raise DamagedError(f"its header is wrong at {where or 'its top'}: {first['msg']}") from None
    except (ValueError, RecursionError):
        raise DamagedError("its header cannot be read as JSON") from None


def _check_depth(tree: object) -> None:
    level = [tree]
    for _ in range(_DEEPEST):
        inner: list[object] = []
        for node in level:
            if isinstance(node, dict):
                inner += node.values()
            elif isinstance(node, list):
                inner += node
            elif isinstance(node, int) and not -(2**63) <= node < 2**63:
                raise DamagedError("its header has an integer that is too large")
        level = inner
        if not level:
            return
    raise DamagedError("its header is nested too deeply")


def _check_pieces(header: Header, length: int) -> None:
    end = header.begin if header.pieces else 0
    if end < max(length, 512) or end & (end - 1) or end > 4 * _LARGEST:
        raise DamagedError("its header does not say where the data begin")
    for start, size, checksum in header.pieces:
        if start != end or size == 0 or checksum >= 2**32:
            raise DamagedError("its checksums do not cover it piece by piece")
        end += size
    if end != header.size:
        raise DamagedError("its checksums do not cover it to its end")


def _check_places(header: Header) -> None:
    if header.rows.keys() & header.whole.keys() or header.count > header.size:
        raise DamagedError("its header contradicts itself")
    taken = []
    for places, count in ((header.rows, header.count), (header.whole, None)):
        for name, place in places.items():
            # Even if one length is 0, the others must fit into the file.
            most = math.prod(max(1, length) for length in (count or 1, *place.shape))
            extent = place.extent(count)
            if most > header.size or place.offset + extent > header.size:
                raise DamagedError(f"its header has {name} reach beyond the end of the file")
            if extent:
                taken.append((place.offset, place.offset + extent, name))
    last = header.begin
    for start, end, name in sorted(taken):
        if start < last:
            raise DamagedError(f"its header has {name} overlap with other data")
        last = end
