"""Bounding boxes of the bodies, and their motion if walls, constraints and supports stop them.

Only the case is used: gravity, initial velocities, constraints, faces that hold, and bodies at rest
on which others lie.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pgimp.geometry.regions import Points
from pgimp.physics.contact.pairs import Pairs
from pgimp.physics.loads.own_velocity import OwnVelocity
from pgimp.physics.loads.turning import rotation_matrix
from pgimp.schema.tables import VectorFunction
from pgimp.schema.time_functions import TimeFunction

if TYPE_CHECKING:
    from pgimp.physics.boundaries.base import Boundary
    from pgimp.physics.loads.motion import RigidMotion
    from pgimp.physics.loads.turning import Turning

AXES = "xyz"

#: Stands for `pgimp.case.schema.Case`, whose module imports this one.
Case = Any

#: Number of instants at which distances of bodies are checked; fewer if there are many bodies.
_INSTANTS, _FEWEST_INSTANTS, _PLACES = 129, 9, 20_000
#: Bodies on each other that are seen; most bodies among which supports are looked for.
_STACKED, _MOST_BODIES = 4, 60
#: Distances below this part of a cell count as contact.
TOUCH = 1e-6


class Box(NamedTuple):
    """Bounding box of a body over time."""

    name: str
    #: low, high: (instants, D) float64: Corners; for a body that turns, they enclose all its
    #: orientations from the second instant.
    low: np.ndarray
    high: np.ndarray


def instants(case: Case) -> np.ndarray:
    """Times of the boxes, from the start to the end."""
    number = min(_INSTANTS, max(_FEWEST_INSTANTS, _PLACES // len(case.bodies)))
    return np.linspace(0.0, case.time.end, number)


def moving_boxes(case: Case, times: np.ndarray) -> list[Box]:
    """Bounding boxes of all bodies of a material at `times`, the first of which is the start."""
    fall = _integral(_fall(case, times), times)
    starts, ways, widths, turned = [], [], [], {}
    for name, body in case.bodies.items():
        low, high = (np.array(end, float) for end in body.region.bounds())
        if isinstance(body.region, Points):  # bounds of centres; half a particle lies beyond
            half = 0.5 * np.array(case.grid.cell) / case.method.particles_per_cell
            low, high = low - half, high + half
        velocity, turns = _velocity(body.velocity, 0.5 * (low + high))
        moved = [entry for entry in case.constraints.values() if entry.body == name]
        if moved and moved[-1].field:
            displacement = np.zeros((len(times), len(low)))
        elif moved:
            displacement = _integral(_prescribed(moved[-1].motion, times), times)
        elif any(_held(case, low, high)):
            displacement = np.zeros((len(times), len(low)))
        else:
            displacement = velocity * times[:, None] + _integral(fall, times)
        starts.append(np.stack([low, high]))
        ways.append(_stopped(case, low, high, displacement))
        wider = np.zeros_like(displacement)
        if turns:
            wider[1:] = 0.5 * (float(np.linalg.norm(high - low)) - (high - low))
        widths.append(wider)
        if moved and moved[-1].rotation:
            turned[name] = _turned(low, high, moved[-1].rotation, times)
    _borne(case, np.array(starts), ways)
    boxes = []
    for name, (low, high), way, wider in zip(case.bodies, starts, ways, widths, strict=True):
        first, last = turned.get(name, (low - wider, high + wider))
        boxes.append(Box(name, first + way, last + way))
    return boxes


def free_velocities(case: Case, times: np.ndarray) -> dict[str, np.ndarray]:
    """Velocities of all bodies, rigid ones too, if nothing stops them, (instants, D).

    They are right until a body meets something.
    """
    fall, found = _integral(_fall(case, times), times), {}
    for name, body in case.bodies.items():
        low, high = (np.array(end, float) for end in (case.grid.origin, case.grid.corner))
        known = not any(part.FROM_FILE for part in body.region.simple())
        if known:
            ends = body.region.bounds()
            low, high = (np.clip(np.array(end, float), low, high) for end in ends)
        moved = [entry for entry in case.constraints.values() if entry.body == name]
        if moved and not moved[-1].field:
            found[name] = _prescribed(moved[-1].motion, times)
        elif moved or (known and any(_held(case, low, high))):
            found[name] = np.zeros((len(times), len(low)))
        else:
            found[name] = _velocity(body.velocity, 0.5 * (low + high))[0] + fall
    for name, entry in case.rigid_bodies.items():
        if entry.free:
            velocity = getattr(entry.velocity, "translation", entry.velocity)
            found[name] = fall + (velocity or (0.0,) * case.dimensions)
        else:
            values = [entry.rigid.velocities(float(t))[0] for t in times]
            found[name] = np.array(values)[:, : case.dimensions]
    return found


def _borne(case: Case, starts: np.ndarray, ways: list[np.ndarray]) -> None:
    """Stop boxes where they come to bodies at rest, on which they then lie.

    Parameters
    ----------
    starts : (bodies, 2, D) float64
        Low and high corners at the start.
    ways : list of (instants, D) float64
        Displacements, which are limited in place.
    """
    if len(starts) > _MOST_BODIES:
        return
    acts, cell = felt(case), np.array(case.grid.cell)
    fixed = [
        (number, np.array(entry.region.bounds(), float))
        for number, entry in enumerate(case.rigid_bodies.values(), len(starts))
        if not (entry.free or entry.moves or any(p.FROM_FILE for p in entry.region.simple()))
    ]
    for _ in range(_STACKED):
        before = [way.copy() for way in ways]
        still = [(np.abs(way) <= TOUCH * cell).all() for way in ways]
        for i, way in enumerate(ways):
            for j, (other, rests) in enumerate(zip(starts, still, strict=True)):
                if i != j and rests and acts[i, j]:
                    _stop(starts[i], other, way)
            for j, other in fixed:
                if acts[i, j]:
                    _stop(starts[i], other, way)
        if all(np.array_equal(way, old) for way, old in zip(ways, before, strict=True)):
            return


def _stop(own: np.ndarray, other: np.ndarray, way: np.ndarray) -> None:
    """Limit the displacement of a box along each axis by another one that lies there, at rest."""
    low, high = own[0] + way, own[1] + way
    beside = (low < other[1]) & (high > other[0])
    for axis in range(own.shape[1]):
        facing = np.delete(beside, axis, axis=1).all(axis=1)
        if own[0, axis] > other[0, axis] and own[1, axis] > other[1, axis]:
            least = min(0.0, other[1, axis] - own[0, axis])
            way[facing, axis] = np.maximum(way[facing, axis], least)
        elif own[1, axis] < other[1, axis] and own[0, axis] < other[0, axis]:
            most = max(0.0, other[0, axis] - own[1, axis])
            way[facing, axis] = np.minimum(way[facing, axis], most)


def felt(case: Case) -> np.ndarray:
    """Pairs of bodies, also rigid ones, that feel each other, (n, n) bool.

    They do by contact, or by a shared field, which bodies in the initial configuration have not.
    """
    names = [*case.bodies, *case.rigid_bodies]
    entry = Pairs.of(case.contact, names).entry
    initial = np.array([body.formulation == "total-lagrangian" for body in case.bodies.values()])
    alone = np.zeros(len(names), bool)
    alone[: len(initial)] = initial
    shares = np.abs(entry) > len(case.contact)
    acts = np.triu(np.where(shares, ~(alone[:, None] | alone), entry != 0), 1)
    return acts | acts.T


def _turned(
    low: np.ndarray, high: np.ndarray, rotation: Turning, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Bounding boxes of a box that turns as a whole, (instants, D) each."""
    D = len(low)
    arms = np.zeros((2**D, 3))
    arms[:, :D] = np.array([*product(*zip(low, high, strict=True))]) - rotation.about
    turns = [rotation_matrix(rotation.direction, rotation.angle(t)) for t in times]
    corners = np.einsum("tij,kj->tki", np.reshape(turns, (-1, 3, 3)), arms)[..., :D]
    corners += rotation.about
    return corners.min(axis=1), corners.max(axis=1)


