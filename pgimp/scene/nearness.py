"""Bodies that come near each other, or a wall, and share a velocity field: they stick together.

A particle shares vertices of the grid with whatever is within its reach. Between the surfaces of
two bodies, whose outermost particles lie half a particle's spacing inside, that is
2 (1 + d) - 1/n cells, with the half-width d of chi_p in cells and n particles a cell: 2 with boxes.
From a wall it is half of that. Pairs of bodies that an entry of `contact` is for do what it says.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from pgimp.physics.contact import Pairs, sharing
from pgimp.scene.supports import held_at
from pgimp.schema.tables import Table, VectorTable

AXES = "xyz"

#: Number of instants at which distances of bodies are checked; fewer if there are many bodies.
_INSTANTS, _FEWEST_INSTANTS, _PLACES = 129, 9, 20_000
#: Distances below this part of a cell are none: the bodies touch.
_TOUCH = 1e-6
#: Of the part of the grid where two bodies may meet, if they are to be compared cell by cell.
_MOST_CELLS = 20_000_000
#: Pairs of bodies that are compared so, each in some hundredths of a second.
_MOST_PAIRS = 100
#: Pairs that are named; of more, the number.
_NAMED = 3


class Box(NamedTuple):
    """The box round a body, and how it moves if nothing but walls and prescribed motion stop it.

    Attributes
    ----------
    name : str
    low, high : (instants, D) float64
        Its corners, round all directions of a body that turns from the second instant on.
    """

    name: str
    low: np.ndarray
    high: np.ndarray


def reach(case: Any) -> np.ndarray:
    """Distance from which two surfaces feel each other, by direction, (D,) in cells."""
    half = np.array(case.method.parameters(tuple(case.grid.cell)).half)
    return 2.0 * (1.0 + half) - 1.0 / np.array(case.method.particles_per_cell)


def warnings(case: Any) -> list[str]:
    """Return which bodies and walls near each other; from the case alone, so that it costs nothing.

    Parameters
    ----------
    case : Case
        The case, its meshes and particle files read (`pgimp.scene.geometry.share`).
    """
    boxes = _boxes(case, times := _instants(case))
    if all(body.configuration == "initial" for body in case.bodies.values()):
        return [*_passing(case, boxes, times), *_walls(case, boxes, at_once=True)]
    return [*_pairs(case, boxes, times), *_walls(case, boxes, at_once=True), *_rigid(case)]


def notes(case: Any) -> list[str]:
    """Return which bodies come near walls; as `warnings`."""
    if all(body.configuration == "initial" for body in case.bodies.values()):
        return []
    return list(_walls(case, _boxes(case, _instants(case)), at_once=False))


def meet(case: Any) -> bool:
    """Whether bodies may come near each other, or a wall, that they are apart from at the start."""
    boxes = _boxes(case, times := _instants(case))
    return bool(_pairs_that_meet(case, boxes, times) or [*_walls(case, boxes, at_once=False)])


def _instants(case: Any) -> np.ndarray:
    number = min(_INSTANTS, max(_FEWEST_INSTANTS, _PLACES // len(case.bodies)))
    return np.linspace(0.0, case.time.end, number)


def _boxes(case: Any, times: np.ndarray) -> list[Box]:
    fall = _integral(_fall(case, times), times)
    boxes = []
    for name, body in case.bodies.items():
        low, high = (np.array(end, float) for end in body.region.bounds())
        velocity, turns = _velocity(body.velocity, 0.5 * (low + high))
        moved = [entry for entry in case.constraints.values() if entry.body == name]
        if moved:
            way = _integral(_prescribed(moved[-1].velocity, times), times)
        elif any(_held(case, low, high)):
            way = np.zeros((len(times), len(low)))
        else:
            way = velocity * times[:, None] + _integral(fall, times)
        way = _stopped(case, low, high, way)
        wider = np.zeros_like(way)
        if turns:
            wider[1:] = 0.5 * (float(np.linalg.norm(high - low)) - (high - low))
        boxes.append(Box(name, low + way - wider, high + way + wider))
    return boxes


def _velocity(entry: Any, middle: np.ndarray) -> tuple[np.ndarray, bool]:
    """Initial velocity of a point of a body, (D,), and whether the body turns."""
    if isinstance(entry, tuple):
        return np.array(entry, float), False
    D, rate = len(middle), entry.rotation.rate
    arm, translation = np.zeros(3), entry.translation
    arm[:D] = middle - entry.rotation.about
    omega = rate if isinstance(rate, tuple) else (0.0, 0.0, rate)
    v = np.cross(omega, arm)[:D]
    return v + (np.zeros(D) if translation is None else translation), True


def _fall(case: Any, times: np.ndarray) -> np.ndarray:
    b, D = case.gravity, case.dimensions
    if b is None:
        return np.zeros((len(times), D))
    return np.array([b.value(t) if isinstance(b, VectorTable) else b for t in times], float)


def _prescribed(velocity: Any, times: np.ndarray) -> np.ndarray:
    """Prescribed velocity over time; zero where a component is free."""
    columns = [[v.value(t) if isinstance(v, Table) else v or 0.0 for t in times] for v in velocity]
    return np.array(columns, float).T


def _integral(values: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Integral over time from the start, by the trapezoidal rule."""
    parts = 0.5 * (values[1:] + values[:-1]) * np.diff(times)[:, None]
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(parts, axis=0)])


