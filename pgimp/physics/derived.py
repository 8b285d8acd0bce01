"""Fields computed from stress and deformation, for frames and probes that name them.

Only correctly rounded operations, in a fixed order, precede roots, logarithms and angles. So the
bits of a particle do not depend on where in an array it is.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pgimp.physics.source import TENSOR, Array, Field, Source, volume

#: Sweeps of Jacobi's method: four leave 1e-16 of a tensor's size.
_SWEEPS = 5
_TINY = 1e-300


def eigen(tensors: Array) -> tuple[Array, Array]:
    """Return eigenvalues and eigenvectors of symmetric tensors by Jacobi's method.

    Parameters
    ----------
    tensors : (n, 3 to 6) float64
        As xx, yy, zz, xy, yz, xz; missing components are zero.

    Returns
    -------
    values : (n, 3) float64
        The greatest first.
    vectors : (n, 3, 3) float64
        ``vectors[:, k]`` is the unit vector of the k-th value; its largest component is positive.
    """
    count, given = tensors.shape
    parts = [tensors[:, i].copy() if i < given else np.zeros(count) for i in range(6)]
    A = [[parts[0], parts[3], parts[5]], [parts[3], parts[1], parts[4]]]
    A.append([parts[5], parts[4], parts[2]])
    Q = [[np.full(count, float(i == j)) for j in range(3)] for i in range(3)]
    with np.errstate(all="ignore"):
        for _ in range(_SWEEPS):
            for p, q in ((0, 1), (0, 2), (1, 2)):
                _rotate(A, Q, p, q)
    values = np.stack([A[0][0], A[1][1], A[2][2]], axis=1)
    vectors = np.stack([np.stack([Q[i][k] for i in range(3)], axis=1) for k in range(3)], axis=1)
    order = np.argsort(-values, axis=1, kind="stable")
    values = np.take_along_axis(values, order, axis=1)
    vectors = np.take_along_axis(vectors, order[:, :, None], axis=1)
    largest = np.take_along_axis(vectors, np.abs(vectors).argmax(axis=2)[:, :, None], axis=2)
    return values, np.where(largest < 0.0, -vectors, vectors)


def _rotate(A: list[list[Array]], Q: list[list[Array]], p: int, q: int) -> None:
    """Turn the axes `p` and `q` so that the component between them vanishes."""
    twice, d = 2.0 * A[p][q], A[q][q] - A[p][p]
    t = np.where(d < 0.0, -twice, twice) / (np.abs(d) + np.sqrt(d * d + twice * twice) + _TINY)
    c = 1.0 / np.sqrt(1.0 + t * t)
    s, r = t * c, 3 - p - q
    A[p][p], A[q][q] = A[p][p] - t * A[p][q], A[q][q] + t * A[p][q]
    A[p][q] = A[q][p] = np.zeros_like(t)
    A[p][r], A[q][r] = c * A[p][r] - s * A[q][r], s * A[p][r] + c * A[q][r]
    A[r][p], A[r][q] = A[p][r], A[q][r]
    for row in Q:
        row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]


def principal_of(sigma: Array) -> Array:
    """Return the principal stresses of stresses (n, 3 to 6), the greatest first, (n, 3)."""
    return eigen(sigma)[0]


def max_shear_of(sigma: Array) -> Array:
    """Return the maximum shear stress of stresses, half of Tresca's equivalent stress."""
    values = principal_of(sigma)
    return 0.5 * (values[:, 0] - values[:, 2])


def invariants_of(sigma: Array) -> Array:
    """Return I1, J2 and J3 of stresses (n, 3 to 6): of the tensor, and of its deviator, (n, 3)."""
    xx, yy, zz, xy, yz, xz = _six(sigma)
    trace = xx + yy + zz
    mean = trace / 3.0
    x, y, z = xx - mean, yy - mean, zz - mean
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    second = normal / 6.0 + (xy * xy + yz * yz + xz * xz)
    third = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz)
    return np.stack([trace, second, third], axis=1)


def lode_angle_of(sigma: Array) -> Array:
    """Return the Lode angle of stresses in degrees, 0 where there is no shear.

    cos(3 theta) = 3 sqrt(3)/2 J3/J2^(3/2).
    """
    _, second, third = invariants_of(sigma).T
    with np.errstate(all="ignore"):
        cosine = 1.5 * np.sqrt(3.0) * third / (second * np.sqrt(second))
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0)
    return np.where(np.isfinite(cosine) | np.isnan(second), angle, 0.0)


def triaxiality_of(sigma: Array) -> Array:
    """Return the triaxiality of stresses: mean over von Mises stress, 0 where the latter is."""
    trace, second, _ = invariants_of(sigma).T
    with np.errstate(all="ignore"):
        found = trace / 3.0 / np.sqrt(3.0 * second)
    return np.where(second == 0.0, 0.0, found)


def _six(tensors: Array) -> list[Array]:
    """Return the six components of symmetric tensors (n, 3 to 6)."""
    count, given = tensors.shape
    return [tensors[:, i] if i < given else np.zeros(count) for i in range(6)]


def _direction(k: int) -> Callable[[Array], Array]:
    return lambda sigma: eigen(sigma)[1][:, k]


OF_STRESS: dict[str, Callable[[Array], Array]] = {
    "principal-stress": principal_of,
    "principal-direction-1": _direction(0),
    "principal-direction-2": _direction(1),
    "principal-direction-3": _direction(2),
    "max-shear": max_shear_of,
    "stress-invariants": invariants_of,
    "lode-angle": lode_angle_of,
    "triaxiality": triaxiality_of,
}
"""Functions of stresses (n, 3 to 6), also for places, and for plots of frames with the stress."""