def _velocity(
    entry: tuple[float, ...] | RigidMotion | OwnVelocity, middle: np.ndarray
) -> tuple[np.ndarray, bool]:
    """Initial velocity of a body's point, (D,), and whether the body turns."""
    if isinstance(entry, tuple):
        return np.array(entry, float), False
    if isinstance(entry, OwnVelocity):
        return entry.at(middle[None])[0], False
    D, rate = len(middle), entry.rotation.rate
    arm, translation = np.zeros(3), entry.translation
    arm[:D] = middle - entry.rotation.about
    omega = rate if isinstance(rate, tuple) else (0.0, 0.0, rate)
    v = np.cross(omega, arm)[:D]
    return v + (np.zeros(D) if translation is None else translation), True


def _fall(case: Case, times: np.ndarray) -> np.ndarray:
    b, D = case.gravity, case.dimensions
    if b is None:
        return np.zeros((len(times), D))
    return np.array([b.value(t) if isinstance(b, VectorFunction) else b for t in times], float)


def _prescribed(velocity: Sequence[TimeFunction | float | None], times: np.ndarray) -> np.ndarray:
    """Prescribed velocity over time; zero where a component is free."""
    columns = [
        [v.value(t) if isinstance(v, TimeFunction) else v or 0.0 for t in times] for v in velocity
    ]
    return np.array(columns, float).T


