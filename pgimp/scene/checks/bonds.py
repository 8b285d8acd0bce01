"""Bodies that share vertices of the grid from the start, and so act as one."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.motion.moving_boxes import TOUCH, moving_boxes
from pgimp.scene.checks.nearness import NAMED, ranged, reach, sticking

if TYPE_CHECKING:
    from pgimp.scene.bodies.lattice import Lattice
    from pgimp.scene.scene import Scene

#: Most cells, where two bodies may meet, for a comparison cell by cell.
_MOST_CELLS = 20_000_000
#: Most pairs of bodies for that comparison, each in some hundredths of a second.
_MOST_PAIRS = 100


def bonded(scene: Scene, lattice: Lattice, counts: np.ndarray, touching: bool) -> Iterator[str]:
    """Yield a message on bodies that share vertices of the grid from the start, but no cell.

    Bodies that touch are meant to act as one; those with a gap between them surprise. Bodies that
    share a cell are in the notes of `pgimp.scene.bodies.counts`.

    Parameters
    ----------
    lattice, counts
        See `count_particles`.
    touching : bool
        Whether bodies are meant that touch; else those that do not.
    """
    case = scene.case
    boxes = moving_boxes(case, np.array([0.0, case.time.end]))
    cell, origin = np.array(scene.domain.frame.cell), np.array(scene.domain.frame.origin)
    # A cut particle reaches farther, by half a particle at most.
    near = reach(case) + 1.0 / np.array(lattice.per_cell)
    lows, highs = (np.array([getattr(box, end)[0] for box in boxes]) for end in ("low", "high"))
    found: list[str] = []
    shared = sticking(case)
    for i, j in _close(lows, highs, near * cell):
        if len(found) > NAMED:
            break
        if not shared[i, j]:
            continue
        low, high = np.maximum(lows[i], lows[j]), np.minimum(highs[i], highs[j])
        # Cells in which particles of both bodies may share vertices.
        first = np.floor((np.minimum(low, high) - origin) / cell - near).astype(int)
        shape = np.ceil((np.maximum(low, high) - origin) / cell + near).astype(int) - first
        if shape.prod() > _MOST_CELLS:
            continue
        cells, vertices = zip(
            *(_marks(scene, lattice, counts, body, first, shape) for body in (i, j)), strict=True
        )
        if (vertices[0] & vertices[1]).any() and not (cells[0] & cells[1]).any():
            if touching == (_gap(scene, lattice, counts, (i, j), first, shape) < TOUCH):
                found.append(f"'{boxes[i].name}' and '{boxes[j].name}'")
    if found and touching:
        more = " and others" if len(found) > NAMED else ""
        yield (
            f"bodies {', '.join(found[:NAMED])}{more} touch at the start: they act as one, in "
            "tension and shear too"
        )
    elif found:
        more = " and others" if len(found) > NAMED else ""
        yield (
            f"bodies: {', '.join(found[:NAMED])}{more} share vertices of the grid from the start: "
            "they are bonded there, in tension and shear too; bodies move by themselves while they "
            f"are {ranged(reach(case))} cells apart or more"
        )


def _close(low: np.ndarray, high: np.ndarray, near: np.ndarray) -> list[tuple[int, int]]:
    """Pairs of boxes within a distance `near` of each other; of many the closest."""
    found = []
    for i in range(len(low)):
        gap = np.maximum(low[i] - high[i + 1 :], low[i + 1 :] - high[i])
        for j in np.flatnonzero((gap <= near).all(axis=1)):
            found.append((float((gap[j] / near).max()), i, i + 1 + int(j)))
    return [(i, j) for _, i, j in sorted(found)[:_MOST_PAIRS]]


def _gap(
    scene: Scene,
    lattice: Lattice,
    counts: np.ndarray,
    pair: tuple[int, int],
    first: np.ndarray,
    shape: np.ndarray,
) -> float:
    """Least gap between two bodies in some cells, over a cell; infinite between particles of files.

    It is the sum of a particle's distances from the surfaces of both, its own being negative.
    """
    own, other = (scene.case.bodies[scene.body_names[body]].region for body in pair)
    least, cell = np.inf, np.array(scene.domain.frame.cell)
    if own.WHOLE_BODY or other.WHOLE_BODY:
        return least
    n = lattice.per_cell[0]
    planes = max(0, int(first[0]) * n), min(lattice.planes, int(first[0] + shape[0]) * n)
    for block in lattice.make(planes, counts, pair[0]):
        x = (block.positions - scene.domain.frame.origin) / cell - first
        near = block.positions[((x >= 0.0) & (x < shape)).all(axis=1)]
        away = own.signed_distance(near) + other.signed_distance(near)
        least = min(least, float(away.min(initial=np.inf) / cell.min()))
    return least


def _marks(
    scene: Scene,
    lattice: Lattice,
    counts: np.ndarray,
    body: int,
    first: np.ndarray,
    shape: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Cells from `first` on with centres of a body's particles, and vertices in their supports."""
    cells, vertices = np.zeros(shape, bool), np.zeros(shape, bool)
    cell, origin, half = (
        scene.domain.frame.cell,
        scene.domain.frame.origin,
        np.array(scene.settings.uncut.half),
    )
    n = lattice.per_cell[0]
    planes = max(0, int(first[0]) * n), min(lattice.planes, int(first[0] + shape[0]) * n)
    for block in lattice.make(planes, counts, body):
        x = (block.positions - origin) / cell - first
        _mark(cells, np.floor(x).astype(int))
        low = np.floor(x - 1.0 - half + TOUCH).astype(int) + 1
        high = np.ceil(x + 1.0 + half - TOUCH).astype(int) - 1
        for step in product(*(range(n) for n in (high - low).max(axis=0) + 1)):
            _mark(vertices, (low + step)[(low + step <= high).all(axis=1)])
    return cells, vertices


def _mark(marks: np.ndarray, cells: np.ndarray) -> None:
    inside = ((cells >= 0) & (cells < marks.shape)).all(axis=1)
    marks[tuple(cells[inside].T)] = True
