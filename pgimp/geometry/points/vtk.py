"""Particles from VTK's XML files: points with data, of grids (.vtu) or polygons (.vtp).

Cells do not matter. Names of arrays are those of a CSV file's groups; plurals of other codes are
taken too. meshio reads no .vtp, and of .vtu not all that ParaView writes.
"""

from __future__ import annotations

import base64
import lzma
import re
import zlib
from collections.abc import Iterator
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from pgimp.errors import CaseError
from pgimp.geometry.points.block import BLOCK, Block, States
from pgimp.geometry.points.hdf5 import _kinds, _rows
from pgimp.schema.messages import shorten
from pgimp.storage.plain import open_plain

_KINDS = ("UnstructuredGrid", "PolyData")
_TYPES = {f"Float{8 * n}": f"f{n}" for n in (4, 8)}
_TYPES |= {f"{sign}Int{8 * n}": f"{sign or 'i'}{n}".lower() for n in (1, 2, 4, 8)
           for sign in ("", "U")}  # fmt: skip

#: Names that other codes give.
_ALIASES = {
    **dict.fromkeys(("velocities", "vel"), "velocity"),
    **dict.fromkeys(("volumes", "vol"), "volume"),
    **dict.fromkeys(("stresses", "sigma"), "stress"),
}

#: Arrays that tell a frame of pgimp.
_OWN = {"id", "body", "material", "radius"}

#: Components of a symmetric tensor in one with nine.
_SYMMETRIC, _OTHER = [0, 4, 8, 1, 5, 2], [0, 4, 8, 3, 7, 6]


class _File(NamedTuple):
    """What arrays need of their file: byte order, type of headers, compressor, appended data."""

    order: str
    header: np.dtype
    compressor: str
    appended: bytes
    encoded: bool


def read_vtk(name: str, D: int, most: int | None, states: States) -> Iterator[Block]:
    """Yield the particles of a file; see `pgimp.geometry.points.file.blocks`."""
    root, file = _open(name)
    kinds, own = _kinds(D, states), _kinds(D, {})
    parts: list[dict[str, np.ndarray]] = []
    for piece in root.iter("Piece"):
        count = int(piece.get("NumberOfPoints", ""))
        if most is not None and count > most:
            raise CaseError(
                f"it claims {count:,} particles, but the memory that is here holds {most:,} at most"
            )
        if count == 0:
            continue
        found = {}
        for array in piece.iterfind("PointData/DataArray"):
            key = array.get("Name", "").lower().replace("_", "-").replace(" ", "-")
            key = _ALIASES.get(key, key)
            found[key] = array
        if found.keys() >= _OWN:
            raise CaseError(
                "it is an exported frame of pgimp; take the frame itself, frames/particles-....h5, "
                "which has the state of its particles"
            )
        if "volume" not in found:
            there = ", ".join(shorten(key, 40) for key in [*found][:20])
            raise CaseError(f"its points have no array 'volume'; there are: {there or 'none'}")
        arrays = {key: _values(array, count, file) for key, array in found.items() if key in kinds}
        points = piece.find("Points/DataArray")
        if points is None:
            raise CaseError("it has a piece without points")
        arrays["position"] = _values(points, count, file)
        if (stress := arrays.get("stress")) is not None and stress.shape[1] == 9:
            slack = 1e-6 * np.abs(stress).max()
            if (np.abs(stress[:, _SYMMETRIC] - stress[:, _OTHER]) > slack).any():
                raise CaseError("its stress is not symmetric")
            arrays["stress"] = stress[:, _SYMMETRIC]
        parts.append(arrays)
    first = 0
    for arrays in parts:
        if arrays.keys() != parts[0].keys():
            raise CaseError("its pieces have different arrays")
        for key, values in arrays.items():
            shapes = {int(np.prod(shape)) for shape in kinds[key].shapes}
            if values.shape[1] not in shapes:
                wanted = " or ".join(map(str, sorted(shapes)))
                raise CaseError(f"'{key}' has {values.shape[1]} components, expected {wanted}")
        for begin in range(0, len(arrays["position"]), BLOCK):
            rows = {
                key: _rows(values[begin : begin + BLOCK], key, kinds[key], first + begin, D)
                for key, values in arrays.items()
            }
            needed = rows["position"], rows["volume"].reshape(-1)
            given = rows.get("velocity"), rows.get("stress"), rows.get("velocity-gradient")
            state = {key: rows[key] for key in states if key in rows and key not in own}
            at = first + begin
            yield Block(at, *needed, *given, state, lambda row, k=at: f"point {k + row} (from 0)")
        first += len(arrays["position"])