def _of_stress(name: str) -> Callable[[Source], Array]:
    return lambda source: OF_STRESS[name](source.take("sigma"))


def gradient(source: Source) -> list[list[Array]]:
    """Return the deformation gradient by row and column, one on the missing diagonal."""
    D, local = source.dimension, source.take("F")
    count = len(local)
    full = [[np.full(count, float(i == j)) for j in range(3)] for i in range(3)]
    for i in range(D):
        for j in range(D):
            full[i][j] = local[:, i * D + j]
    if source.stretches:
        full[2][2] = local[:, D * D]
    return full


def volume_ratio(source: Source) -> Array:
    """Return the determinant of the deformation gradient, J."""
    (a, b, c), (d, e, f), (g, h, i) = gradient(source)
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def _left_stretches(source: Source) -> tuple[Array, Array]:
    """Return squared principal stretches and their current directions, from F F^T."""
    F = gradient(source)
    parts = []
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)):
        parts.append(F[i][0] * F[j][0] + F[i][1] * F[j][1] + F[i][2] * F[j][2])
    return eigen(np.stack(parts, axis=1))


def principal_stretch(source: Source) -> Array:
    """Return the principal stretches, the greatest first, (n, 3)."""
    with np.errstate(invalid="ignore"):
        return np.sqrt(_left_stretches(source)[0])


def hencky_strain(source: Source) -> Array:
    """Return the spatial logarithmic strain ln V as xx, yy, zz, xy, yz, xz."""
    values, vectors = _left_stretches(source)
    with np.errstate(all="ignore"):
        logs = 0.5 * np.log(values)
    found = []
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)):
        terms = [logs[:, k] * vectors[:, k, i] * vectors[:, k, j] for k in range(3)]
        found.append(terms[0] + terms[1] + terms[2])
    return np.stack(found, axis=1)


def equivalent_strain(source: Source) -> Array:
    """Return the equivalent strain: sqrt(2/3 e:e) of the deviator e of the logarithmic strain."""
    with np.errstate(all="ignore"):
        a, b, c = (0.5 * np.log(_left_stretches(source)[0])).T
        return np.sqrt(((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) * (2.0 / 9.0))


def strain_energy(source: Source) -> Array:
    """Return the strain energy per initial volume."""
    return source.energies()


def kinetic_energy(source: Source) -> Array:
    """Return the kinetic energy per current volume."""
    v, total = source.take("v"), np.zeros(len(source.rows))
    for d in range(v.shape[1]):
        total += v[:, d] * v[:, d]
    return 0.5 * (source.take("m") / volume(source)) * total


DERIVED = {
    "principal-stress": Field(
        _of_stress("principal-stress"),
        "principal stresses, the greatest first, tension positive [stress]",
        components="1 2 3",
        kind="Vector",
    ),
    **{
        f"principal-direction-{k + 1}": Field(
            _of_stress(f"principal-direction-{k + 1}"),
            f"unit vector of the {rank} principal stress; its largest component is positive",
            components="x y z",
            kind="Vector",
        )
        for k, rank in enumerate(("greatest", "intermediate", "least"))
    },
    "max-shear": Field(
        _of_stress("max-shear"),
        "maximum shear stress, half the difference of greatest and least principal stress [stress]",
    ),
    "stress-invariants": Field(
        _of_stress("stress-invariants"),
        "I1, the trace of the stress, and J2 and J3 of its deviator, in powers of stress; p is "
        "`pressure`, q is `von-mises`",
        components="i1 j2 j3",
        kind="Vector",
    ),
    "lode-angle": Field(
        _of_stress("lode-angle"),
        "Lode angle in degrees, cos(3 theta) = 3 sqrt(3)/2 J3/J2^(3/2): 0 in triaxial extension, "
        "60 in triaxial compression; 0 without shear",
    ),
    "triaxiality": Field(
        _of_stress("triaxiality"),
        "mean stress over von Mises stress, tension positive; 0 without shear [1]",
    ),
    "volume-ratio": Field(volume_ratio, "J, the determinant of F [1]"),
    "principal-stretch": Field(
        principal_stretch,
        "principal stretches, the greatest first [1]",
        components="1 2 3",
        kind="Vector",
    ),
    "log-strain": Field(
        hencky_strain,
        "logarithmic (Hencky) strain ln V, in current directions; of a liquid its volume's alone",
        components=TENSOR,
        kind="Matrix",
    ),
    "equivalent-strain": Field(
        equivalent_strain, "sqrt(2/3 e:e) of the deviator e of the logarithmic strain [1]"
    ),
    "strain-energy-density": Field(
        strain_energy, "internal (strain) energy per initial volume [stress]"
    ),
    "kinetic-energy-density": Field(kinetic_energy, "kinetic energy per volume [stress]"),
}
"""Fields computed from others as a frame is written, when they are asked for."""

#: Stress by a fit to particles, see `pgimp.solver.lagrangian.recovered_stress`.
RECOVERED = "recovered-stress"

FITTED = {
    RECOVERED: Field(
        lambda source: np.stack(_six(source.take("sigma")), axis=1),
        "stress where the particle is, or at the place that a probe names, by a linear fit to the "
        "body's particles within a cell, which is better than `stress`, most of all at surfaces; "
        "of bodies in the initial configuration [stress]",
        components=TENSOR,
        kind="Matrix",
    )
}
"""Fields from particles and their neighbours; one that is looked at alone has its own value."""

COMPUTED = DERIVED | FITTED
"""All of these."""
