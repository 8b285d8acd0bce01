"""Reader of PLY, the surfaces of scanners: text or binary, with any names of types and lists."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import IO, Any, NamedTuple

import numpy as np

from pgimp.geometry.mesh.surfaces import Faces, Read

#: Types of numbers in PLY, as NumPy names them.
_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
    "int64": "i8",
    "uint64": "u8",
}
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_LISTS = ("vertex_indices", "vertex_index")

Columns = dict[str, Sequence[Any] | np.ndarray]


class _Element(NamedTuple):
    """An element: name, number of rows, and properties (name, type, type of a list's length)."""

    name: str
    rows: int
    properties: list[tuple[str, str, str]]


def read_ply(name: str) -> Read:
    """Read points, faces and edges.

    Raises
    ------
    ValueError
        With what is wrong in the file.
    """
    with open(name, "rb") as file:
        order, elements = _header(file)
        rest = file.read()
    read = _text(rest) if order == "" else _binary(rest, order)
    points, faces = np.zeros((0, 3)), Faces()
    for element in elements:
        names = [each for each, _, _ in element.properties]
        columns = read(element)
        if element.name == "vertex":
            axes = [axis for axis in "xyz" if axis in names]
            points = np.array([columns[axis] for axis in axes], float).T
        elif element.name == "face":
            key = next((each for each in _LISTS if each in names), None)
            if key is None:
                raise ValueError(f"its faces have no list {' or '.join(_LISTS)}")
            for corners in columns[key]:
                faces.add([int(k) for k in corners])
        elif element.name == "edge" and {"vertex1", "vertex2"} <= {*names}:
            for ends in zip(columns["vertex1"], columns["vertex2"], strict=True):
                faces.add([int(k) for k in ends])
        elif element.name == "tristrips":
            raise ValueError("it has strips of triangles; export it with triangles")
    return faces.read(points)


def _header(file: IO[bytes]) -> tuple[str, list[_Element]]:
    """Byte order, empty for text, and the elements."""
    order, elements = None, list[_Element]()
    if file.readline(80).strip() != b"ply":
        raise ValueError("it does not begin with the line 'ply'")
    while (line := file.readline(10_000)).strip() != b"end_header":
        words = line.decode("ascii", "replace").split()
        if not line:
            raise ValueError("it has no end_header")
        try:
            if words[:1] == ["format"]:
                order = _FORMATS[words[1]]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2]), []))
            elif words[:2] == ["property", "list"]:
                entry = words[4], _TYPES[words[3]], _TYPES[words[2]]
                elements[-1].properties.append(entry)
            elif words[:1] == ["property"]:
                elements[-1].properties.append((words[2], _TYPES[words[1]], ""))
        except (KeyError, IndexError, ValueError):
            raise ValueError(f"its header has '{' '.join(words)[:80]}'") from None
    if order is None:
        raise ValueError("its header has no format")
    return order, elements


def _text(data: bytes) -> Callable[[_Element], Columns]:
    """Return a function that reads the next element from text."""
    words = iter(data.split())

    def read(element: _Element) -> Columns:
        columns: dict[str, list[Any]] = {name: [] for name, _, _ in element.properties}
        try:
            for _ in range(element.rows):
                for name, _, length in element.properties:
                    if length:
                        number = int(next(words))
                        columns[name].append([float(next(words)) for _ in range(number)])
                    else:
                        columns[name].append(float(next(words)))
        except (StopIteration, RuntimeError):
            raise ValueError(_SHORT.format(element.rows, element.name)) from None
        return dict(columns)

    return read


_SHORT = "its header promises more than the file can hold: {:,} of '{}'"


def _binary(data: bytes, order: str) -> Callable[[_Element], Columns]:
    """Return a function that reads the next element from binary data."""
    at = 0

    def take(kind: np.dtype, count: int, element: _Element) -> np.ndarray:
        nonlocal at
        if at + count * kind.itemsize > len(data):
            raise ValueError(_SHORT.format(element.rows, element.name))
        found = np.frombuffer(data, kind, count, at)
        at += count * kind.itemsize
        return found

    def read(element: _Element) -> Columns:
        nonlocal at
        begin, sizes = at, dict.fromkeys((name for name, _, _ in element.properties), 0)
        if element.rows and any(length for _, _, length in element.properties):
            # As the first row is, most files are; where another has more or fewer, row by row.
            for name, kind, length in element.properties:
                if length:
                    sizes[name] = int(take(np.dtype(order + length), 1, element)[0])
                take(np.dtype(order + kind), sizes[name] if length else 1, element)
        at = begin
        fields: list[Any] = []
        for name, kind, length in element.properties:
            if length:
                fields += [(f"length of {name}", order + length)]
                fields += [(name, order + kind, (sizes[name],))]
            else:
                fields += [(name, order + kind)]
        row = np.dtype(fields)
        if at + element.rows * row.itemsize <= len(data):
            rows = take(row, element.rows, element)
            same = [
                bool((rows[f"length of {name}"] == sizes[name]).all())
                for name, _, length in element.properties
                if length
            ]
            if all(same):
                return {name: rows[name] for name in sizes}
        at = begin
        columns: dict[str, list[Any]] = {name: [] for name in sizes}
        for _ in range(element.rows):
            for name, kind, length in element.properties:
                number = int(take(np.dtype(order + length), 1, element)[0]) if length else 1
                values = take(np.dtype(order + kind), number, element)
                columns[name].append(values if length else values[0])
        return dict(columns)

    return read
