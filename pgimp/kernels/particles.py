"""The particles of one rank, and the grid's frame: the data that all kernels share.

| symbol | array | shape | unit | source |
|---|---|---|---|---|
| x | position | (c, D) | length | (26) |
| v | velocity | (c, D) | length/time | (27), p_p/m_p |
| F | deformation gradient, row-major | (c, D*D) | 1 | |
| sigma | Cauchy stress xx yy zz [xy [yz xz]] | (c, 3, 4 or 6) | stress | (6) |
| V, V0 | volume in (16), initial volume | (c,) | volume | (3), (11) |
| m | mass | (c,) | mass | (4) |
| id | number by body, then by position | (c,) | | |
| cell | cell of the first vertex at the last re-sort | (c,) | | |
| layer | plane of the first vertex now | (c,) | | |
| body | body number | (c,) | | |
| origin | initial position | (c, D or 0) | length | |
| L | velocity gradient, row-major | (c, D*D or 0) | 1/time | (30) |
| q | viscous pressure | (c, 1 or 0) | stress | (45) |
| patch | area of each traction's patch | (c, T) | area | (18) |
| grip | number of the constraint that holds it, from 1; 0 is none | (c, 1 or 0) | | |

`c` is the capacity; what a scene does not use has no columns. Which rows are alive, and their
canonical order, is in `Population`; rows of particles that have left stay as holes until the next
re-sort.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.kernels.record import RECORD

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Columns = tuple[tuple[IntArray, ...], tuple[NDArray[np.int32], ...]]


class Particles(NamedTuple):
    """Structure of arrays, one row a particle; see the table of this module."""

    x: FloatArray
    v: FloatArray
    F: FloatArray
    sigma: FloatArray
    V: FloatArray
    V0: FloatArray
    m: FloatArray
    id: IntArray
    cell: IntArray
    layer: NDArray[np.int32]
    body: NDArray[np.int32]
    origin: FloatArray
    L: FloatArray
    q: FloatArray
    patch: FloatArray
    grip: NDArray[np.int32]

    @classmethod
    def empty(
        cls,
        capacity: int,
        dimension: int,
        origin: bool = False,
        *,
        affine: bool = False,
        viscous: bool = False,
        tractions: int = 0,
        grips: bool = False,
    ) -> "Particles":
        """Arrays for `capacity` particles, F = 1 and sigma = 0, with the columns asked for."""
        D = dimension
        F = np.zeros((capacity, D * D))
        F[:, :: D + 1] = 1.0
        return cls(
            x=np.zeros((capacity, D)),
            v=np.zeros((capacity, D)),
            F=F,
            sigma=np.zeros((capacity, (3, 4, 6)[D - 1])),
            V=np.zeros(capacity),
            V0=np.zeros(capacity),
            m=np.zeros(capacity),
            id=np.zeros(capacity, np.int64),
            cell=np.zeros(capacity, np.int64),
            layer=np.zeros(capacity, np.int32),
            body=np.zeros(capacity, np.int32),
            origin=np.zeros((capacity, D if origin else 0)),
            L=np.zeros((capacity, D * D if affine else 0)),
            q=np.zeros((capacity, 1 if viscous else 0)),
            patch=np.zeros((capacity, tractions)),
            grip=np.zeros((capacity, 1 if grips else 0), np.int32),
        )

    @property
    def capacity(self) -> int:
        """Number of rows."""
        return len(self.m)

    def columns(self) -> "Columns":
        """All arrays bit by bit, (c, k) each: those of int32, and the others as int64."""
        arrays: tuple[np.ndarray, ...] = tuple(self)
        tables = [array.reshape(self.capacity, array[0].size) for array in arrays]
        words = tuple(table.view(np.int64) for table in tables if table.itemsize == 8)
        return words, tuple(table for table in tables if table.itemsize == 4)

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return sum(array[0].size for array in self)


class Frame(NamedTuple):
    """Where the grid lies. Vertex and layer numbers count from the first ghost vertex.

    All tuples have D entries; vertex number i of direction d stands at
    ``origin[d] + (i - ghost) * cell[d]``.
    """

    origin: tuple[float, ...]
    cell: tuple[float, ...]
    inverse: tuple[float, ...]
    cells: tuple[int, ...]
    ghost: int

    @property
    def vertices(self) -> tuple[int, ...]:
        """Number of vertices of each direction, with `ghost` more beyond either face."""
        return tuple(n + 1 + 2 * self.ghost for n in self.cells)


class Window(NamedTuple):
    """The part of the grid that a rank stores: its planes, cut to where particles are.

    `lower` is the first vertex of each of three directions, `extent` the number of vertices (1
    where the scene has no such direction), `stride` the distance of neighbours in float64.
    """

    lower: tuple[int, int, int]
    extent: tuple[int, int, int]
    stride: tuple[int, int, int]

    @classmethod
    def over(cls, lower: tuple[int, int, int], extent: tuple[int, int, int]) -> "Window":
        """Window of records, planes outermost."""
        return cls(lower, extent, (RECORD * extent[1] * extent[2], RECORD * extent[2], RECORD))