def _integral(values: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Integral over time from the start, by the trapezoidal rule."""
    parts = 0.5 * (values[1:] + values[:-1]) * np.diff(times)[:, None]
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(parts, axis=0)])


def held_at(condition: Any, axis: int, side: int) -> tuple[bool, ...]:
    """Return which components of a motion out of the domain a face's condition holds, (3,) bool."""
    v = (side * 1e300,) * 3
    face = condition.at_rest.parameters(axis, side, 0.0, 0.0)
    a = (0.0,) * 3
    if condition.approaches:
        held, _ = face.approach(face, v, a, 0.0)
    else:
        held, _ = face.constrain(face, v, a)
    return tuple(bool(a != b) for a, b in zip(held, v, strict=True))


def faces_with_condition(case: Case) -> Iterator[tuple[str, Boundary, int, int]]:
    """Faces with a condition, with their axis and side."""
    for face, condition in case.boundaries.items():
        if condition.joins:
            continue
        yield face, condition, AXES.index(face[0]), -1 if face.endswith("min") else 1


def clearance(case: Case, axis: int, side: int, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Distance of a box from a face, in cells."""
    away = low - case.grid.origin[axis] if side < 0 else case.grid.corner[axis] - high
    return away / case.grid.cell[axis]


def _held(case: Case, low: np.ndarray, high: np.ndarray) -> Iterator[bool]:
    """For each face that the body touches: whether it holds the body in all directions."""
    for _, condition, axis, side in faces_with_condition(case):
        if clearance(case, axis, side, low[axis], high[axis]) <= TOUCH:
            yield all(held_at(condition, axis, side)[: case.dimensions])


def _stopped(case: Case, low: np.ndarray, high: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Displacement of a box, limited by walls."""
    for _, _, axis, side in faces_with_condition(case):
        if side < 0:
            least = min(0.0, case.grid.origin[axis] - low[axis])
            displacement[:, axis] = np.maximum(displacement[:, axis], least)
        else:
            most = max(0.0, case.grid.corner[axis] - high[axis])
            displacement[:, axis] = np.minimum(displacement[:, axis], most)
    return displacement
