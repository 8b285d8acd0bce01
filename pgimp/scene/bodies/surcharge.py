"""Surcharge: loads on surfaces that face upwards, which add to the stress of the weight above."""

from __future__ import annotations

import numpy as np

from pgimp.case.start import InitialStress
from pgimp.kernels.data.particles import Particles
from pgimp.scene.scene import Scene


def surcharge(
    scene: Scene, p: Particles, count: int, vertical: tuple[int, float], t: float
) -> np.ndarray:
    """Force along gravity on the top of each of the first `count` particles, (count,).

    `vertical` is the axis of gravity, and its component along it. Loads are those of
    `start.stress.surcharge` at time `t`, on faces and on parts of surfaces whose normal points
    upwards.
    """
    axis, pull = vertical
    stress = scene.case.start.stress
    named = stress.surcharge if isinstance(stress, InitialStress) else ()
    carried = scene.interaction.loads
    on_faces = [name in named for name in carried.on_faces]
    on_parts = [name in named for name in carried.surfaces.entries]
    sign, found = (1.0 if pull > 0.0 else -1.0), np.zeros(count)
    loads, D = scene.interaction.loads.at(t), scene.dimension
    for known, each in zip(on_faces, loads.tractions, strict=True):
        if known and each.axis == axis and each.side * pull < 0.0:
            load = sign * each.traction[axis] + each.pressure
            found += load * p.patch[:count, each.column]
    for known, one in zip(on_parts, loads.surfaces, strict=True):
        if not known:
            continue
        first = one.column
        area, N = p.surface[:count, first], p.surface[:count, first + 1 : first + 1 + D]
        moments = p.surface[:count, first + 1 + D : first + 1 + D + D * D].reshape(-1, D, D)
        g = np.array(one.gradient[:D])
        pressure = one.pressure + p.x[:count] @ g
        force = one.traction[axis] * area - pressure * N[:, axis] - (moments[:, :, axis] @ g)
        if one.profile:
            force *= one.profile.factors(p.x[:count])
        upward = N[:, axis] * pull < 0.0
        if g.any():  # none above the level of a liquid
            square = np.where(upward, (N * N).sum(axis=1), 1.0)
            centroid = np.einsum("njd,nd->nj", moments, N) / square[:, None]
            upward &= pressure + centroid @ g > 0.0
        found += np.where(upward, sign * force, 0.0)
    return found
