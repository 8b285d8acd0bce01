"""Bonded bodies in the initial configuration, and the interaction of others."""

from __future__ import annotations

import numpy as np

from pgimp.kernels.contact.lagrangian.filled import ANYWHERE, NEVER, WHERE_FILLED
from pgimp.kernels.contact.lagrangian.pairs import SeparatingWalls
from pgimp.kernels.contact.lagrangian.reference_grid import FACE_PLANE
from pgimp.physics.contact.base import TIED, UNILATERAL
from pgimp.physics.contact.friction import CoulombParameters, coefficients
from pgimp.physics.contact.pairs import Pairs
from pgimp.scene.scene import Scene


def with_walls(scene: Scene) -> Pairs:
    """The law of each pair; unilateral walls are numbered after all bodies."""
    letting = [face for face in scene.domain.faces if face.condition.approaches]
    names = [*scene.body_names, *scene.interaction.rigid_bodies.names]
    pairs = scene.interaction.pairs or Pairs.of((), names)
    n, m, known = len(scene.body_names), len(names), len(pairs.way)
    entry = np.zeros((m + len(letting),) * 2, np.int64)
    entry[:m, :m] = pairs.entry
    entry[:n, m:] = known + 1 + np.arange(len(letting))
    given = [coefficients(getattr(face.condition, "friction", 0.0)) for face in letting]
    parameters = np.zeros((len(letting), pairs.parameters.shape[1]))
    parameters[:, :2] = np.array(given, float).reshape(-1, 2)
    coulomb = [type(kind) for kind in pairs.kinds].index(CoulombParameters)
    return Pairs(
        entry,
        np.concatenate([pairs.way, np.full(len(letting), UNILATERAL)]),
        pairs.kinds,
        np.concatenate([pairs.kind, np.full(len(letting), coulomb)]),
        np.concatenate([pairs.parameters, parameters]),
        np.concatenate([pairs.adhesion, np.zeros((len(letting), 3))]),
    )


def separating_walls(scene: Scene) -> SeparatingWalls:
    """Unilateral walls, numbered after all bodies; see `with_walls`."""
    frame = scene.domain.frame
    letting = [(n, face) for n, face in enumerate(scene.domain.faces) if face.condition.approaches]
    planes = [
        (face.axis, face.side, frame.ghost + (face.side > 0) * frame.cells[face.axis], n, False)
        for n, face in letting
    ]
    first = len(scene.body_names) + len(scene.interaction.rigid_bodies)
    return SeparatingWalls(first, np.array(planes, FACE_PLANE))


def bonded(
    pairs: Pairs, low: np.ndarray, high: np.ndarray, reach: np.ndarray, lagrangian: np.ndarray
) -> tuple[tuple[int, ...], np.ndarray]:
    """Fields and groups of bodies by their initial boxes, in cells.

    Bodies under the law `tied` with common vertices there are one group. Others with common
    vertices have different fields, as few as possible. Bodies in the current configuration (not
    `lagrangian`) move over the grid: tied ones are one group, and each group has its own field.

    `colour_bodies` colours single bodies, whose boxes move: it compares pairs without a matrix of
    them, and finds the steps for which that holds. Groups keep their vertices and fields until the
    next stage, and are no boxes: one may surround a body that it does not touch.
    """
    n = len(low)
    apart = np.full((n, n), -np.inf)
    for d in range(low.shape[1]):
        np.maximum(apart, low[:, None, d] - high[None, :, d] - reach[d], out=apart)
    touch = np.maximum(apart, apart.T) < 1e-6
    group = np.arange(n)
    for a in range(n):
        for b in range(a + 1, n):
            entry = abs(int(pairs.entry[a, b]))
            if not entry or pairs.way[entry - 1] != TIED or lagrangian[a] != lagrangian[b]:
                continue
            if touch[a, b] or not lagrangian[a]:
                group[group == group[b]] = group[a]
    touch &= np.logical_and.outer(lagrangian, lagrangian)
    _, group = np.unique(group, return_inverse=True)
    fields = np.zeros(n, np.int64)
    done: list[int] = []
    for one in range(int(group.max()) + 1):
        mine = group == one
        taken = {
            int(fields[b]) for b in np.flatnonzero(touch[mine].any(axis=0)) if group[b] in done
        }
        if lagrangian[mine].all():
            fields[mine] = next(f for f in range(n + 1) if f not in taken)
            done.append(one)
    for one in np.unique(group[~lagrangian]):
        fields[group == one] = fields.max() + 1
    return tuple(fields.tolist()), group.astype(np.int64)


def acting(pairs: Pairs, groups: np.ndarray, bodies: int) -> set[tuple[int, int]]:
    """Return the pairs of groups that act on each other."""
    found = set()
    for a in range(bodies):
        for b in range(a + 1, bodies):
            if pairs.entry[a, b] != 0 and groups[a] != groups[b]:
                found.add((int(min(groups[a], groups[b])), int(max(groups[a], groups[b]))))
    return found


def interactions(pairs: Pairs, groups: np.ndarray, rigid_bodies: int) -> np.ndarray:
    """How groups act on each other and on rigid bodies, see `keep_possible`."""
    count, n = 1 + int(groups.max()), len(groups)
    acts = np.full((count, count + rigid_bodies), NEVER)
    for a in range(n):
        for b in range(n + rigid_bodies):
            entry = abs(int(pairs.entry[a, b]))
            if entry == 0 or a == b:
                continue
            way = WHERE_FILLED if pairs.way[entry - 1] == UNILATERAL else ANYWHERE
            other = groups[b] if b < n else count + b - n
            acts[groups[a], other] = max(acts[groups[a], other], way)
    return acts
