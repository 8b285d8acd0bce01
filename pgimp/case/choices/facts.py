"""Facts from which a method is chosen, as far as the case alone tells them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import isfinite
from typing import Any, Literal, NamedTuple

import numpy as np

from pgimp.case.motion.moving_boxes import (
    TOUCH,
    Box,
    clearance,
    faces_with_condition,
    instants,
    moving_boxes,
)
from pgimp.physics.loads.motion import RigidMotion
from pgimp.physics.rigid import Motion

#: Stands for `pgimp.case.schema.Case`, whose module imports this one.
Case = Any

Kind = Literal["elastic", "metal", "soil", "grains", "liquid", "gas", "other"]
#: Kinds that flow together where they touch.
FLOWING = ("soil", "grains", "liquid", "gas")
#: Least distance, and part of the larger body, within which two bodies may meet.
_CELLS, _PART = 2.0, 0.1
#: Strain of grips and tools over that at yield, above which a plastic body collapses.
_YIELDS = 5.0
#: Most pairs that are looked at; scenes with more have contact of all.
_MOST_PAIRS = 2000


class BodyChoice(NamedTuple):
    """What is known of a body of a material before the run."""

    name: str
    kind: Kind
    #: Poisson's ratio, its greatest if it varies; 0 where it is unknown.
    poisson: float
    #: Strain that grips, tools and impacts may cause, at the order of magnitude; of a metal,
    #: whether that of grips and tools is several times its strain at yield.
    strain: float
    yields: bool
    fails: bool  #: Whether its material may tear.
    wall: str  #: Face that it may come to, and that holds only what lies on it at the start.
    leaves: bool  #: Whether its particles, or parts of the ground, come or go.


class SceneChoice(NamedTuple):
    """What is known of a scene, with the configurations that its bodies have."""

    dimensions: int
    bodies: tuple[BodyChoice, ...]
    initial: tuple[bool, ...]  #: Bodies in the initial configuration.
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
    dug = staged_bodies(case)
    found = []
    for box in boxes:
        material = case.materials[case.bodies[box.name].material]
        kind = kind_of(material)
        strain, yields = (0.0, False) if kind in FLOWING else _strain(case, box, material, kind)
        found.append(
            BodyChoice(
                box.name,
                kind,
                _number(getattr(material, "poisson", 0.0)),
                strain,
                yields,
                bool(getattr(material, "damage", None)),
                next(_walls(case, box), ""),
                bool(dug) or box.name in case.inflow,
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


def _most(varying: Any) -> float:
    """Greatest number in a parameter that varies in space, as the case writes it."""
    data = varying.model_dump() if hasattr(varying, "model_dump") else varying
    numbers = [x for x in _numbers(data) if 0.0 <= x < 0.5]
    return max(numbers, default=0.0)


def _numbers(data: Any) -> Iterator[float]:
    if isinstance(data, dict):
        data = tuple(data.values())
    if isinstance(data, tuple | list):
        for item in data:
            yield from _numbers(item)
    elif isinstance(data, float | int) and not isinstance(data, bool):
        yield float(data)


def _walls(case: Case, box: Box) -> Iterator[str]:
    """Faces that the body may come to, which hold only what lies on them at the start."""
    for face, condition, axis, side in faces_with_condition(case):
        gap = clearance(case, axis, side, box.low[:, axis], box.high[:, axis])
        if not condition.approaches and gap[0] > TOUCH and gap.min() < min(1.0, gap[0]):
            yield face


def _strain(case: Case, box: Box, material: Any, kind: Kind) -> tuple[float, bool]:
    """Strain of a solid by grips and tools, or by an impact; and whether the former yields."""
    sizes, end = np.maximum(box.high[0] - box.low[0], 1e-300), case.time.end
    ways = [np.zeros(case.dimensions)]
    for entry in case.constraints.values():
        if entry.body == box.name and not entry.field:
            ways.append(np.array([v or 0.0 for v in entry.displacement(end)]))
    held = len(ways) > 2 or any(  # one grip alone takes the body with it
        clearance(case, axis, side, box.low[0, axis], box.high[0, axis]) < 1.0
        for _, _, axis, side in faces_with_condition(case)
    )
    apart = np.ptp(ways, axis=0) if held else np.zeros(case.dimensions)
    for entry in case.constraints.values():  # tools of a material
        if kind == "metal" and entry.body != box.name and not entry.field:
            way = np.array([v or 0.0 for v in entry.displacement(end)])
            apart = np.maximum(apart, np.abs(way))
    for body in case.rigid_bodies.values():
        if isinstance(body.rigid, Motion) and body.rigid.moves:
            way = np.array([body.rigid.displacement(float(t)) for t in instants(case)])
            way = np.abs(way[:, : case.dimensions]).max(axis=0)
            apart = np.maximum(apart, way * sizes / np.minimum(sizes, _wide(body.region, way)))
    grips = float((apart / sizes).max())
    density, young = _number(material.density), _number(getattr(material, "young", None))
    strength = _number(getattr(material, "yield_stress", None) or getattr(material, "a", None))
    speeds = [_speed(body.velocity) for body in case.bodies.values()]
    closing = _speed(case.bodies[box.name].velocity) or max(speeds)
    strain = max(grips, closing * (density / young) ** 0.5 if young else 0.0)
    if kind == "metal" and strength:
        strain = max(strain, density * closing**2 / strength)  # Johnson's damage number
    yields = kind == "metal" and young * grips > _YIELDS * strength
    return (strain, yields) if isfinite(strain) else (1.0, kind == "metal")


def _wide(region: Any, way: np.ndarray) -> float:
    """Width of a tool across its way: as deep it strains what it sinks into."""
    if any(part.FROM_FILE for part in region.simple()):
        return float("inf")
    low, high = (np.array(end, float) for end in region.bounds())
    across = (high - low)[way < way.max()]
    return float(across.min()) if across.size else float("inf")


def _number(value: Any) -> float:
    return float(value) if isinstance(value, float | int) else _most(value) if value else 0.0


def _speed(velocity: Any) -> float:
    """Speed at which a body begins; of its turning, which strains it, nothing."""
    if isinstance(velocity, RigidMotion):
        velocity = velocity.translation
    return float(np.linalg.norm(velocity)) if isinstance(velocity, tuple) else 0.0


class Meeting(NamedTuple):
    """Pairs of bodies that may meet: names, and whether they touch at the start."""

    pairs: tuple[tuple[str, str, bool], ...]
    #: Groups that stay together: what flows, and what stages take out or bring and its neighbours.
    together: tuple[tuple[str, ...], ...]


def meeting(case: Case, facts: list[BodyChoice]) -> Meeting:
    """Find the pairs of bodies that may meet, but for those that stay together.

    Rigid bodies may meet whatever is in the domain; two rigid ones are left out.
    """
    flowing = {body.name for body in facts if body.kind in FLOWING}
    boxes, dug, held = boxes_of(case), staged_bodies(case), []
    pairs = []
    for one, other in combinations(boxes, 2) if len(boxes) ** 2 < 2 * _MOST_PAIRS else ():
        if one.name in flowing and other.name in flowing:
            continue
        near = np.maximum(
            _CELLS * np.array(case.grid.cell),
            _PART * max((box.high[0] - box.low[0]).max() for box in (one, other)),
        )
        gap = np.maximum(one.low - other.high, other.low - one.high)
        step = np.abs(np.diff(gap, axis=0, append=gap[-1:]))
        if (gap - step < near).all(axis=1).any():
            touching = bool((gap[0] <= TOUCH * np.array(case.grid.cell)).all())
            if touching and {one.name, other.name} & dug:
                held.append((one.name, other.name))
            else:
                pairs.append((one.name, other.name, touching))
    if len(boxes) ** 2 >= 2 * _MOST_PAIRS:
        pairs = [(boxes[0].name, boxes[1].name, False)]
    pairs += [(one, other, False) for other in case.rigid_bodies for one in case.bodies]
    together = [tuple(name for name in case.bodies if name in flowing), *held]
    return Meeting(tuple(pairs), tuple(group for group in together if len(group) > 1))
