"""Facts from which a method is chosen, as far as the case alone tells them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any, Literal, NamedTuple

import numpy as np

from pgimp.case.choices.strains import Strained, greatest
from pgimp.case.motion.moving_boxes import (
    TOUCH,
    Box,
    clearance,
    faces_with_condition,
    free_velocities,
    held_at,
    instants,
    moving_boxes,
)

#: Stands for `pgimp.case.schema.Case`, whose module imports this one.
Case = Any

Kind = Literal["elastic", "metal", "soil", "grains", "liquid", "gas", "other"]
#: Kinds that flow together where they touch.
FLOWING = ("soil", "grains", "liquid", "gas")
#: Least distance, and part of the larger body, within which two bodies may meet.
_CELLS, _PART = 2.0, 0.1
#: Most pairs that are looked at; scenes with more have contact of all.
_MOST_PAIRS = 2000


class BodyChoice(NamedTuple):
    """What is known of a body of a material before the run."""

    name: str
    kind: Kind
    #: Poisson's ratio, its greatest if it varies; 0 where it is unknown.
    poisson: float
    #: Strain that grips, tools, blows and loads may cause, at the order of magnitude; of a metal,
    #: whether they flow it plastically several times beyond its strain at yield.
    strain: float
    yields: bool
    fails: bool  #: Whether its material may tear.
    wall: str  #: Face that it may come to, and that holds only what lies on it at the start.
    leaves: bool  #: Whether its particles, or parts of the ground, come or go.
    sticks: bool  #: Whether it lies on a face that holds it in every direction.


class SceneChoice(NamedTuple):
    """What is known of a scene, with the configurations that its bodies have."""

    dimensions: int
    bodies: tuple[BodyChoice, ...]
    initial: tuple[bool, ...]  #: Bodies in the initial configuration.
    means: tuple[bool, ...]  #: Bodies with mean dilatation.
    meets: bool  #: Whether bodies meet others, rigid ones or walls that let go.
    settles: bool

    def some(self, *kinds: Kind) -> bool:
        """Whether bodies of any of some kinds are in the current configuration."""
        pairs = zip(self.bodies, self.initial, strict=True)
        return any(body.kind in kinds and not initial for body, initial in pairs)

    @property
    def strain(self) -> float:
        """Greatest strain of a solid in the current configuration."""
        pairs = zip(self.bodies, self.initial, strict=True)
        return max((b.strain for b, one in pairs if not one and b.kind not in FLOWING), default=0.0)

    @property
    def all_initial(self) -> bool:
        """Whether all bodies are in the initial configuration."""
        return all(self.initial)


def kind_of(material: Any) -> Kind:
    """What a material is, for the choice of a method."""
    if material.LIQUID:
        return "liquid"
    if material.VOLUME_ONLY:
        return "grains" if material.RESTS else "gas"
    if material.ELASTIC:
        return "elastic"
    if material.RESTS or material.needs_pressure or material.flow_speed > 0.0:
        return "soil"
    return "metal" if "plastic-work" in material.LOSSES else "other"


def facts_of(case: Case) -> list[BodyChoice]:
    """Return the facts about each body of a case that has no problems but of its method."""
    boxes = boxes_of(case)
    speeds = closing_speeds(case, boxes)
    dug = staged_bodies(case)
    found = []
    for box in boxes:
        material = case.materials[case.bodies[box.name].material]
        kind = kind_of(material)
        strain, yields = 0.0, False
        if kind not in FLOWING:
            body = Strained(case, box, material, kind == "metal", speeds[box.name])
            strain, yields = body.strain, body.yields
        found.append(
            BodyChoice(
                box.name,
                kind,
                greatest(getattr(material, "poisson", 0.0), below=0.5),
                strain,
                yields,
                bool(getattr(material, "damage", None)),
                next(_walls(case, box), ""),
                bool(dug) or box.name in case.inflow,
                any(_sticks(case, box)),
            )
        )
    return found


def staged_bodies(case: Case) -> set[str]:
    """Names of the bodies that stages take out or bring."""
    return {name for stage in case.time.stages for name in (*stage.remove, *stage.add)}


def boxes_of(case: Case) -> list[Box]:
    """Return the boxes of all bodies; those of regions from files fill the domain at rest."""
    drawn = [name for name, body in case.bodies.items() if not _from_file(body)]
    read = case.model_copy()
    read.__dict__.pop("bodies", None)
    read.__dict__["every_body"] = {
        name: body
        for name, body in case.every_body.items()
        if name in drawn or (name in case.rigid_bodies and not _from_file(body))
    }
    read.__dict__.pop("rigid_bodies", None)
    read.__dict__["contact"] = ()
    times = instants(case)
    found = {box.name: box for box in (moving_boxes(read, times) if drawn else [])}
    low, high = np.array(case.grid.origin), np.array(case.grid.corner)
    whole = np.tile(low, (len(times), 1)), np.tile(high, (len(times), 1))
    return [_within(found.get(name, Box(name, *whole)), low, high) for name in case.bodies]


def _within(box: Box, low: np.ndarray, high: np.ndarray) -> Box:
    """Limit a box to the domain: half-spaces have no end."""
    return box._replace(low=np.clip(box.low, low, high), high=np.clip(box.high, low, high))


def _from_file(body: Any) -> bool:
    return any(part.FROM_FILE or part.WHOLE_BODY for part in body.region.simple())


def _walls(case: Case, box: Box) -> Iterator[str]:
    """Faces that the body may come to, which hold only what lies on them at the start."""
    for face, condition, axis, side in faces_with_condition(case):
        gap = clearance(case, axis, side, box.low[:, axis], box.high[:, axis])
        if not condition.approaches and gap[0] > TOUCH and gap.min() < min(1.0, gap[0]):
            yield face


def _sticks(case: Case, box: Box) -> Iterator[bool]:
    """For each face on which the body lies: whether it holds all components of a motion."""
    for _, condition, axis, side in faces_with_condition(case):
        if clearance(case, axis, side, box.low[0, axis], box.high[0, axis]) < 1.0:
            yield all(held_at(condition, axis, side)[: case.dimensions])


def closing_speeds(case: Case, boxes: list[Box]) -> dict[str, float]:
    """Greatest speed at which each body meets a face, a rigid body or another body."""
    times, found = instants(case), dict.fromkeys(case.bodies, 0.0)
    free = free_velocities(case, times)
    for box in boxes:
        for _, _, axis, side in faces_with_condition(case):
            near = clearance(case, axis, side, box.low[:, axis], box.high[:, axis]) < 1.0
            if near.any():
                speed = side * free[box.name][int(near.argmax()), axis]
                found[box.name] = max(found[box.name], float(speed))
    for one, other, when in _encounters(case, [*boxes, *_rigid_boxes(case, times)]):
        speed = float(np.linalg.norm(free[one] - free[other], axis=1)[when])
        for name in (one, other):
            if name in found:
                found[name] = max(found[name], speed)
    return found


def _rigid_boxes(case: Case, times: np.ndarray) -> Iterator[Box]:
    """Boxes of rigid bodies that are no files', along their way; free ones fall."""
    low, high = np.array(case.grid.origin), np.array(case.grid.corner)
    for name, entry in case.rigid_bodies.items():
        if _from_file(entry):
            continue
        way = np.zeros((len(times), case.dimensions))
        if not entry.free:
            way = np.array([entry.rigid.displacement(float(t)) for t in times])
        ends = (np.array(end, float) for end in entry.region.bounds())
        first, last = (end + way[:, : case.dimensions] for end in ends)
        if entry.free:  # wherever it may go
            first, last = np.minimum(first, low), np.maximum(last, high)
        yield Box(name, first, last)


