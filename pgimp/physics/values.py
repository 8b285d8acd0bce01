"""The fields of a particle frame, a small function each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray


class Source(NamedTuple):
    """Where a field takes its values.

    Attributes
    ----------
    particles : Particles
        The rank's particles, in storage order with holes.
    rows : ndarray of int64, shape (n,)
        The storage indices wanted.
    dimension : int
        1, 2 or 3.
    body_material : tuple of int
        The material of each body.
    rank : int
        The rank.
    """

    particles: Any
    rows: Array
    dimension: int
    body_material: tuple[int, ...]
    rank: int = 0

    def take(self, symbol: str) -> Array:
        """Return the wanted rows of an array of the particles: (n,) or (n, k)."""
        # Several times faster than indexing with the rows.
        return np.take(getattr(self.particles, symbol), self.rows, axis=0)


class Field(NamedTuple):
    """How a field gets into a frame; what it means is said in `pgimp.physics.fields`.

    Attributes
    ----------
    values : callable
        Takes a `Source`; returns an array of shape (n,) or (n, columns).
    components : str
        Names of the components in order; empty for a scalar.
    kind : str
        The attribute type that XDMF readers need.
    dtype : str
        Type in the file.
    """

    values: Callable[[Source], Array]
    components: str = ""
    kind: str = "Scalar"
    dtype: str = "<f8"

    @property
    def columns(self) -> int:
        """Number of components; 0 for a scalar."""
        return len(self.components.split())


def _padded(values: Array, columns: int) -> Array:
    """Fill up an (n, k) array with zeros to (n, columns)."""
    if values.shape[1] == columns:
        return values
    full = np.zeros((len(values), columns))
    full[:, : values.shape[1]] = values
    return full


def no_fault(source: Source) -> Array:
    """Return 0 for each particle: nothing is wrong with it."""
    return np.zeros(len(source.rows), np.int32)


def identity(source: Source) -> Array:
    """Return the number of each particle."""
    return source.take("id")


def body(source: Source) -> Array:
    """Return the index of each particle's body."""
    return source.take("body")


def material(source: Source) -> Array:
    """Return the index of each particle's material."""
    return np.asarray(source.body_material, dtype=np.int32)[body(source)]


def position(source: Source) -> Array:
    """Return the centres, zero in missing directions."""
    return _padded(source.take("x"), 3)


def volume(source: Source) -> Array:
    """Return the current volume; an area in 2D, a length in 1D."""
    return source.take("V")


def radius(source: Source) -> Array:
    """Return half the side of the segment, square or cube of the current volume."""
    current = volume(source)
    if source.dimension == 1:
        return 0.5 * current
    return 0.5 * (np.sqrt(current) if source.dimension == 2 else np.cbrt(current))


def velocity(source: Source) -> Array:
    """Return the velocity, zero in missing directions."""
    return _padded(source.take("v"), 3)


def stress(source: Source) -> Array:
    """Return the Cauchy stress as xx, yy, zz, xy, yz, xz, zero where the dimension has none."""
    return _padded(source.take("sigma"), 6)


def displacement(source: Source) -> Array:
    """Return position less initial position, zero in missing directions."""
    return _padded(source.take("x") - source.take("origin"), 3)


def deformation(source: Source) -> Array:
    """Return the deformation gradient by rows, one on the diagonal in missing directions."""
    dimension, local = source.dimension, source.take("F")
    if dimension == 3:
        return local
    full = np.zeros((len(source.rows), 3, 3))
    full[:, range(dimension, 3), range(dimension, 3)] = 1.0
    full[:, :dimension, :dimension] = local.reshape(-1, dimension, dimension)
    return full.reshape(-1, 9)


def pressure(source: Source) -> Array:
    """Return minus a third of the trace of the stress: positive in compression."""
    xx, yy, zz = source.take("sigma")[:, :3].T
    return -(xx + yy + zz) / 3.0


def von_mises(source: Source) -> Array:
    """Return the von Mises stress: three times the deviator's second invariant, its root."""
    xx, yy, zz, xy, yz, xz = stress(source).T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(0.5 * normal + 3.0 * (xy**2 + yz**2 + xz**2))


def strain(source: Source) -> Array:
    """Return the Green-Lagrange strain (F^T F - 1)/2 as xx, yy, zz, xy, yz, xz."""
    D, local = source.dimension, source.take("F")
    full = np.zeros((len(source.rows), 6))
    for column, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))):
        if max(i, j) < D:
            # Sums of products, as a library's would depend on where in the array a particle is.
            product = local[:, i] * local[:, j]
            for k in range(1, D):
                product += local[:, k * D + i] * local[:, k * D + j]
            full[:, column] = 0.5 * (product - float(i == j))
    return full


def mass(source: Source) -> Array:
    """Return the mass."""
    return source.take("m")


def density(source: Source) -> Array:
    """Return the mass over the current volume."""
    return mass(source) / volume(source)


def rank(source: Source) -> Array:
    """Return the rank for each particle."""
    return np.full(len(source.rows), source.rank, np.int32)


ALWAYS = {
    "id": Field(identity, kind="GlobalId", dtype="<i8"),
    "body": Field(body, dtype="<i4"),
    "material": Field(material, dtype="<i4"),
    "position": Field(position, "x y z", "Vector"),
    "volume": Field(volume),
    "radius": Field(radius),
}
"""Fields that every frame has."""

# As "Tensor6" the stress becomes a wrongly placed 9-tensor in ParaView's XDMF2 reader.
OPTIONAL = {
    "velocity": Field(velocity, "x y z", "Vector"),
    "stress": Field(stress, "xx yy zz xy yz xz", "Matrix"),
    "displacement": Field(displacement, "x y z", "Vector"),
    "deformation": Field(deformation, "xx xy xz yx yy yz zx zy zz", "Matrix"),
    "pressure": Field(pressure),
    "von-mises": Field(von_mises),
    "strain": Field(strain, "xx yy zz xy yz xz", "Matrix"),
    "mass": Field(mass),
    "density": Field(density),
    "rank": Field(rank, dtype="<i4"),
}
"""Fields that a frame has when the case's ``output.fields`` names them."""

FIELDS = ALWAYS | OPTIONAL

BY_RANKS = ("rank",)
"""Fields that differ with the number of ranks by their nature."""

FAILURE = {"fault": Field(no_fault, dtype="<i4")}
"""Fields that only the particles of a failed run's bundle have."""

EVERY = FIELDS | FAILURE
