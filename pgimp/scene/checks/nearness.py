"""Bodies that stick to each other, or to a wall, because they share a velocity field.

A particle shares vertices of the grid with everything within its reach. The outermost particles
lie half a particle's spacing inside the surface. So the reach between two surfaces is
2 (1 + d) - 1/n cells, 2 with boxes. d is the half-width of chi_p in cells, n the particles a cell.
From a wall the reach is half as large. Pairs of bodies with an entry of `contact` follow its law.
Fluids, gases and grains flow together where they meet; without tension no wall holds them back.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from pgimp.physics.contact.pairs import Pairs, sharing
from pgimp.scene.checks.moving_boxes import (
    TOUCH,
    Box,
    clearance,
    faces_with_condition,
    instants,
    moving_boxes,
)

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.scene.bodies.lattice import Lattice
    from pgimp.scene.scene import Scene

#: Most cells, where two bodies may meet, for a comparison cell by cell.
_MOST_CELLS = 20_000_000
#: Most pairs of bodies for that comparison, each in some hundredths of a second.
_MOST_PAIRS = 100
#: Most pairs that are named; beyond it only their number is given.
_NAMED = 3


def reach(case: Case) -> np.ndarray:
    """Distance within which two surfaces interact, by direction, (D,) in cells."""
    half = np.array(case.method.parameters(tuple(case.grid.cell)).half)
    return 2.0 * (1.0 + half) - 1.0 / np.array(case.method.particles_per_cell)


def warnings(case: Case) -> list[str]:
    """Return warnings of bodies and walls that approach each other; only the case is used.

    Parameters
    ----------
    case : Case
        The case, its meshes and particle files read (`pgimp.scene.geometry.share`).
    """
    boxes = moving_boxes(case, times := instants(case))
    walls = _walls(case, boxes, at_once=True)
    lagrangian = [body.configuration == "initial" for body in case.bodies.values()]
    if not any(lagrangian):
        return [*_pairs(case, boxes, times), *walls, *_rigid(case)]
    alone = [box for box, initial in zip(boxes, lagrangian, strict=True) if initial]
    if not all(lagrangian):
        return [*_held(case, alone), *walls, *_rigid(case)]
    return [*_passing(case, boxes, times), *_held(case, alone), *walls]


def notes(case: Case) -> list[str]:
    """Return notes on bodies that come near walls; as `warnings`."""
    lagrangian = [body.configuration == "initial" for body in case.bodies.values()]
    boxes = moving_boxes(case, instants(case))
    boxes = [box for box, initial in zip(boxes, lagrangian, strict=True) if not initial]
    return list(_walls(case, boxes, at_once=False))


def meet(case: Case) -> bool:
    """Whether bodies that start apart may approach each other, or a wall."""
    boxes = moving_boxes(case, times := instants(case))
    pairs = _pairs_that_meet(case, boxes, times, sharing(case))
    return bool(pairs or [*_walls(case, boxes, at_once=False)])


def _sticking(case: Case) -> np.ndarray:
    """Pairs of bodies that stick together where they meet, as `sharing`, without flowing pairs."""
    flows = np.array([case.materials[body.material].VOLUME_ONLY for body in case.bodies.values()])
    return sharing(case) & ~(flows[:, None] & flows)


def _pairs_that_meet(case: Case, boxes: list[Box], times: np.ndarray, shared: np.ndarray) -> str:
    """Names of `shared` pairs that are apart at the start, and come into reach."""
    cell, near = np.array(case.grid.cell), reach(case)
    low, high = (np.array([getattr(box, end) for box in boxes]) for end in ("low", "high"))
    met: list[tuple[float, str]] = []
    for i, a in enumerate(boxes):
        others = i + 1 + np.flatnonzero(shared[i, i + 1 :])
        if len(others) == 0:
            continue
        gap = np.maximum(low[i] - high[others], low[others] - high[i]) / cell
        step = np.abs(np.diff(gap, axis=1, append=gap[:, -1:]))
        close = (gap - step < near).all(axis=2)
        apart = gap.max(axis=2)
        nearer = apart.min(axis=1) < apart[:, 0] - TOUCH
        later = close.any(axis=1) & nearer & (apart[:, 0] > TOUCH)
        for j in np.flatnonzero(later):
            when = float(times[close[j].argmax()])
            names = f"'{a.name}' and '{boxes[others[j]].name}'"
            met.append((when, f"{names} (from t = {when:.2g} at the earliest)"))
    names = ", ".join(text for _, text in sorted(met)[:_NAMED])
    return names + (f" and {len(met) - _NAMED} more pairs" if len(met) > _NAMED else "")


def _passing(case: Case, boxes: list[Box], times: np.ndarray) -> Iterator[str]:
    """Warnings of bodies that one in the initial configuration approaches without contact."""
    if names := _pairs_that_meet(case, boxes, times, sharing(case)):
        yield (
            f"bodies: {names} may meet, but in the initial configuration they do not feel each "
            "other, and pass through; with contact: [{bodies: all}] they meet, slide and part"
        )


def _held(case: Case, boxes: list[Box]) -> Iterator[str]:
    """Warnings of walls that act on no approaching body in the initial configuration."""
    for text in _walls(case, boxes, at_once=False):
        face, _, who = text.partition(": ")
        yield (
            f"{face}: {who.partition(' may come')[0]} may come to the wall, which in the initial "
            "configuration holds what lies on it at the start: the run then stops; take "
            "separating, or configuration: current"
        )


def _pairs(case: Case, boxes: list[Box], times: np.ndarray) -> Iterator[str]:
    """Warnings of bodies that are apart at the start and come into each other's reach."""
    if names := _pairs_that_meet(case, boxes, times, _sticking(case)):
        near = reach(case)
        yield (
            f"bodies: {names} may meet, and no entry of `contact` says how: they share one "
            f"velocity field, feel each other when their surfaces are {_range(near)} cells apart, "
            "and stick together when closer, in tension and shear too; "
            "with contact: [{bodies: all}] they touch when they meet, slide and part"
        )


