"""Sums of bodies over the particles of all ranks, with masses that are rounded once."""

from __future__ import annotations

from collections.abc import Collection
from math import frexp, ldexp

import numpy as np

from pgimp.kernels.data.arguments import Order
from pgimp.kernels.sums.sums import HIGH, LOW, MASS, exact_masses
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.layer_sums import sum_layers
from pgimp.solver.rank_state import RankState


def _mass(sums: np.ndarray, unit: float) -> float:
    """Mass in rows of `exact_masses`, rounded once."""
    high, low = (sum(map(int, column)) for column in sums.T)
    return ldexp(float((high << LOW) + low), -LOW) / unit


def own_sums(
    rank: RankState, scene: Scene, order: Order, bodies: Collection[int] | None = None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Sums by layer and body of some particles of a rank, their masses, and the masses' unit."""
    sums = np.zeros((rank.slab.layers, len(scene.body_names), scene.materials.sums))
    sum_layers(rank, scene, order, sums, bodies)
    masses = np.zeros((len(scene.body_names), 2), np.int64)
    unit = 2.0 ** (HIGH - 2 - frexp(scene.materials.most_mass)[1])  # see `put_in_order`
    exact_masses(rank.population.columns, order.rows, unit, masses)
    return sums, masses, unit


def reduced(
    sums: list[np.ndarray], masses: list[np.ndarray], unit: float
) -> tuple[np.ndarray, float]:
    """Sums by body over the layers of all ranks, and the mass of all."""
    bodies = np.add.reduce(np.concatenate(sums), axis=0)
    every = np.stack(masses)  # by rank and body
    bodies[:, MASS] = [_mass(every[:, body], unit) for body in range(len(bodies))]
    return bodies, _mass(every.reshape(-1, 2), unit)


def sums_of_bodies(
    rank: RankState, scene: Scene, order: Order, bodies: Collection[int] | None = None
) -> np.ndarray:
    """Sums by body of some particles, as in `layer_sums`, on rank 0; collective.

    Parameters
    ----------
    rank : RankState
        The rank with the particles.
    scene : Scene
        The scene with the parameters.
    order : Order
        The particles, by layer.
    bodies : collection of int, optional
        Whose particles these are, if not all.

    Returns
    -------
    (bodies, columns) float64
        Zeros except on rank 0.
    """
    sums, masses, unit = own_sums(rank, scene, order, bodies)
    parts = rank.comm.gather((sums, masses))
    if parts is None:
        return np.zeros((len(scene.body_names), scene.materials.sums))
    return reduced([part[0] for part in parts], [part[1] for part in parts], unit)[0]