def _faces(case: Any) -> Iterator[tuple[str, Any, int, int]]:
    """Faces with a condition, with their axis and side."""
    for face, condition in case.boundaries.items():
        yield face, condition, AXES.index(face[0]), -1 if face.endswith("min") else 1


def _clear(case: Any, axis: int, side: int, low: np.ndarray, high: np.ndarray) -> Any:
    """Distance of a box from a face, in cells."""
    away = low - case.grid.origin[axis] if side < 0 else case.grid.corner[axis] - high
    return away / case.grid.cell[axis]


def _held(case: Any, low: np.ndarray, high: np.ndarray) -> Iterator[bool]:
    """For each face that the body touches: whether it holds the body in all directions."""
    for _, condition, axis, side in _faces(case):
        if _clear(case, axis, side, low[axis], high[axis]) <= _TOUCH:
            yield all(held_at(condition, axis, side)[: case.dimensions])


def _stopped(case: Any, low: np.ndarray, high: np.ndarray, way: np.ndarray) -> np.ndarray:
    """The way of a box that walls stop."""
    for _, _, axis, side in _faces(case):
        if side < 0:
            least = min(0.0, case.grid.origin[axis] - low[axis])
            way[:, axis] = np.maximum(way[:, axis], least)
        else:
            most = max(0.0, case.grid.corner[axis] - high[axis])
            way[:, axis] = np.minimum(way[:, axis], most)
    return way


def _pairs_that_meet(case: Any, boxes: list[Box], times: np.ndarray) -> str:
    """Return names of bodies that are apart at the start, and come into each other's reach."""
    cell, near = np.array(case.grid.cell), reach(case)
    low, high = (np.array([getattr(box, end) for box in boxes]) for end in ("low", "high"))
    met: list[tuple[float, str]] = []
    shared = sharing(case)
    for i, a in enumerate(boxes):
        gap = np.maximum(low[i] - high[i + 1 :], low[i + 1 :] - high[i]) / cell
        step = np.abs(np.diff(gap, axis=1, append=gap[:, -1:]))
        close = (gap - step < near).all(axis=2)
        apart = gap.max(axis=2)
        nearer = apart.min(axis=1) < apart[:, 0] - _TOUCH
        later = close.any(axis=1) & nearer & (apart[:, 0] > _TOUCH)
        for j in np.flatnonzero(later & shared[i, i + 1 :]):
            when = float(times[close[j].argmax()])
            names = f"'{a.name}' and '{boxes[i + 1 + j].name}'"
            met.append((when, f"{names} (from t = {when:.2g} at the earliest)"))
    names = ", ".join(text for _, text in sorted(met)[:_NAMED])
    return names + (f" and {len(met) - _NAMED} more pairs" if len(met) > _NAMED else "")


def _passing(case: Any, boxes: list[Box], times: np.ndarray) -> Iterator[str]:
    """Return what bodies in the initial configuration come to and do not feel."""
    if names := _pairs_that_meet(case, boxes, times):
        yield (
            f"bodies: {names} may meet, but in the initial configuration they do not feel each "
            "other, and pass through; with contact: [{bodies: all}] they meet, slide and part"
        )
    for text in _walls(case, boxes, at_once=False):
        face, _, who = text.partition(": ")
        yield (
            f"{face}: {who.partition(' may come')[0]} may come to the wall, which in the initial "
            "configuration holds what lies on it at the start: the run then stops; take "
            "separating, or configuration: current"
        )


def _pairs(case: Any, boxes: list[Box], times: np.ndarray) -> Iterator[str]:
    """Return which bodies are apart at the start, and come nearer, into each other's reach."""
    if names := _pairs_that_meet(case, boxes, times):
        near = reach(case)
        yield (
            f"bodies: {names} may meet, and no entry of `contact` says how: they share one "
            f"velocity field, feel each other when their surfaces are {_range(near)} cells apart, "
            "and stick together when closer, in tension and shear too; "
            "with contact: [{bodies: all}] they touch when they meet, slide and part"
        )


