"""Bonded bodies in the initial configuration, and unilateral walls."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from pgimp.geometry.sweep import close_pairs
from pgimp.kernels.contact.impulses.pairs import SeparatingWalls
from pgimp.kernels.contact.impulses.reference_grid import FACE_PLANE
from pgimp.physics.contact.base import TIED, UNILATERAL
from pgimp.physics.contact.friction import CoulombParameters, coefficients
from pgimp.physics.contact.pairs import Pairs
from pgimp.scene.scene import Scene


def with_walls(scene: Scene) -> Pairs:
    """The law of each pair; unilateral walls are numbered after all bodies."""
    letting = [face for face in scene.domain.faces if face.condition.approaches]
    names = [*scene.body_names, *scene.interaction.rigid_bodies.names]
    pairs = scene.interaction.pairs or Pairs.of((), names)
    n, m, known = len(scene.body_names), len(names), len(pairs.kind)
    entry = np.zeros((m + len(letting),) * 2, np.int16)
    entry[:m, :m] = pairs.entry
    entry[:n, m:] = known + 1 + np.arange(len(letting))
    given = [coefficients(getattr(face.condition, "friction", 0.0)) for face in letting]
    parameters = np.zeros((len(letting), pairs.parameters.shape[1]))
    parameters[:, :2] = np.array(given, float).reshape(-1, 2)
    coulomb = [type(kind) for kind in pairs.laws].index(CoulombParameters)
    return Pairs(
        entry,
        np.concatenate([pairs.kind, np.full(len(letting), UNILATERAL)]),
        pairs.laws,
        np.concatenate([pairs.law, np.full(len(letting), coulomb)]),
        np.concatenate([pairs.parameters, parameters]),
        np.concatenate([pairs.adhesion, np.zeros((len(letting), 3))]),
    )


def separating_walls(scene: Scene) -> SeparatingWalls:
    """Unilateral walls, numbered after all bodies; see `with_walls`."""
    frame = scene.domain.frame
    letting = [(n, face) for n, face in enumerate(scene.domain.faces) if face.condition.approaches]
    planes = [
        (face.axis, face.side, frame.ghost + (face.side > 0) * frame.cells[face.axis], n)
        for n, face in letting
    ]
    first = len(scene.body_names) + len(scene.interaction.rigid_bodies)
    return SeparatingWalls(first, np.array(planes, FACE_PLANE))


def bonded(
    pairs: Pairs,
    low: np.ndarray,
    high: np.ndarray,
    reach: np.ndarray,
    lagrangian: np.ndarray,
    beyond: float = 0.0,
    cells: Sequence[int] = (),
) -> tuple[tuple[int, ...], np.ndarray]:
    """Fields and groups of bodies by their initial boxes, in cells.

    Bodies under the law `tie` with common vertices there are one group. Others with common
    vertices have different fields, as few as possible; so have those up to `beyond` cells farther
    apart, where a vertex may be the slave of a cell some cells away. Bodies in the current
    configuration (not `lagrangian`) move over the grid: tied ones are one group, and each group has
    its own field. `cells` are those of the domain by direction, 0 where it is not periodic.

    `colour_bodies` colours single bodies, whose boxes move, and finds the steps for which that
    holds. Groups keep their vertices and fields until the next stage, and are no boxes: one may
    surround a body that it does not touch.
    """
    n = len(low)
    ways = [(0.0, -k, k) if k else (0.0,) for k in map(float, cells or [0] * low.shape[1])]
    images = np.array([*product(*ways)])
    low, high = ((images[:, None] + each).reshape(-1, low.shape[1]) for each in (low, high))
    near = close_pairs(low, high, reach + beyond + 2e-6)
    apart = np.full(len(near), -np.inf)
    for d in range(low.shape[1]):
        for one, other in (near.T, near.T[::-1]):
            np.maximum(apart, low[one, d] - high[other, d] - reach[d], out=apart)
    near = np.sort(near % n, axis=1)
    some = (apart < beyond + 1e-6) & (near[:, 0] != near[:, 1])
    near, number = np.unique(near[some], axis=0, return_inverse=True)
    least = np.full(len(near), np.inf)
    np.minimum.at(least, number.reshape(-1), apart[some])
    apart = least
    group = np.arange(n)
    for a, b in _tied(pairs, near[apart < 1e-6], lagrangian).tolist():
        if group[a] != group[b]:
            group[group == group[b]] = group[a]
    _, group = np.unique(group, return_inverse=True)
    beside: list[list[int]] = [[] for _ in range(n)]
    for a, b in near[lagrangian[near].all(axis=1)].tolist():
        beside[a].append(b)
        beside[b].append(a)
    fields = np.zeros(n, np.int64)
    mine = np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))[:-1])
    done = np.zeros(len(mine), bool)
    for one, members in enumerate(mine):
        if not lagrangian[members].all():
            continue
        taken = {int(fields[b]) for a in members for b in beside[a] if done[group[b]]}
        fields[members] = next(f for f in range(n + 1) if f not in taken)
        done[one] = True
    for one in np.unique(group[~lagrangian]):
        fields[group == one] = fields.max() + 1
    return tuple(fields.tolist()), group.astype(np.int64)


def _tied(pairs: Pairs, near: np.ndarray, lagrangian: np.ndarray) -> np.ndarray:
    """Tied pairs of bodies of one configuration, ascending; of the initial one only `near` ones."""
    n, tied = len(lagrangian), np.flatnonzero(pairs.kind == TIED) + 1
    found = [near[np.isin(np.abs(pairs.entry[near[:, 0], near[:, 1]]), tied)]]
    found[0] = found[0][lagrangian[found[0]].all(axis=1)]
    current = np.flatnonzero(~lagrangian)
    for a in current.tolist():
        others = current[current > a]
        some = others[np.isin(np.abs(pairs.entry[a, others]), tied)]
        found.append(np.stack([np.full(len(some), a), some], axis=1))
    every = np.concatenate(found).reshape(-1, 2)
    return every[np.lexsort(every.T[::-1])] if n else every
