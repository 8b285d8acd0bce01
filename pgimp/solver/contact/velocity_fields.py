"""Assignment of velocity fields: bodies that cannot touch before the next search share one.

A body has a separate field only near possible partners, so that distant bodies, or a hundred
grains, need a handful of fields. Bodies in one field have no common vertices. Their distances are
minima and maxima over all ranks, independent of any order.

Sums over fields, and sweeps over their pairs, go in the order of fields: other fields, other bits.
So they are state, see `NoContact.assignment`.
"""

from __future__ import annotations

import numpy as np

from pgimp.kernels.contact.colouring import (
    bound_bodies,
    colour_bodies,
    find_margin,
    find_neighbours,
)
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.scene.domain import Domain
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown

#: Cells by which bodies may move between two searches, each out of its box: at least, and at most.
#: In a step it is one, or the run ends. Of the last step it is not yet known when the next begins.
MARGIN, MOST = 1.5, 8.0

#: Cells by which boxes reach beyond a periodic domain, as its particles may.
_FAR = 4.0


def body_boxes(
    domain: Domain, particles: Particles, rows: np.ndarray, bodies: int, comm: Communicator
) -> np.ndarray:
    """Least and greatest coordinates of each body's particles, (2, bodies, D) in cells; collective.

    Bodies without particles have infinite ones. Where the domain is periodic, boxes have all of it:
    bodies may be near across the seam.
    """
    frame = domain.frame
    boxes = np.full((2, bodies, len(frame.cell)), np.inf)
    boxes[1] = -np.inf
    bound_bodies(particles.x, particles.body, rows, boxes)
    boxes = (boxes - np.array(frame.origin)) * np.array(frame.inverse)
    if comm.size > 1:
        every = np.array(comm.allgather(boxes))
        boxes = np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])
    there = np.isfinite(boxes[0, :, 0])
    for d, joined in enumerate(domain.periodic):
        if joined:
            boxes[0, there, d], boxes[1, there, d] = -_FAR, frame.cells[d] + _FAR
    return boxes


def reach(scene: Scene) -> float:
    """Distance in cells from which two particles have no common vertex along a direction."""
    half = (
        scene.settings.vertices - 2.0 if scene.settings.follows else max(scene.settings.shape.half)
    )
    return 2.0 * (1.0 + half) + 1e-6


def neighbours(boxes: np.ndarray, wide: float) -> np.ndarray:
    """Find the bodies whose boxes are less than `wide` cells apart.

    Parameters
    ----------
    boxes : (2, bodies, D) float64
        See `body_boxes`.
    wide : float
        `reach`, and twice by how much bodies may move.

    Returns
    -------
    (pairs, 2) int64
        The lower number first.
    """
    axis, order = _sweep(boxes)
    pairs, found = grown(
        8 * boxes.shape[1],
        lambda size: np.empty((size, 2), np.int64),
        lambda pairs: find_neighbours(boxes, wide, axis, order, pairs),
    )
    return pairs[:found]


def margin_of(boxes: np.ndarray, reach: float, fields: tuple[int, ...]) -> float:
    """Cells by which bodies may move, each out of its box, until those of a field may meet."""
    return find_margin(boxes, reach, MOST, *_sweep(boxes), np.array(fields, np.int64))


def assign(boxes: np.ndarray, reach: float) -> tuple[int, ...]:
    """Fields of bodies by greedy colouring: those that may meet soon have different ones."""
    pairs, count = neighbours(boxes, 2.0 * MARGIN + reach), boxes.shape[1]
    fields, scratch = np.zeros(count, np.int64), np.zeros(2 * count + len(pairs) + 2, np.int64)
    colour_bodies(pairs, scratch, fields)
    return tuple(fields.tolist())


def where_near(boxes: np.ndarray, wide: float, fields: tuple[int, ...]) -> np.ndarray:
    """Find where bodies less than `wide` apart may meet: ends of intervals along x, (pairs, 2)."""
    pairs = neighbours(boxes, wide)
    number = np.array(fields)[pairs]
    low, high = boxes[:, pairs[number[:, 0] != number[:, 1]], 0]
    return np.stack([low.max(axis=1) - 0.5 * wide, high.min(axis=1) + 0.5 * wide], axis=1)


def _sweep(boxes: np.ndarray) -> tuple[int, np.ndarray]:
    """Axis along which the bodies reach farthest, and their order by their lower ends there."""
    reached = boxes[1].max(axis=0) - boxes[0].min(axis=0)
    axis = int(reached.argmax())
    return axis, boxes[0, :, axis].argsort(kind="stable")
