"""The deformation with which a body begins under a stress that its law has from the deformation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.errors import CaseError
from pgimp.kernels.data.frame import identity, volume_ratio
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.once.prestress import bearable_stress
from pgimp.scene.scene import Scene
from pgimp.scene.surfaces import face_stretches

#: Newton steps, at most; the change of a logarithm for a slope; the part of the wanted stress that
#: may be missing in the end.
_STEPS, _CHANGE, _MISSING = 60, -1e-6, 1e-9


class Unknown(NamedTuple):
    """A number of the deformation gradient F, and the component of the stress that it gives.

    `entries` of F are its exponential on the diagonal, and itself elsewhere. The component is
    None for the mean stress.
    """

    entries: list[int]
    component: int | None
    diagonal: bool = True


def _diagonal(scene: Scene) -> list[int]:
    """Entries of the diagonal of F, with that round an axis."""
    D, axial = scene.dimension, scene.case.axisymmetric
    return [d * (D + 1) for d in range(D)] + [D * D] * axial


def _mean_alone(scene: Scene, name: str) -> bool:
    """Whether the law of a body has no more than its mean stress from the deformation."""
    law = scene.case.materials[scene.case.bodies[name].material]
    return bool(law.VOLUME_ONLY or law.CARRIES_STRESS)


def unknowns_along(scene: Scene, name: str, axis: int) -> list[Unknown]:
    """Axial and transverse stretch; one isotropic stretch for laws with mean stress alone."""
    places = _diagonal(scene)
    if _mean_alone(scene, name):
        return [Unknown(places, None)]
    across = [d for d in range(len(places)) if d != axis]
    found = [Unknown([places[axis]], axis)]
    return [*found, Unknown([places[d] for d in across], across[0])] if across else found


def every_unknown(scene: Scene, name: str) -> list[Unknown]:
    """Components of a symmetric F; one isotropic stretch for laws with mean stress alone."""
    places, D = _diagonal(scene), scene.dimension
    if _mean_alone(scene, name):
        return [Unknown(places, None)]
    pairs = ((0, 1), (1, 2), (0, 2))[: {1: 0, 2: 1, 3: 3}[D]]
    shears = [
        Unknown([i * D + j, j * D + i], 3 + k, diagonal=False) for k, (i, j) in enumerate(pairs)
    ]
    return [*(Unknown([place], d) for d, place in enumerate(places)), *shears]


def find_deformation(
    scene: Scene,
    some: tuple[Particles, np.ndarray],
    name: str,
    wanted: np.ndarray,
    unknowns: list[Unknown],
    words: tuple[str, str],
) -> None:
    """Find the deformation under which the law of a body gives a stress.

    Newton's method, particle by particle.

    Parameters
    ----------
    some : (Particles, (n,) int64)
        Particles, and the rows of the body.
    name : str
        The body.
    wanted : (n, components) float64
        The stress.
    unknowns : list of Unknown
        What of the deformation is looked for.
    words : (str, str)
        What the stress is from, and advice, for the error.

    Raises
    ------
    CaseError
        If there is none.
    """
    p, rows = some
    D, law = scene.dimension, scene.case.materials[scene.case.bodies[name].material]
    one = np.array(identity(D, scene.case.axisymmetric))
    setting, found = scene.setting.without_shape(), np.empty_like(wanted)

    def goal(sigma: np.ndarray) -> np.ndarray:
        if unknowns[0].component is None:
            return np.asarray(sigma[:, :3].mean(axis=1))[:, None]
        return np.stack([sigma[:, each.component] for each in unknowns], axis=1)

    def missing(u: np.ndarray) -> np.ndarray:
        F = np.tile(one, (len(rows), 1))
        for k, each in enumerate(unknowns):
            F[:, each.entries] = np.exp(u[:, k, None]) if each.diagonal else u[:, k, None]
        p.F[rows] = F
        bearable_stress(setting, p, rows, found)
        return goal(found) - goal(wanted)

    n = len(unknowns)
    u, scale = np.zeros((len(rows), n)), np.abs(wanted).max(axis=1, initial=0.0)
    best, at_best, going = np.full(len(rows), np.inf), u.copy(), np.ones(len(rows), bool)
    for _ in range(_STEPS):
        error = missing(u)
        size = np.abs(error).max(axis=1, initial=0.0)
        better = (size < best) & going
        best[better], at_best[better] = size[better], u[better]
        going &= better  # each particle by itself: bits do not depend on the others
        if not going.any():
            break
        slope = np.empty((len(rows), n, n))
        for k in range(n):
            moved = u.copy()
            moved[:, k] += _CHANGE
            slope[:, :, k] = (missing(moved) - error) / _CHANGE
        singular = ~(np.abs(np.linalg.det(slope)) > 0.0)
        slope[singular] = np.eye(n)
        step = np.linalg.solve(slope, error[:, :, None])[:, :, 0]
        step[singular] = 0.0
        u = u - np.clip(step, -0.2, 0.2)
    missing(at_best)
    if (best > _MISSING * scale).any():
        worst = int(np.argmax(best - _MISSING * scale))
        raise CaseError(
            f"start.stress: '{name}' has no deformation with the stress of {words[0]}, "
            f"{scale[worst]:.3g}, {words[1]}"
        )
    if not law.CARRIES_STRESS:
        p.sigma[rows] = found
    p.V0[rows] = p.V[rows] / volume_ratio(p.F[rows], D)
    for i, traction in enumerate(scene.interaction.loads.tractions):  # whose areas are current
        p.patch[rows, i] /= face_stretches(p.F[rows], traction.axis, D)
    if p.surface_F_correction.shape[1]:  # nothing has moved
        square = p.F[rows, : D * D].reshape(-1, D, D)
        p.surface_F_correction[rows, : D * D] = np.linalg.inv(square).reshape(-1, D * D)
        p.surface_F_correction[rows, D * D :] = 1.0 / p.F[rows, D * D :]