def _encounters(case: Case, boxes: list[Box]) -> Iterator[tuple[str, str, int]]:
    """Yield pairs of boxes that come near each other, and the first instant at which they do."""
    for one, other in combinations(boxes, 2) if len(boxes) ** 2 < 2 * _MOST_PAIRS else ():
        gap = np.maximum(one.low - other.high, other.low - one.high)
        step = np.abs(np.diff(gap, axis=0, append=gap[-1:]))
        near = (gap - step < _near(case, one, other)).all(axis=1)
        if near.any():
            yield one.name, other.name, int(near.argmax())


def _near(case: Case, one: Box, other: Box) -> np.ndarray:
    """Distance within which two bodies may meet, by direction, (D,)."""
    size = max((box.high[0] - box.low[0]).max() for box in (one, other))
    return np.maximum(_CELLS * np.array(case.grid.cell), _PART * size)


class Meeting(NamedTuple):
    """Pairs of bodies that may meet: names, and whether they touch at the start."""

    pairs: tuple[tuple[str, str, bool], ...]
    #: Groups that stay together: what flows, and what stages take out or bring and its neighbours.
    together: tuple[tuple[str, ...], ...]


def _may_meet(case: Case, boxes: list[Box]) -> Iterator[tuple[str, str]]:
    """Yield the pairs of bodies that may meet, also after they have bounced off something.

    They cannot where the way that both go, in whatever direction, is shorter than their distance.
    """
    times = instants(case)
    direct = {(one, other) for one, other, _ in _encounters(case, boxes)}
    steps = np.diff(times, append=times[-1:])[:, None]
    ways = {
        name: float(np.linalg.norm(v * steps, axis=1).sum())
        for name, v in free_velocities(case, times).items()
    }
    for one, other in combinations(boxes, 2) if len(boxes) ** 2 < 2 * _MOST_PAIRS else ():
        gap = np.maximum(one.low[0] - other.high[0], other.low[0] - one.high[0])
        apart = np.linalg.norm(np.maximum(gap - _near(case, one, other), 0.0))
        if (one.name, other.name) in direct or apart < ways[one.name] + ways[other.name]:
            yield one.name, other.name


def meeting(case: Case, facts: list[BodyChoice]) -> Meeting:
    """Find the pairs of bodies that may meet, but for those that stay together.

    Rigid bodies may meet whatever is in the domain; two rigid ones are left out.
    """
    flowing = {body.name for body in facts if body.kind in FLOWING}
    boxes, dug, held = boxes_of(case), staged_bodies(case), []
    pairs = []
    every = {box.name: box for box in boxes}
    for name, other_name in _may_meet(case, boxes):
        if name in flowing and other_name in flowing:
            continue
        one, other = every[name], every[other_name]
        gap = np.maximum(one.low[0] - other.high[0], other.low[0] - one.high[0])
        touching = bool((gap <= TOUCH * np.array(case.grid.cell)).all())
        if touching and {name, other_name} & dug:
            held.append((name, other_name))
        else:
            pairs.append((name, other_name, touching))
    if len(boxes) ** 2 >= 2 * _MOST_PAIRS:
        pairs = [(boxes[0].name, boxes[1].name, False)]
    pairs += [(one, other, False) for other in case.rigid_bodies for one in case.bodies]
    together = [tuple(name for name in case.bodies if name in flowing), *held]
    return Meeting(tuple(pairs), tuple(group for group in together if len(group) > 1))
