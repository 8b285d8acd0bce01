"""Materials along paths of deformation, without a grid, and where their work goes."""

from typing import NamedTuple

import numpy as np
from material_driver import COMPONENTS, row

import pgimp
from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import read
from pgimp.kernels.update.stress import state_of
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.base import states_of
from pgimp.physics.materials.parameters.evaluate import evaluate
from pgimp.physics.materials.parameters.outside import parameters_of


@kernel
def energies_of(materials, F, stress, remembered, energies, like, components):
    """Fill energy and what is lost, (n, 2), from F, stress and state, as of particles."""
    for k in range(len(F)):
        f = read(F, k, 0, like)
        args = (f, determinant(f), read(stress, k, 0, components))
        state = state_of(materials, remembered, k, f)
        energies[k, 0] = evaluate("energy", materials, 0, args, state)
        losses = evaluate("losses", materials, 0, args, state)
        energies[k, 1] = losses[0] + losses[1]


class Remembered(NamedTuple):
    """What `state_of` wants of particles."""

    state: np.ndarray


def entry_of(entry):
    """An entry as in a case, with a density."""
    return MATERIALS[entry["model"]].model_validate({"density": 1.0} | entry)


def along(entry, F, dt=1.0):
    """What a material does along a path.

    Parameters
    ----------
    entry : dict
        As in a case; a density of 1 need not be given.
    F : (n, D, D) float64
        Deformation gradients at the end of each step.

    Returns
    -------
    dict
        ``stress`` (n, 6), state variables by name (n,) or (n, components), ``energy`` and ``lost``
        per initial volume, and ``work`` of the mean stress of each step, all summed up (n,).
    """
    material = entry_of(entry)
    F = np.asarray(F, float)
    n, D = F.shape[:2]
    found = pgimp.element(material, F, dt)
    parameters, width = parameters_of(material, D), COMPONENTS[D]
    columns = [found[state.name].reshape(n, -1) for state in states_of(type(parameters))]
    state = np.hstack([np.zeros((n, 0)), *columns])
    kept = F
    if material.VOLUME_ONLY:
        kept = np.eye(D) * np.linalg.det(F)[:, None, None] ** (1 / D)
    energies, stress = np.zeros((n, 2)), np.ascontiguousarray(found["stress"][:, :width])
    energies_of(
        (parameters,), kept.reshape(n, -1), stress, Remembered(state), energies, row(np.eye(D)),
        (0.0,) * width,
    )  # fmt: skip
    before = np.concatenate([np.eye(D)[None], F[:-1]])
    L = (F @ np.linalg.inv(before) - np.eye(D)) / dt
    rows = np.zeros((n + 1, width))
    rows[0, :3] = -material.initial_pressure
    rows[1:] = stress
    J = np.concatenate([[1.0], np.linalg.det(F)])[:, None]
    middle = 0.5 * (J[1:] * rows[1:] + J[:-1] * rows[:-1])
    G = L @ np.linalg.inv(np.eye(D) + 0.5 * dt * L)
    power = np.zeros(n)
    for i, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))):
        if i < width and max(a, b) < D:
            power += middle[:, i] * (G[:, a, a] if a == b else G[:, a, b] + G[:, b, a])
    return found | {
        "energy": energies[:, 0], "lost": energies[:, 1], "work": dt * np.cumsum(power)
    }  # fmt: skip


def invariants(stress):
    """Pressure p and the root of J2 of stresses (n, 6)."""
    p = -stress[:, :3].mean(axis=1)
    s = stress.copy()
    s[:, :3] += p[:, None]
    return p, np.sqrt(0.5 * ((s[:, :3] ** 2).sum(axis=1) + 2.0 * (s[:, 3:] ** 2).sum(axis=1)))


def stretches(*ends, steps=20):
    """Gradients along a chain of diagonal ones, by the logarithms of their stretches."""
    path, last = [], np.zeros(len(ends[0]))
    for end in ends:
        end = np.asarray(end, float)
        path += [last + (end - last) * k / steps for k in range(1, steps + 1)]
        last = end
    return np.array([np.diag(np.exp(each)) for each in path])


def shears(rate, dt, steps, D=2, J=1.0):
    """Gradients of steady simple shear along x by y, of a body with the volume J."""
    F = np.tile(np.eye(D), (steps, 1, 1))
    F[:, 0, 1] = rate * dt * np.arange(1, steps + 1)
    return J ** (1 / D) * F


def random_walk(rng, steps, size, D=3):
    """Gradients that random small steps lead to."""
    path = [np.eye(D)]
    for _ in range(steps):
        path.append((np.eye(D) + size * rng.normal(size=(D, D))) @ path[-1])
    return np.array(path[1:])
