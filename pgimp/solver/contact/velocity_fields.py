"""Assignment of velocity fields: bodies that cannot touch within the next steps share one.

A body has a separate field only near possible partners, so that distant bodies, or a hundred
grains, need a handful of fields. Bodies in one field have no common vertices. Their distances are
minima and maxima over all ranks, independent of any order.

Sums over fields, and sweeps over their pairs, go in the order of fields: other fields, other bits.
So they are state, see `NoContact.assignment`.
"""

from __future__ import annotations

import numpy as np

from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.colouring import (
    bound_bodies,
    colour_bodies,
    find_intervals,
    find_neighbours,
)
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.scene.domain import Domain
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown

#: Least number of steps without contact for bodies that share a field, and the most before the next
#: search. In a step a particle moves by a cell at most, or the run ends.
MIN_FIELDS, MAX_FIELDS = 2, 64

#: The most steps with several fields: between two searches bodies may move by as many cells, and
#: planes are searched that far around them.
NEAR = 16

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


def where_near(boxes: np.ndarray, fields: tuple[int, ...], reach: float, steps: int) -> np.ndarray:
    """Find the planes in which bodies of different fields may have common vertices.

    Parameters
    ----------
    boxes, fields, reach, steps
        See `assign`.

    Returns
    -------
    (pairs, 2) float64
        Ends of an interval for each such pair, along x in cells.
    """
    if not needed(any(fields)):
        return np.empty((0, 2))
    numbers, wide, room = np.array(fields, np.int64), 2.0 * steps + reach, 8 * len(fields)
    axis, order = _sweep(boxes)
    ends, found = grown(
        room,
        lambda size: np.empty((size, 2)),
        lambda ends: find_intervals(boxes, numbers, wide, axis, order, ends),
    )
    return ends[:found]


def assign(boxes: np.ndarray, reach: float) -> tuple[tuple[int, ...], int]:
    """Greedy colouring: each body gets the lowest field not used by any body it may touch soon.

    Parameters
    ----------
    boxes : (2, bodies, D) float64
        See `body_boxes`.
    reach : float
        See `reach`.

    Returns
    -------
    fields : tuple of int
        Number of each body's field.
    steps : int
        Steps for which this holds.
    """
    count = boxes.shape[1]
    axis, order = _sweep(boxes)
    pairs, found = grown(
        8 * count,
        lambda size: np.empty((size, 2), np.int64),
        lambda pairs: find_neighbours(boxes, reach, MIN_FIELDS, axis, order, pairs),
    )
    fields, scratch = np.zeros(count, np.int64), np.zeros(2 * count + found + 2, np.int64)
    steps = colour_bodies(boxes, reach, MAX_FIELDS, axis, order, pairs[:found], scratch, fields)
    return tuple(fields.tolist()), min(steps, NEAR) if fields.any() else steps


def _sweep(boxes: np.ndarray) -> tuple[int, np.ndarray]:
    """Axis along which the bodies reach farthest, and their order by their lower ends there."""
    reached = boxes[1].max(axis=0) - boxes[0].min(axis=0)
    axis = int(reached.argmax())
    return axis, boxes[0, :, axis].argsort(kind="stable")
