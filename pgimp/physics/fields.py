"""Particle quantities in frames, probes and plots: name, meaning, function."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pgimp.physics.derived import COMPUTED, OF_STRESS
from pgimp.physics.source import TENSOR, Array, Field, Source, volume, within

#: Prefix of the fields of spatially varying parameters, before their keys in the case.
PREFIX = "parameter-"


def _padded(values: Array, columns: int) -> Array:
    """Pad an (n, k) array with zeros to (n, columns)."""
    if values.shape[1] == columns:
        return values
    full = np.zeros((len(values), columns))
    full[:, : values.shape[1]] = values
    return full


def no_fault(source: Source) -> Array:
    """Return 0, no fault, for each particle."""
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
    """Return the centres, zero in missing directions; within the domain where it is periodic."""
    return _padded(within(source.take("x"), source.periods), 3)


def unwrapped(source: Source) -> Array:
    """Return the centres, with the turns through periodic faces."""
    turns = source.take("winding") * np.array([period for _, period in source.periods])
    return _padded(source.take("x") + turns, 3)


def radius(source: Source) -> Array:
    """Return half the side of the segment, square or cube of the volume without voids.

    A ring has the square of its section, a part of a plate the one of its area.
    """
    current = volume(source)
    if source.plate:
        current = current / source.take("F")[:, 4].clip(1e-300)
    elif source.stretches:
        current = current / (2.0 * np.pi * source.take("x")[:, 0].clip(1e-300))
    if source.dimension == 1:
        return 0.5 * current
    return 0.5 * (np.sqrt(current) if source.dimension == 2 else np.cbrt(current))


def velocity(source: Source) -> Array:
    """Return the velocity, zero in missing directions."""
    return _padded(source.take("v"), 3)


def stress(source: Source) -> Array:
    """Return the Cauchy stress as xx, yy, zz, xy, yz, xz, zero where the dimension has none."""
    return _padded(source.take("sigma"), 6)


def pressure_of(sigma: Array) -> Array:
    """Return the pressure of stresses, (n, 3) or more: positive in compression."""
    xx, yy, zz = sigma[:, :3].T
    return -(xx + yy + zz) / 3.0


def von_mises_of(sigma: Array) -> Array:
    """Return the von Mises stress of stresses, (n, 3 to 6)."""
    xx, yy, zz, xy, yz, xz = _padded(sigma, 6).T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(0.5 * normal + 3.0 * (xy**2 + yz**2 + xz**2))


def displacement(source: Source) -> Array:
    """Return position minus initial position, zero in missing directions."""
    return _padded(source.take("x") - source.take("origin"), 3)


def deformation(source: Source) -> Array:
    """Return the deformation gradient, row-major, one on the diagonal in missing directions."""
    dimension, local = source.dimension, source.take("F")
    if dimension == 3:
        return local
    own = dimension**2
    full = np.zeros((len(source.rows), 3, 3))
    full[:, range(dimension, 3), range(dimension, 3)] = 1.0
    full[:, :dimension, :dimension] = local[:, :own].reshape(-1, dimension, dimension)
    if source.stretches:
        full[:, 2, 2] = local[:, own]
    return full.reshape(-1, 9)


def strain(source: Source) -> Array:
    """Return the Green-Lagrange strain (F^T F - 1)/2 as xx, yy, zz, xy, yz, xz."""
    D, local = source.dimension, source.take("F")
    full = np.zeros((len(source.rows), 6))
    for column, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))):
        if max(i, j) < D:
            # Explicit sums: a library's result would depend on the particle's array index.
            product = local[:, i] * local[:, j]
            for k in range(1, D):
                product += local[:, k * D + i] * local[:, k * D + j]
            full[:, column] = 0.5 * (product - float(i == j))
    if source.stretches:
        full[:, 2] = 0.5 * (local[:, D * D] ** 2 - 1.0)
    return full


def initial_volume(source: Source) -> Array:
    """Return the initial volume."""
    return source.take("V0")


def velocity_gradient(source: Source) -> Array:
    """Return the velocity gradient of affine particles, row-major; zero where there is none."""
    D, local = source.dimension, source.take("L")
    full = np.zeros((len(source.rows), 3, 3))
    if local.shape[1]:
        full[:, :D, :D] = local[:, : D * D].reshape(-1, D, D)
    if local.shape[1] > D * D:
        full[:, 2, 2] = local[:, D * D]
    return full.reshape(-1, 9)


def mass(source: Source) -> Array:
    """Return the mass."""
    return source.take("m")


def density(source: Source) -> Array:
    """Return the mass over the volume without voids."""
    return mass(source) / volume(source)


def rank(source: Source) -> Array:
    """Return the rank for each particle."""
    return np.full(len(source.rows), source.rank, np.int32)


ALWAYS = {
    "id": Field(identity, "number of the particle, by body, then by initial position",
        kind="GlobalId", dtype="<i8"),
    "body": Field(body, "index of the body; the names are in the attributes", dtype="<i4"),
    "material": Field(material, "index of the material; the names are in the attributes",
        dtype="<i4"),
    "position": Field(position,
        "position of the centre [length]; zeros beyond the case's dimensions", components="x y z",
        kind="Vector"),
    "volume": Field(volume,
        "current volume, det(F) times the initial one, of rings all round; of what flows without "
        "voids: liquids and grains up to J = 1.01, loose soil less its `gap` [length^dimensions]"),
    "radius": Field(radius,
        "half the side of a segment, square or cube of this volume, to draw it; of a ring the side "
        "of its section [length]"),
}  # fmt: skip
"""What every frame holds."""

OPTIONAL = {
    "velocity": Field(velocity, "velocity [length/time]", components="x y z", kind="Vector"),
    "stress": Field(
        stress, "Cauchy stress, tension positive [stress]", components=TENSOR, kind="Matrix"
    ),
    "displacement": Field(
        displacement, "position less initial position [length]", components="x y z", kind="Vector"
    ),
    "unwrapped": Field(
        unwrapped,
        "position with the turns through periodic faces, as if the domain went on [length]; in "
        "domains that are periodic",
        components="x y z",
        kind="Vector",
    ),
    "deformation": Field(
        deformation,
        "deformation gradient F, row by row",
        components="xx xy xz yx yy yz zx zy zz",
        kind="Matrix",
    ),
    "pressure": Field(
        lambda source: pressure_of(source.take("sigma")),
        "-(xx + yy + zz)/3 of the stress, compression positive [stress]",
    ),
    "von-mises": Field(
        lambda source: von_mises_of(source.take("sigma")), "von Mises equivalent stress [stress]"
    ),
    "strain": Field(
        strain,
        "Green-Lagrange strain, (F^T F - 1)/2, which a rotation leaves zero; tensor "
        "components: xy is half the angle of shear where that is small",
        components=TENSOR,
        kind="Matrix",
    ),
    "mass": Field(mass, "mass, which never changes [mass]"),
    "initial-volume": Field(
        initial_volume, "initial volume, of rings all round [length^dimensions]"
    ),
    "velocity-gradient": Field(
        velocity_gradient,
        "velocity gradient that particles carry with `affine`, row by row: dv_x/dx, dv_x/dy, ...; "
        "0 where they carry none [1/time]",
        components="xx xy xz yx yy yz zx zy zz",
        kind="Matrix",
    ),
    "density": Field(density, "mass over `volume` [mass/length^dimensions]"),
    "rank": Field(
        rank,
        "rank of MPI that has the particle; as it depends on the number of ranks by its "
        "nature, `pgimp compare` leaves it out",
        dtype="<i4",
    ),
} | COMPUTED
"""What ``output.fields`` may name in every case, to which states of materials come."""

FIELDS = ALWAYS | OPTIONAL

FROM_STRESS: dict[str, Callable[[Array], Array]] = {
    "von-mises": von_mises_of,
    "pressure": pressure_of,
    **OF_STRESS,
}
"""Fields that plots and tables compute from the stress (n, 3 to 6) where a frame lacks them."""

BY_RANKS = ("rank",)
"""Fields that differ with the number of ranks by their nature."""

FAILURE = {
    "fault": Field(no_fault,
        "0: a neighbour; 1: position, velocity or deformation is not a finite number; 2: inside "
        "out (det F <= 0); 3: moved by more than a cell in a step; 4: left the domain; 5: out of "
        "the range of its material",
        dtype="<i4"),
}  # fmt: skip
"""What the particles of a failed run have besides."""

EVERY = FIELDS | FAILURE


def components_of(name: str, columns: int) -> list[str]:
    """Component names of a frame's field, also of a field that a material has added."""
    if name in EVERY:
        return EVERY[name].components.split()
    return TENSOR.split() if columns == 6 else [str(i) for i in range(columns)]
