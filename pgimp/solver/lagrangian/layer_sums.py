"""Sums over a rank's particles by layer, with what vertices have that keep their motion."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.lagrangian.sums import motion_sums
from pgimp.kernels.sums.sums import KINETIC, layer_sums
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.pieces import by_layers
from pgimp.solver.rank_state import RankState


def sum_layers(
    rank: RankState,
    scene: Scene,
    order: Order,
    sums: np.ndarray,
    bodies: Collection[int] | None = None,
) -> None:
    """Add `layer_sums` of some of a rank's particles, and what vertices have beyond them.

    Parameters
    ----------
    scene : Scene
        The scene of the particles.
    order : Order
        The particles, by layer.
    sums : (layers, bodies, columns) float64
    bodies : collection of int, optional
        Whose particles these are, if not all.
    """
    by_layers(
        rank, order,
        lambda particles, order: layer_sums(scene.setting.without_shape(), particles, order, sums),
        lambda particles, order: _complete_sums(rank, scene, particles, order, sums),
    )  # fmt: skip
    if rank.slaves:
        rank.slaves.complete_sums(rank, bodies, _lumped(rank), sums)


def _lumped(rank: RankState) -> np.ndarray | tuple[()]:
    """Part of the lumped mass by body, (bodies,); () if it is all."""
    return rank.averaged_mass.lumped if rank.averaged_mass else ()


def energy_beyond_lumped(rank: RankState) -> np.ndarray:
    """Kinetic energy of the averaged mass less that of the lumped one, by layer, (layers,)."""
    scene = rank.scene
    sums = np.zeros((rank.slab.layers, len(scene.body_names), scene.materials.sums))
    part = rank.averaged_mass.lumped - 1.0
    by_layers(
        rank, rank.population.ordered,
        lambda particles, order: _complete_sums(rank, scene, particles, order, sums, part),
    )  # fmt: skip
    if rank.slaves:
        rank.slaves.complete_sums(rank, None, part, sums)
    return np.asarray(sums[:, :, KINETIC].sum(axis=1))


def _complete_sums(
    rank: RankState, scene: Scene, particles: Particles, order: Order, sums: np.ndarray,
    part: np.ndarray | tuple[()] | None = None,
) -> None:  # fmt: skip
    """Complete `layer_sums` of particles by what their vertices have beyond them, or by a part."""
    if scene.settings.lagrangian_bodies is None or not rank.grid.motion:
        return
    setting = scene.setting
    if scene.settings.mixed:
        mine = scene.settings.lagrangian[particles.body[order.rows]]
        edges = np.concatenate([[0], np.cumsum(mine)])[order.start]
        order, setting = Order(order.rows[mine], edges), scene.setting_lagrangian
    if part is None:
        part = _lumped(rank)
    motion_sums(setting.without_materials(), rank.grid.field, particles, order, part, sums)
