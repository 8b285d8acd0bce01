"""The particles of one rank: the data shared by all kernels.

Each column is declared once, in `Particles`. Allocation, migration, checkpoints, checks of a resume
and docs/symbols.md follow from it. `Population` has the live rows and their canonical order; rows
of particles that have left stay as holes until the next re-sort.
"""

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from pgimp.kernels.data.column import Carried, Column
from pgimp.kernels.data.frame import identity
from pgimp.physics.loads.surfaces import surface_width

#: The layer of a particle that has left through an open face.
OUTFLOW = -1

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Columns = tuple[tuple[IntArray, ...], tuple[NDArray[np.int32], ...]]


def _directions(carried: Carried) -> int:
    return carried.dimensions


def _matrix(carried: Carried) -> int:
    return len(carried.undeformed)


def _gradient(carried: Carried) -> int:
    return len(identity(carried.dimensions, carried.axial)) if carried.affine else 0


def _position(p: Any, _: Sequence[Any]) -> FloatArray:
    position: FloatArray = p.x
    return position


class Particles(NamedTuple):
    """Structure of arrays, one row a particle; unused quantities have no columns."""

    x: Annotated[FloatArray, Column("position", "length", _directions)]
    v: Annotated[
        FloatArray, Column("velocity, momentum over mass p_p/m_p", "length/time", _directions)
    ]
    F: Annotated[FloatArray, Column("deformation gradient, row by row", "1", _matrix, initial=1.0)]
    sigma: Annotated[
        FloatArray,
        Column(
            "Cauchy stress xx yy zz [xy [yz xz]], positive in tension",
            "stress",
            lambda carried: (3, 4, 6)[carried.dimensions - 1],
        ),
    ]
    V: Annotated[FloatArray, Column("volume in (16)", "volume", above=0.0)]
    V0: Annotated[FloatArray, Column("initial volume", "volume", above=0.0)]
    m: Annotated[FloatArray, Column("mass", "mass", above=0.0)]
    id: Annotated[
        IntArray, Column("number, by body, then by position", dtype=np.int64, numbers="particles")
    ]
    cell: Annotated[
        IntArray,
        Column(
            "cell of the first vertex when rows were last sorted", dtype=np.int64, numbers="cells"
        ),
    ]
    layer: Annotated[NDArray[np.int32], Column("plane of the first vertex now", dtype=np.int32)]
    body: Annotated[
        NDArray[np.int32], Column("number of the body", dtype=np.int32, numbers="bodies")
    ]
    origin: Annotated[
        FloatArray,
        Column(
            "initial position",
            "length",
            lambda c: c.dimensions if c.origin else 0,
            initial=_position,
        ),
    ]
    L: Annotated[
        FloatArray,
        Column("velocity gradient, row by row", "1/time", _gradient, continued="optional"),
    ]
    q: Annotated[
        FloatArray,
        Column("viscous pressure", "stress", lambda c: int(c.viscous), continued="optional"),
    ]
    patch: Annotated[
        FloatArray,
        Column("area of each traction's patch", "area", lambda c: c.tractions, least=0.0),
    ]
    constraint: Annotated[
        NDArray[np.int32],
        Column(
            "number of the constraint that holds it, from 1; 0 is none",
            width=lambda _: 1,
            dtype=np.int32,
            numbers="constraints",
            needed=lambda case: bool(case.constraints),
        ),
    ]
    state: Annotated[FloatArray, Column("state variables of the material", "", lambda c: c.state)]
    offset: Annotated[
        FloatArray,
        Column(
            "centroid of what a surface leaves of it, from its position, at the start",
            "length",
            lambda c: c.dimensions if c.surfaces else 0,
            continued="optional",
        ),
    ]
    excess: Annotated[
        FloatArray,
        Column(
            "what the surface's curvature adds to the mean gap from a plane",
            "length",
            lambda c: int(c.surfaces),
            continued="optional",
        ),
    ]
    isolation: Annotated[
        FloatArray,
        Column(
            "part of its rate of dilatation that is not the cells', where it is alone in them",
            "1",
            lambda c: int(c.mean),
            least=0.0,
            continued="optional",
        ),
    ]
    cell_F: Annotated[
        FloatArray,
        Column(
            "deformation gradient of the cells in which it lies, row by row, with mean dilatation "
            "in the initial configuration",
            "1",
            lambda c: _matrix(c) if c.cell_F else 0,
            initial=1.0,
            continued="required",
        ),
    ]
    fbar_ratio: Annotated[
        FloatArray,
        Column(
            "F over the deformation gradient at its place, likewise",
            "1",
            lambda c: int(c.cell_F),
            above=0.0,
            initial=1.0,
            continued="required",
        ),
    ]
    mean_stress: Annotated[
        FloatArray,
        Column(
            "mean of the normal stresses over the cells with its dilatation, of bodies exact to "
            "their surface",
            "stress",
            lambda c: int(c.cell_F and c.products > 0),
        ),
    ]
    own: Annotated[
        FloatArray,
        Column(
            "parameters of the material that vary in space",
            "",
            lambda c: c.own,
            continued="required",
        ),
    ]
    slope: Annotated[
        FloatArray,
        Column(
            "gradient of the volume ratio J, of what flows",
            "1/length",
            lambda c: c.dimensions if c.liquid else 0,
            continued="optional",
        ),
    ]
    winding: Annotated[
        IntArray,
        Column(
            "turns through periodic faces: periods from its position to the unwrapped one", "",
            _directions, np.int64,
            needed=lambda case: any(face.joins for face in case.boundaries.values()),
        ),
    ]  # fmt: skip

    surface: Annotated[
        FloatArray,
        Column(
            "for each load on a part of a surface its part there: area, area vector, and the first "
            "moments of that about its position, row by row, at the start",
            "area, area length",
            lambda c: c.surfaces_loaded * surface_width(c.dimensions),
        ),
    ]
    place: Annotated[
        FloatArray,
        Column(
            "position in the undeformed state, where loads follow surfaces",
            "length",
            lambda c: c.dimensions if c.follows_surfaces else 0,
            initial=_position,
        ),
    ]
    surface_F_correction: Annotated[
        FloatArray,
        Column(
            "R, by which R F is the deformation gradient by positions, row by row, likewise",
            "1",
            lambda c: _matrix(c) if c.follows_surfaces else 0,
            initial=1.0,
        ),
    ]

    products: Annotated[
        FloatArray,
        Column(
            "means over its part of a cell of products of the distances from the part's centroid, "
            "xy in 2D, yz xz xy xyz in 3D, at the start; of rings see `VolumeFractions`",
            "length^2, length^3",
            lambda c: c.products,
        ),
    ]
    bearing: Annotated[
        FloatArray,
        Column(
            "likewise of its part of each loaded surface, about that part's centroid; then along "
            "each direction, integrals of the same products times the normal, less the means times "
            "the area vector",
            "length^2 to length^5",
            lambda c: c.surfaces_loaded * c.bearing,
        ),
    ]

    @classmethod
    def empty(cls, capacity: int, carried: Carried) -> "Particles":
        """Arrays for `capacity` particles with all carried columns at their initial values."""
        arrays, one = {}, np.array(carried.undeformed)
        for name, column in COLUMNS.items():
            more = shape_of(name, carried)
            arrays[name] = np.zeros((capacity, *more), column.dtype)
            if column.initial and not callable(column.initial):
                arrays[name][:] = column.initial * one[: more[0]]
        return cls(**arrays)

    def initialise(self, bodies: Sequence[Any]) -> None:
        """Set the columns whose initial values are functions of the others, see `Column`."""
        for name, column in COLUMNS.items():
            values: np.ndarray = getattr(self, name)
            if callable(column.initial) and values.size:
                values[:] = column.initial(self, bodies).reshape(values.shape)

    @property
    def capacity(self) -> int:
        """Number of rows."""
        return len(self.m)

    def columns(self) -> "Columns":
        """All arrays bit by bit, (c, k) each: the int32 arrays, and the others as int64."""
        arrays: tuple[np.ndarray, ...] = tuple(self)
        tables = [array.reshape(self.capacity, array[0].size) for array in arrays]
        words = tuple(table.view(np.int64) for table in tables if table.itemsize == 8)
        return words, tuple(table for table in tables if table.itemsize == 4)

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return sum(array[0].size for array in self)


#: The columns by their names, in the order of the arrays.
COLUMNS: dict[str, Column] = {
    name: hint.__metadata__[0]
    for name, hint in get_type_hints(Particles, include_extras=True).items()
}


def shape_of(name: str, carried: Carried) -> tuple[int, ...]:
    """Shape of a particle's entry in a column: (), or (k,) with k = 0 where it is not carried."""
    column = COLUMNS[name]
    if column.width is None:
        return ()
    return (column.width(carried) if not column.needed or name in carried.needed else 0,)


def needed_by(case: Any) -> frozenset[str]:
    """Return the columns that a case needs by their declaration, see `Column.needed`."""
    return frozenset(
        name for name, column in COLUMNS.items() if column.needed and column.needed(case)
    )


def continued_columns() -> tuple[str, ...]:
    """Return the columns that a body may take from a run's own file, see `Column.continued`."""
    return tuple(name for name, column in COLUMNS.items() if column.continued)
