"""Assignment of velocity fields: bodies that cannot touch within the next steps share one.

A body has a separate field only near possible partners, so that distant bodies, or a hundred
grains, need a handful of fields. Sharing changes no bit: bodies in one field have no common
vertices. Their distances are minima and maxima over all ranks, independent of any order.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.kernels.contact.lagrangian.boxes import grow_boxes
from pgimp.kernels.data.frame import Frame
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene

#: Least number of steps without contact for bodies that share a field, and the most before the next
#: search. In a step a particle moves by a cell at most, or the run ends.
FEWEST, MOST = 2, 64

#: The most steps with several fields: between two searches bodies may move by as many cells, and
#: planes are searched that far around them.
NEAR = 16


def body_boxes(
    frame: Frame, particles: Any, rows: np.ndarray, bodies: int, comm: Communicator
) -> Any:
    """Least and greatest coordinates of each body's particles, (2, bodies, D) in cells; collective.

    Bodies without particles have infinite ones.
    """
    boxes = np.full((2, bodies, len(frame.cell)), np.inf)
    boxes[1] = -np.inf
    grow_boxes(frame, particles, rows, boxes)
    if comm.size > 1:
        every = np.array(comm.allgather(boxes))
        boxes = np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])
    return boxes


def reach(scene: Scene) -> float:
    """Distance in cells from which two particles have no common vertex along a direction."""
    half = scene.vertices - 2.0 if scene.follows else max(scene.shape.half)
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
    if not any(fields):
        return np.empty((0, 2))
    low, high = boxes
    first, second = np.triu_indices(len(fields), 1)
    own = np.array(fields)
    differ = own[first] != own[second]
    first, second = first[differ], second[differ]
    wide = 2.0 * steps + reach
    near = np.ones(len(first), bool)
    for d in range(low.shape[1]):
        near &= low[first, d] - high[second, d] < wide
        near &= low[second, d] - high[first, d] < wide
    first, second = first[near], second[near]
    ends = np.stack(
        [np.maximum(low[first, 0], low[second, 0]), np.minimum(high[first, 0], high[second, 0])],
        axis=1,
    )
    return ends + 0.5 * wide * np.array([-1.0, 1.0])


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
    low, high = boxes
    count = len(low)
    apart = np.full((count, count), -np.inf)
    with np.errstate(invalid="ignore"):  # bodies without particles
        for d in range(low.shape[1]):
            np.maximum(apart, low[:, None, d] - high[None, :, d], out=apart)
    apart = np.maximum(apart, apart.T)
    apart[np.isnan(apart)] = np.inf
    # Steps until they may have a common vertex.
    alone = np.floor(0.5 * np.maximum(apart - reach, 0.0))
    fields, steps = np.zeros(count, np.int64), MOST
    for b in range(count):
        before, near = fields[:b], alone[b, :b]
        taken = set(before[near < FEWEST].tolist())
        own = next(f for f in range(b + 1) if f not in taken)
        steps = min(steps, int(near[before == own].min(initial=MOST)))
        fields[b] = own
    return tuple(fields.tolist()), min(steps, NEAR) if fields.any() else steps