def _open(name: str) -> tuple[Any, _File]:
    """Parse the XML, and set appended data aside, which need not be XML."""
    with open_plain(name) as stream:
        data = stream.read()
    xml, appended, encoded = data, b"", False
    if found := re.search(rb"<AppendedData([^>]*)>\s*_", data):
        xml, appended = data[: found.start()] + b"</VTKFile>", data[found.end() :]
        encoded = b"base64" in found[1]
    try:
        root = ElementTree.fromstring(xml)
    except ElementTree.ParseError as error:
        raise CaseError(f"it is no XML of VTK: {error}") from None
    if root.tag != "VTKFile" or root.get("type") not in _KINDS:
        kind = shorten(str(root.get("type", root.tag)))
        raise CaseError(f"it is of the type {kind}, expected {' or '.join(_KINDS)}")
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    header = np.dtype(order + _TYPES[root.get("header_type", "UInt32")])
    return root, _File(order, header, root.get("compressor", ""), appended, encoded)


def _values(array: Any, count: int, file: _File) -> np.ndarray:
    """Numbers of an array, (count, components)."""
    kind, form = array.get("type", ""), array.get("format", "ascii")
    width = int(array.get("NumberOfComponents") or 1)
    what = f"the array '{shorten(array.get('Name') or 'points', 40)}'"
    if kind not in _TYPES:
        raise CaseError(f"{what} is of the type {shorten(kind)}, no numbers")
    dtype = np.dtype(file.order + _TYPES[kind])
    if form == "ascii":
        found = np.array((array.text or "").split(), float)
    else:
        text = (array.text or "").strip().encode()
        source, encoded = text, True
        if form == "appended":
            source, encoded = file.appended[int(array.get("offset", "")) :], file.encoded
        size = count * width * dtype.itemsize
        found = np.frombuffer(_bytes(_Source(source, encoded), size, file), dtype)
    if len(found) != count * width:
        raise CaseError(f"{what} has {len(found):,} numbers, expected {count:,} x {width}")
    return np.asarray(found, float).reshape(count, width)


class _Source:
    """Bytes, or base64 text, from which runs are taken."""

    def __init__(self, data: bytes, encoded: bool) -> None:
        self.data, self.encoded, self.at = data, encoded, 0

    def take(self, size: int) -> bytes:
        """Take a run of bytes; each run is encoded on its own."""
        length = -(-size // 3) * 4 if self.encoded else size
        part = self.data[self.at : self.at + length]
        self.at += length
        return base64.b64decode(part)[:size] if self.encoded else part


def _bytes(source: _Source, size: int, file: _File) -> bytes:
    """Bytes of an array of this size, decoded and decompressed."""
    width = file.header.itemsize
    head = source.take(width)
    if len(head) < width:
        return b""
    number = int(np.frombuffer(head, file.header)[0])
    if not file.compressor:
        if source.encoded and source.data[source.at - 1 : source.at] != b"=":
            source.at = 0  # one run with the header
            return source.take(width + min(number, size))[width:]
        return source.take(min(number, size))
    if file.compressor not in ("vtkZLibDataCompressor", "vtkLZMADataCompressor"):
        raise CaseError(f"it is compressed by {shorten(file.compressor)}; write it with ZLib")
    if number * width > len(source.data):
        raise CaseError("a header promises more than the file can hold")
    source.at = 0
    header = np.frombuffer(source.take((3 + number) * width), file.header)[3:]
    packed, at, found = source.take(int(header.sum())), 0, []
    for length in header.tolist():
        part = packed[at : at + length]
        zipped = file.compressor == "vtkZLibDataCompressor"
        unpacker = zlib.decompressobj() if zipped else lzma.LZMADecompressor()
        try:
            found.append(unpacker.decompress(part, size))
        except (zlib.error, lzma.LZMAError):
            raise CaseError("its compressed data are damaged") from None
        at += length
    return b"".join(found)
