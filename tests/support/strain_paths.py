"""Materials along paths of deformation, without a grid."""

import numpy as np
from material_driver import COMPONENTS, row

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import read, write
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.base import evaluate, state_width, states_of
from pgimp.physics.materials.outside import parameters_of


@kernel
def march(materials, F, L, dt, rows, energies, like, components, remembered):
    """Fill the rows of stress and state after each step, and the energy and what is lost."""
    for k in range(len(F)):
        f = read(F, k, 0, like)
        sigma = read(rows, k, 0, components)
        state = read(rows, k, len(components), remembered)
        args = (f, determinant(f), sigma, read(L, k, 0, like), dt)
        found = evaluate("stress", materials, 0, args, state)
        write(rows, k + 1, 0, found)
        args, state = (f, determinant(f), found[: len(components)]), found[len(components) :]
        energies[k, 0] = evaluate("energy", materials, 0, args, state)
        losses = evaluate("losses", materials, 0, args, state)
        energies[k, 1] = losses[0] + losses[1]


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
    parameters = parameters_of(material, D)
    before = np.concatenate([np.eye(D)[None], F[:-1]])
    L = (F @ np.linalg.inv(before) - np.eye(D)) / dt
    kept = F
    if material.VOLUME_ONLY:
        kept = np.eye(D) * np.linalg.det(F)[:, None, None] ** (1 / D)
    width = COMPONENTS[D]
    rows = np.zeros((n + 1, width + state_width(type(parameters), D)))
    rows[0, :3] = -material.initial_pressure
    place, names = width, {}
    for state in states_of(type(parameters)):
        last = place + state.width(D)
        start = state.initial
        rows[0, place:last] = getattr(parameters, start) if isinstance(start, str) else start
        names[state.name] = slice(place, last)
        place = last
    energies = np.zeros((n, 2))
    march(
        (parameters,), kept.reshape(n, -1), L.reshape(n, -1), dt, rows, energies,
        row(np.eye(D)), (0.0,) * width, (0.0,) * (place - width),
    )  # fmt: skip
    found = {name: rows[1:, part].squeeze(-1) if part.stop - part.start == 1 else rows[1:, part]
             for name, part in names.items()}  # fmt: skip
    found["stress"] = np.zeros((n, 6))
    found["stress"][:, :width] = rows[1:, :width]
    J = np.concatenate([[1.0], np.linalg.det(F)])[:, None]
    middle = 0.5 * (J[1:] * rows[1:, :width] + J[:-1] * rows[:-1, :width])
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
