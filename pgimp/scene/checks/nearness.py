"""Bodies that stick to each other, or to a wall, because they share a velocity field.

A particle shares vertices of the grid with everything within its reach. The outermost particles
lie half a particle's spacing inside the surface. So the reach between two surfaces is
2 (1 + d) - 1/n cells, 2 with boxes. d is the half-width of chi_p in cells, n the particles a cell.
From a wall the reach is half as large. Pairs of bodies with an entry of `contact` follow its law.
Fluids, gases and grains flow together where they meet; without tension no wall holds them back.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.motion.moving_boxes import (
    TOUCH,
    Box,
    clearance,
    faces_with_condition,
    instants,
    moving_boxes,
)
from pgimp.physics.contact.pairs import Pairs, sharing
from pgimp.physics.rigid import Motion
from pgimp.scene.checks.warned import Warned, warned
from pgimp.scene.rigid.images import nearest_image

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.scene.rigid.rigid import SceneRigidBodies

#: Most pairs that are named; beyond it only their number is given.
NAMED = 3


def reach(case: Case) -> np.ndarray:
    """Distance within which two surfaces interact, by direction, (D,) in cells."""
    half = np.array(case.method.parameters(tuple(case.grid.cell)).half)
    return 2.0 * (1.0 + half) - 1.0 / np.array(case.method.particles_per_cell)


def warnings(case: Case, rigid_bodies: SceneRigidBodies | None = None) -> list[Warned]:
    """Return warnings of bodies and walls that approach each other.

    Parameters
    ----------
    case : Case
        The case, its meshes and particle files read (`pgimp.scene.geometry.share`).
    rigid_bodies : SceneRigidBodies, optional
        Its rigid bodies, after `measure`; without them each is taken to come near each body.
    """
    boxes = moving_boxes(case, times := instants(case))
    walls = _walls(case, boxes, at_once=True)
    lagrangian = [body.formulation == "total-lagrangian" for body in case.bodies.values()]
    tied = _tied(case, boxes, times, rigid_bodies)
    if not any(lagrangian):
        return [*_pairs(case, boxes, times), *walls, *tied]
    alone = [box for box, initial in zip(boxes, lagrangian, strict=True) if initial]
    if not all(lagrangian):
        return [*_held(case, alone), *walls, *tied]
    return [*_passing(case, boxes, times), *_held(case, alone), *walls]


def notes(case: Case) -> list[Warned]:
    """Return notes on bodies that come near walls; as `warnings`."""
    lagrangian = [body.formulation == "total-lagrangian" for body in case.bodies.values()]
    boxes = moving_boxes(case, instants(case))
    boxes = [box for box, initial in zip(boxes, lagrangian, strict=True) if not initial]
    return list(_walls(case, boxes, at_once=False))


def meet(case: Case) -> bool:
    """Whether bodies that start apart may approach each other, or a wall."""
    boxes = moving_boxes(case, times := instants(case))
    pairs = _pairs_that_meet(case, boxes, times, sharing(case))
    return bool(pairs or [*_walls(case, boxes, at_once=False)])


def sticking(case: Case) -> np.ndarray:
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
    names = ", ".join(text for _, text in sorted(met)[:NAMED])
    return names + (f" and {len(met) - NAMED} more pairs" if len(met) > NAMED else "")


def _passing(case: Case, boxes: list[Box], times: np.ndarray) -> Iterator[Warned]:
    """Warnings of bodies that one in the initial configuration approaches without contact."""
    if names := _pairs_that_meet(case, boxes, times, sharing(case)):
        yield warned(
            "passing",
            f"bodies: {names} may meet, but in the initial configuration they do not "
            "interact, and pass through; with contact: [{bodies: all}] they meet, slide and part",
        )


def _held(case: Case, boxes: list[Box]) -> Iterator[Warned]:
    """Warnings of walls that act on no approaching body in the initial configuration."""
    for text in _walls(case, boxes, at_once=False):
        face, _, who = text.partition(": ")
        yield warned(
            "wall-coming",
            f"{face}: {who.partition(' may come')[0]} may come to the wall, which in the initial "
            "configuration holds what lies on it at the start: the run then stops; take "
            "unilateral, or formulation: updated-lagrangian",
        )


def _pairs(case: Case, boxes: list[Box], times: np.ndarray) -> Iterator[Warned]:
    """Warnings of bodies that are apart at the start and come into each other's reach."""
    if names := _pairs_that_meet(case, boxes, times, sticking(case)):
        near = reach(case)
        yield warned(
            "meeting",
            f"bodies: {names} may meet, and no entry of `contact` says how: they share one "
            f"velocity field, interact when their surfaces are {ranged(near)} cells apart, "
            "and are bonded when closer, in tension and shear too; "
            "with contact: [{bodies: all}] they touch when they meet, slide and part",
        )


def _walls(case: Case, boxes: list[Box], at_once: bool) -> Iterator[Warned]:
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
            more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
            does, interact, them = (
                ("does", "interacts", "it") if len(names) == 1 else ("do", "interact", "them")
            )
            far = f"{near[axis]:.3g} cells" if near[axis] != 1.0 else "1 cell"
            what = f"may approach the wall, and {interact} with it from {far} away"
            if at_once:
                what = f"{does} not touch the wall, but {interact} with it from {far} away"
            held = pulls and not condition.releases
            holds = f"; the wall holds {them} when pulled away, too" if held else ""
            yield warned(
                "wall-reach", f"boundaries.{face}: {', '.join(names[:NAMED])}{more} {what}{holds}"
            )


def _tied(
    case: Case, boxes: list[Box], times: np.ndarray, rigid_bodies: SceneRigidBodies | None
) -> Iterator[Warned]:
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
        and not (rigid_bodies and _apart(case, boxes[i], times, rigid_bodies, j))
    ]
    if found:
        more = f" and {len(found) - NAMED} more pairs" if len(found) > NAMED else ""
        yield warned(
            "tied",
            f"bodies: {', '.join(found[:NAMED])}{more} have no entry in `contact`: the material "
            "is bonded to the rigid body where they come together; with contact: [{bodies: all}] "
            "it touches, slides and parts",
        )


def _apart(
    case: Case, box: Box, times: np.ndarray, rigid_bodies: SceneRigidBodies, number: int
) -> bool:
    """Whether a body stays out of reach of a rigid one, which moves as prescribed, if at all."""
    region, motion = case.bodies[box.name].region, rigid_bodies.entries[number].rigid
    if region.WHOLE_BODY or not isinstance(motion, Motion) or motion.rotation is not None:
        return False
    D, surface = case.dimensions, rigid_bodies.surface
    points = surface.points[surface.body == number][:, :D]
    points = nearest_image(points, 0.5 * (box.low[0] + box.high[0]), rigid_bodies.periods)
    way = np.array([motion.displacement(float(t))[:D] for t in times])
    moved = max(
        float(np.linalg.norm(way - (end - end[0]), axis=1).max()) for end in (box.low, box.high)
    )
    away = float(region.signed_distance(points).min(initial=np.inf))
    return away - moved > float((reach(case) * case.grid.cell).max())


def ranged(values: np.ndarray) -> str:
    """Values by direction, each different one once."""
    texts = list(dict.fromkeys(f"{value:.3g}" for value in values))
    return " or ".join(texts)