def _walls(case: Case, boxes: list[Box], at_once: bool) -> Iterator[str]:
    """Warnings of bodies within a wall's reach, now or later, without touching it."""
    near = 0.5 * reach(case)
    for face, condition, axis, side in faces_with_condition(case):
        if condition.approaches and case.method.chi != "point":
            continue
        names, pulls = [], False
        for box in boxes:
            gap = clearance(case, axis, side, box.low[:, axis], box.high[:, axis])
            apart = gap[0] >= near[axis]
            if (TOUCH < gap[0] and not apart) if at_once else (apart and gap.min() < near[axis]):
                names.append(f"'{box.name}'")
                law = case.materials[case.bodies[box.name].material]
                pulls |= not law.VOLUME_ONLY or getattr(law, "least", 0.0) < 0.0
        if names:
            more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
            does, feel, them = (
                ("does", "feels", "it") if len(names) == 1 else ("do", "feel", "them")
            )
            far = f"{near[axis]:.3g} cells" if near[axis] != 1.0 else "1 cell"
            what = f"may come near the wall, and {feel} it from {far} away"
            if at_once:
                what = f"{does} not touch the wall, but {feel} it from {far} away"
            held = pulls and not condition.releases
            holds = f"; the wall holds {them} when pulled away, too" if held else ""
            yield f"boundaries.{face}: {', '.join(names[:_NAMED])}{more} {what}{holds}"


def _rigid(case: Case) -> Iterator[str]:
    """Warnings of bodies that may meet a rigid body without an entry of contact."""
    names = [*case.bodies, *case.rigid_bodies]
    if not case.rigid_bodies:
        return
    entry = np.abs(Pairs.of(case.contact, names).entry) > len(case.contact)
    first = len(case.bodies)
    found = [
        f"'{body}' and '{rigid_body}'"
        for j, rigid_body in enumerate(case.rigid_bodies)
        for i, body in enumerate(case.bodies)
        if entry[i, first + j]
    ]
    if found:
        more = f" and {len(found) - _NAMED} more pairs" if len(found) > _NAMED else ""
        yield (
            f"bodies: {', '.join(found[:_NAMED])}{more} have no entry in `contact`: the material "
            "sticks to the rigid body where they come together; with contact: [{bodies: all}] it "
            "touches, slides and parts"
        )


def _range(values: np.ndarray) -> str:
    texts = list(dict.fromkeys(f"{value:.3g}" for value in values))
    return " or ".join(texts)


def bonded(scene: Scene, lattice: Lattice, counts: np.ndarray) -> Iterator[str]:
    """Notes on bodies that share vertices of the grid from the start, but no cell.

    Bodies that share a cell are in the notes of `pgimp.scene.bodies.counts`.

    Parameters
    ----------
    scene : Scene
    lattice, counts
        See `count_particles`.
    """
    case = scene.case
    boxes = moving_boxes(case, np.array([0.0, case.time.end]))
    cell, origin = np.array(scene.domain.frame.cell), np.array(scene.domain.frame.origin)
    # A cut particle reaches farther, by half a particle at most.
    near = reach(case) + 1.0 / np.array(lattice.per_cell)
    lows, highs = (np.array([getattr(box, end)[0] for box in boxes]) for end in ("low", "high"))
    found: list[str] = []
    shared = _sticking(case)
    for i, j in _close(lows, highs, near * cell):
        if len(found) > _NAMED:
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
            found.append(f"'{boxes[i].name}' and '{boxes[j].name}'")
    if found:
        more = " and others" if len(found) > _NAMED else ""
        yield (
            f"bodies: {', '.join(found[:_NAMED])}{more} share vertices of the grid from the start: "
            "they are bonded there, in tension and shear too; bodies move by themselves while they "
            f"are {_range(reach(case))} cells apart or more"
        )


def _close(low: np.ndarray, high: np.ndarray, near: np.ndarray) -> list[tuple[int, int]]:
    """Pairs of boxes within a distance `near` of each other; of many the closest."""
    found = []
    for i in range(len(low)):
        gap = np.maximum(low[i] - high[i + 1 :], low[i + 1 :] - high[i])
        for j in np.flatnonzero((gap <= near).all(axis=1)):
            found.append((float((gap[j] / near).max()), i, i + 1 + int(j)))
    return [(i, j) for _, i, j in sorted(found)[:_MOST_PAIRS]]


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
        np.array(scene.settings.shape.half),
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