def _walls(case: Any, boxes: list[Box], at_once: bool) -> Iterator[str]:
    """Return which bodies are within a wall's reach without touching it, or will come there."""
    near = 0.5 * reach(case)
    for face, condition, axis, side in _faces(case):
        if condition.approaches and case.method.chi != "point":
            continue
        names = []
        for box in boxes:
            gap = _clear(case, axis, side, box.low[:, axis], box.high[:, axis])
            apart = gap[0] >= near[axis]
            if (_TOUCH < gap[0] and not apart) if at_once else (apart and gap.min() < near[axis]):
                names.append(f"'{box.name}'")
        if names:
            more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
            does, feel, them = (
                ("does", "feels", "it") if len(names) == 1 else ("do", "feel", "them")
            )
            far = f"{near[axis]:.3g} cells" if near[axis] != 1.0 else "1 cell"
            what = f"may come near the wall, and {feel} it from {far} away"
            if at_once:
                what = f"{does} not touch the wall, but {feel} it from {far} away"
            holds = "" if condition.releases else f"; the wall holds {them} when pulled away, too"
            yield f"boundaries.{face}: {', '.join(names[:_NAMED])}{more} {what}{holds}"


def _rigid(case: Any) -> Iterator[str]:
    """Return which bodies no entry of contact lets meet a rigid body freely."""
    names = [*case.bodies, *case.tools]
    if not case.tools:
        return
    entry = np.abs(Pairs.of(case.contact, names).entry) > len(case.contact)
    first = len(case.bodies)
    found = [
        f"'{body}' and '{tool}'"
        for j, tool in enumerate(case.tools)
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


def bonded(scene: Any, lattice: Any, counts: np.ndarray) -> Iterator[str]:
    """Return which bodies share vertices of the grid from the start, though no cell.

    Those that share a cell are in the notes of `pgimp.scene.counts`.

    Parameters
    ----------
    scene : Scene
    lattice, counts
        See `count_particles`.
    """
    case = scene.case
    boxes = _boxes(case, np.array([0.0, case.time.end]))
    cell, origin = np.array(scene.frame.cell), np.array(scene.frame.origin)
    # What a surface cuts reaches farther, by half a particle at most.
    near = reach(case) + 1.0 / np.array(lattice.per_cell)
    lows, highs = (np.array([getattr(box, end)[0] for box in boxes]) for end in ("low", "high"))
    found: list[str] = []
    shared = sharing(case)
    for i, j in _close(lows, highs, near * cell):
        if len(found) > _NAMED:
            break
        if not shared[i, j]:
            continue
        low, high = np.maximum(lows[i], lows[j]), np.minimum(highs[i], highs[j])
        # Cells in which particles of both may share vertices.
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
    """Pairs of boxes that are no farther from each other than `near`; of many the closest."""
    found = []
    for i in range(len(low)):
        gap = np.maximum(low[i] - high[i + 1 :], low[i + 1 :] - high[i])
        for j in np.flatnonzero((gap <= near).all(axis=1)):
            found.append((float((gap[j] / near).max()), i, i + 1 + int(j)))
    return [(i, j) for _, i, j in sorted(found)[:_MOST_PAIRS]]


def _marks(
    scene: Any,
    lattice: Any,
    counts: np.ndarray,
    body: int,
    first: np.ndarray,
    shape: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Cells, from `first` on, that hold centres of a body's particles, and vertices they reach."""
    cells, vertices = np.zeros(shape, bool), np.zeros(shape, bool)
    cell, origin, half = scene.frame.cell, scene.frame.origin, np.array(scene.shape.half)
    n = lattice.per_cell[0]
    planes = max(0, int(first[0]) * n), min(lattice.planes, int(first[0] + shape[0]) * n)
    for block in lattice.make(planes, counts, body):
        x = (block.positions - origin) / cell - first
        _mark(cells, np.floor(x).astype(int))
        low = np.floor(x - 1.0 - half + _TOUCH).astype(int) + 1
        high = np.ceil(x + 1.0 + half - _TOUCH).astype(int) - 1
        for step in product(*(range(n) for n in (high - low).max(axis=0) + 1)):
            _mark(vertices, (low + step)[(low + step <= high).all(axis=1)])
    return cells, vertices


def _mark(marks: np.ndarray, places: np.ndarray) -> None:
    inside = ((places >= 0) & (places < marks.shape)).all(axis=1)
    marks[tuple(places[inside].T)] = True
