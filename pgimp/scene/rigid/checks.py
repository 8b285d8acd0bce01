"""Checks of rigid bodies: speed, overlaps with others, and no change since the run began."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import hypot
from operator import sub

import numpy as np
from numpy.typing import NDArray

from pgimp.case.locations import located
from pgimp.errors import CaseError, EndlessError, UsageError
from pgimp.kernels.rigid.bodies import distances
from pgimp.mpi.collective import on_root
from pgimp.mpi.communicator import Communicator
from pgimp.physics.boundaries.slip import Slip
from pgimp.scene.faces import Face
from pgimp.scene.rigid.free_body import State
from pgimp.scene.rigid.images import nearest_image
from pgimp.scene.rigid.measure import is_symmetry
from pgimp.scene.rigid.rigid import SceneRigidBodies

#: In cells: contact tolerance between surfaces of regions, and between surfaces rounded by a
#: lattice of distances; allowed depth in walls and rigid bodies; distance for the closer check.
_TOUCH, _ROUNDED, _PAST, _NEAR = 0.05, 0.2, 0.5, 0.3

#: An overlap: depth, negative, the position, and the names of body and rigid body.
_Overlap = tuple[float, tuple[float, ...], int, str]


def require_slow(rigid_bodies: SceneRigidBodies, dt: float) -> None:
    """Refuse a first step in which a body would move by more than a cell."""
    rate = rigid_bodies.first_rate
    if rate * dt > 1.0 + 1e-9:
        with located(rigid_bodies.case):
            raise CaseError(
                f"time.step: a rigid body moves by {rate * dt:.3g} cells in a step of {dt:.3g}, "
                f"and would pass through what it meets; use at most {0.3 / rate:.3g}, or a slower "
                "body"
            )


def require_same(rigid_bodies: SceneRigidBodies, checksum: str) -> None:
    """Refuse to resume a run whose rigid bodies have changed."""
    if checksum != rigid_bodies.checksum:
        raise UsageError(
            "the rigid bodies are not those of the run: has the file of a mesh changed? Put it "
            "back, or start over with --overwrite"
        )


def require_apart(
    rigid_bodies: SceneRigidBodies,
    blocks: Iterable[tuple[NDArray[np.float64], NDArray[np.int32]]],
    comm: Communicator,
) -> None:
    """Refuse bodies that overlap rigid ones at the start, and free surfaces; collective.

    The depth follows from the regions, at particles that lie in both. Bodies from files have no
    depth: there a particle's centre may be inside by half its size.

    Parameters
    ----------
    blocks : iterable of (n, D) float64 and (n,) int
        Positions of this rank's particles, and their bodies.

    Raises
    ------
    CaseError
        On every rank.
    """
    placed, near = rigid_bodies.at(0.0, 0.0), []
    for x, body in blocks:
        distance = np.empty(len(x))
        for t, name in enumerate(rigid_bodies.names):
            distances(placed, t, rigid_bodies.frame, x, distance)
            rows = np.flatnonzero(distance < _NEAR * min(rigid_bodies.frame.cell))
            for number in np.unique(body[rows]).tolist():
                own = rows[body[rows] == number]
                near.append((name, number, x[own], distance[own]))
    gathered = comm.gather(near)

    def overlaps() -> list[_Overlap]:  # surfaces from files are on rank 0
        every = [
            found
            for name, number, x, distance in chain.from_iterable(gathered)
            for found in _overlap(rigid_bodies, name, number, x, distance)
        ]
        return every + _within_bodies(rigid_bodies)

    every = on_root(comm, overlaps)
    rigid_bodies.release()
    if not every:
        return
    deep, position, inside, name = min(every)
    with located(rigid_bodies.case):
        raise CaseError(
            f"bodies.{name}.region: '{list(rigid_bodies.case.bodies)[inside]}' reaches "
            f"{-deep:.3g} into "
            f"the rigid '{name}' at ({', '.join(f'{c:.6g}' for c in position)}); bodies must not "
            "overlap at the start: move or cut one of them"
        )


def _overlap(
    rigid_bodies: SceneRigidBodies,
    name: str,
    number: int,
    x: NDArray[np.float64],
    distance: NDArray[np.float64],
) -> Iterator[_Overlap]:
    """Yield the greatest overlap of a body with a rigid one, at its particles nearby.

    Between two overlapping surfaces the distances from both add up to the depth.
    """
    cell, case = np.array(rigid_bodies.frame.cell), rigid_bodies.case
    region = [*case.bodies.values()][number].region
    if region.WHOLE_BODY:
        size = cell / np.array(case.method.particles_per_cell)
        depth, least = -distance, 0.5 * float(np.sqrt(np.square(size).sum()))
    else:
        rigid = case.rigid_bodies[name].region.signed_distance(rigid_bodies.nearest(name, x))
        ends = [rigid, region.signed_distance(x)]
        depth, least = np.where(np.max(ends, axis=0) < 0.0, -np.sum(ends, axis=0), 0.0), 0.0
    deepest = int(depth.argmax())
    if depth[deepest] > max(least, _TOUCH * float(cell.min())):
        yield -float(depth[deepest]), tuple(x[deepest].tolist()), number, name


def may_collide(rigid_bodies: SceneRigidBodies, faces: Sequence[Face], states: list[State]) -> bool:
    """Whether a sphere around any free rigid body meets a wall, or a rigid body."""
    if len(rigid_bodies) > len(states) or (len(states) > 1 and rigid_bodies.periods.any()):
        return True
    frame = rigid_bodies.frame
    for number, (state, arm) in enumerate(zip(states, rigid_bodies.arms, strict=True)):
        for face in faces:
            wall = frame.origin[face.axis]
            if face.side > 0:
                wall += frame.cells[face.axis] * frame.cell[face.axis]
            if (state.centre[face.axis] - wall) * face.side + arm > 0.0:
                return True
        for other in range(number):
            gap = hypot(*map(sub, state.centre, states[other].centre))
            if gap < arm + rigid_bodies.arms[other]:
                return True
    return False


def collisions(
    rigid_bodies: SceneRigidBodies,
    faces: Sequence[Face],
    states: list[State],
    time: float,
    first: bool,
) -> Iterator[tuple[float, float, str, str]]:
    """Yield overlaps of free rigid bodies with walls and rigid bodies, which do not act on them.

    At the `first` instant they may only touch.

    Yields
    ------
    excess : float
        Depth beyond the tolerance, in cells.
    depth : float
        Depth, in cells.
    name, what : str
        Names of the body and of the overlapped wall or body.
    """
    frame, points = rigid_bodies.frame, rigid_bodies.surface_at(rigid_bodies.poses(time, states))
    placed, least = rigid_bodies.at(time, time, states), min(frame.cell)
    for number in rigid_bodies.free:
        mine = np.ascontiguousarray(
            points[rigid_bodies.surface.body == number][:, : len(frame.cell)]
        )
        free = rigid_bodies.entries[number].free
        assert free is not None
        for face in faces:
            if rigid_bodies.case.axisymmetric and face.name == "x-min" and not frame.origin[0]:
                continue  # the axis
            if is_symmetry(face.name, face.condition, free, len(frame.cell)):
                continue
            if rigid_bodies.meets_walls and face.condition.approaches and not first:
                continue
            wall = frame.origin[face.axis]
            if face.side > 0:
                wall += frame.cells[face.axis] * frame.cell[face.axis]
            depth = float(((mine[:, face.axis] - wall) * face.side).max(initial=0.0)) / least
            limit = _TOUCH if first else _PAST
            what = f"the wall {face.name}"
            if isinstance(face.condition, Slip):
                ways = _across(face.axis, len(frame.cell))
                what += f" (if that is a plane of symmetry: `fixed: {ways}`)"
            yield depth - limit, depth, rigid_bodies.names[number], what
        distance = np.empty(len(mine))
        for other, name in enumerate(rigid_bodies.names):
            met = frozenset((number, other)) in rigid_bodies.meeting
            if other != number and not (met and not first):
                distances(placed, other, frame, mine, distance)
                depth = max(0.0, -float(distance.min(initial=0.0))) / least
                # Beyond half the thickness the body would leave on the other side.
                limit = min(_ROUNDED if first else _PAST, 0.25 * rigid_bodies.thick[other] / least)
                yield depth - limit, depth, rigid_bodies.names[number], f"the rigid body '{name}'"


def _across(axis: int, D: int) -> str:
    """Explain the limits on a body that lies across a plane of symmetry."""
    own = "xyz"[axis]
    turns = ([], ["rotation"], [f"rotation-{c}" for c in "xyz" if c != own])[D - 1]
    return f"[{', '.join([own, *turns])}]"


def require_clear(
    rigid_bodies: SceneRigidBodies,
    faces: Sequence[Face],
    states: list[State],
    number: int,
    time: float,
    comm: Communicator,
) -> None:
    """Refuse free rigid bodies that overlap walls or rigid bodies; collective.

    Parameters
    ----------
    number, time : int, float
        Steps done, and the time.

    Raises
    ------
    CaseError, EndlessError
        On every rank: before the first step, and later.
    """

    def look() -> None:
        none = (0.0, 0.0, "", "")
        each = collisions(rigid_bodies, faces, states, time, number == 0)
        excess, depth, name, what = max(each, default=none)
        if excess <= 0.0:
            return
        text = (
            f"reaches {depth:.3g} cells into {what}: rigid bodies that move freely meet bodies of "
            "a material; if some of these have `formulation: total-lagrangian`, "
            "also rigid ones with which they have an entry of `contact`, and walls that let go"
        )
        if number == 0:
            with located(rigid_bodies.case):
                raise CaseError(f"bodies.{name}.region: {text}; move it, or cut it")
        raise EndlessError(
            f"at time {time:.6g}, after step {number}, the rigid body '{name}' {text}\n"
            "  try: a larger grid, a layer of a material between them, an earlier time.end, "
            "or rigid: {fixed: ..}"
        )

    on_root(comm, look)


def _within_bodies(rigid_bodies: SceneRigidBodies) -> list[_Overlap]:
    """Find overlaps too small to contain particles: depth, position and body.

    They show at points of a rigid body's surface; of a body that is within, at the deepest ones.
    """
    found, D, case = [], len(rigid_bodies.frame.cell), rigid_bodies.case
    frame, periods, surface = rigid_bodies.frame, rigid_bodies.periods, rigid_bodies.surface
    middle = np.array(frame.origin) + 0.5 * periods  # points are moved into the domain
    for t, (name, field) in enumerate(zip(rigid_bodies.names, rigid_bodies.fields, strict=True)):
        deepest = np.argsort(field.values[:, 0], kind="stable")[:64]
        deepest = deepest[field.values[deepest, 0] < 0.0]
        mine = surface.points[surface.body == t][:, :D]
        points = nearest_image(np.concatenate([field.points(deepest, D), mine]), middle, periods)
        inner = np.arange(len(points)) < len(deepest)
        for number, (own, body) in enumerate(case.bodies.items()):
            if body.region.WHOLE_BODY or not len(points) or own in case.staged.awaited:
                continue
            low, high = body.region.bounds()
            near = ((points >= low) & (points <= high)).all(axis=1)
            x, inside = points[near], inner[near]
            # Where the surface is rounded, the region says how far it is from a point.
            rigid = case.rigid_bodies[name].region.signed_distance(rigid_bodies.nearest(name, x))
            rigid[inside] = field.values[deepest, 0][near[: len(deepest)]]
            depth, least = body.region.signed_distance(x), -_TOUCH * min(frame.cell)
            both = (depth < least) & (depth + rigid < least)
            depth += rigid
            for row in np.flatnonzero(both)[:1]:
                found.append((float(depth[row]), tuple(x[row].tolist()), number, name))
    return found
