"""What rigid bodies must be: slow enough, apart from others, and the same as before."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pgimp.case.places import located
from pgimp.errors import CaseError, EndlessError, UsageError
from pgimp.kernels.tools import distances
from pgimp.mpi.collective import on_root
from pgimp.scene.faces import Face
from pgimp.scene.freebody import State
from pgimp.scene.tools import SceneTools


def require_slow(tools: SceneTools, dt: float) -> None:
    """Refuse a first step in which a body would move by more than a cell."""
    rate = tools.first_rate
    if rate * dt > 1.0 + 1e-9:
        with located(tools.case):
            raise CaseError(
                f"time.step: a rigid body moves by {rate * dt:.3g} cells in a step of {dt:.3g}, "
                f"and would pass through what it meets; use at most {0.3 / rate:.3g}, or a slower "
                "body"
            )


def require_same(tools: SceneTools, checksum: str) -> None:
    """Refuse to go on with other bodies than a run began with."""
    if checksum != tools.checksum:
        raise UsageError(
            "the rigid bodies are not those of the run: has the file of a mesh changed? Put it "
            "back, or start over with --overwrite"
        )


def require_apart(
    tools: SceneTools,
    blocks: Iterable[tuple[NDArray[np.float64], NDArray[np.int32]]],
    comm: Any,
) -> None:
    """Refuse bodies that overlap rigid ones at the start; collective.

    Particles that a surface cuts may have their centre beyond it by half their size.

    Parameters
    ----------
    blocks : iterable of (n, D) float64 and (n,) int
        Positions of this rank's particles, and their bodies.

    Raises
    ------
    CaseError
        On every rank.
    """
    size = np.array(tools.frame.cell) / np.array(tools.case.method.particles_per_cell)
    least = 0.5 * float(np.sqrt(np.square(size).sum()))
    placed, found = tools.at(0.0, 0.0), []
    for x, body in blocks:
        distance = np.empty(len(x))
        for t, name in enumerate(tools.names):
            distances(placed, t, tools.frame, x, distance)
            if len(x) and distance.min() < -least:
                deepest = int(distance.argmin())
                place = tuple(x[deepest].tolist())
                found.append((float(distance[deepest]), place, int(body[deepest]), name))
    every = [one for some in comm.allgather(found) for one in some]
    every += on_root(comm, partial(_within_bodies, tools))
    if not every:
        return
    deep, place, body, name = min(every)
    with located(tools.case):
        raise CaseError(
            f"bodies.{name}.region: '{list(tools.case.bodies)[body]}' reaches {-deep:.3g} into "
            f"the rigid '{name}' at ({', '.join(f'{c:.6g}' for c in place)}); bodies must not "
            "overlap at the start: move or cut one of them"
        )


def collisions(
    tools: SceneTools, faces: Sequence[Face], states: list[State], time: float
) -> Iterator[tuple[float, float, str, str]]:
    """Yield what free rigid bodies have run into that they do not feel: walls, and rigid bodies.

    Yields
    ------
    excess : float
        By how much it is farther in than may be, in cells.
    depth : float
        How far it is in, in cells.
    name, what : str
        That of the body, and what it has run into.
    """
    frame, points = tools.frame, tools.surface_at(tools.poses(time, states))
    placed, least = tools.at(time, time, states), min(frame.cell)
    for number in tools.free:
        mine = np.ascontiguousarray(points[tools.surface.body == number][:, : len(frame.cell)])
        for face in faces:
            wall = frame.origin[face.axis]
            if face.side > 0:
                wall += frame.cells[face.axis] * frame.cell[face.axis]
            depth = float(((mine[:, face.axis] - wall) * face.side).max(initial=0.0)) / least
            yield depth - 0.5, depth, tools.names[number], f"the wall {face.name}"
        distance = np.empty(len(mine))
        for other, name in enumerate(tools.names):
            if other != number:
                distances(placed, other, frame, mine, distance)
                depth = max(0.0, -float(distance.min(initial=0.0))) / least
                # Farther in than half of a thin body it would be on its way out.
                limit = min(0.5, 0.25 * tools.thick[other] / least)
                yield depth - limit, depth, tools.names[number], f"the rigid body '{name}'"


def require_clear(
    tools: SceneTools,
    faces: Sequence[Face],
    states: list[State],
    number: int,
    time: float,
    comm: Any,
) -> None:
    """Refuse free rigid bodies that are in walls or rigid ones; collective.

    Parameters
    ----------
    number, time : int, float
        Steps done, and the time that it is.

    Raises
    ------
    CaseError, EndlessError
        On every rank: before the first step, and later.
    """

    def look() -> None:
        none = (0.0, 0.0, "", "")
        excess, depth, name, what = max(collisions(tools, faces, states, time), default=none)
        if excess <= 0.0:
            return
        text = (
            f"reaches {depth:.3g} cells into {what}: rigid bodies that move freely feel bodies of "
            "a material only"
        )
        if number == 0:
            with located(tools.case):
                raise CaseError(f"bodies.{name}.region: {text}; move it, or cut it")
        raise EndlessError(
            f"at time {time:.6g}, after step {number}, the rigid body '{name}' {text}\n"
            "  try: a larger grid, a layer of a material between them, an earlier time.end, "
            "or rigid: {fixed: ..}"
        )

    on_root(comm, look)


def _within_bodies(tools: SceneTools) -> list[tuple[float, tuple[float, ...], int, str]]:
    """Find rigid bodies too small for particles in them: how deep, where, in what body."""
    found, D = [], len(tools.frame.cell)
    for name, field in zip(tools.names, tools.fields, strict=True):
        deepest = np.argsort(field.values[:, 0], kind="stable")[:64]
        deepest = deepest[field.values[deepest, 0] < 0.0]
        points = field.points(deepest, D)
        for number, body in enumerate(tools.case.bodies.values()):
            if body.region.WHOLE_BODY or not len(points):
                continue
            inside = body.region.distance(points) < -0.1 * min(tools.frame.cell)
            for row in np.flatnonzero(inside)[:1]:
                deep = float(field.values[deepest[row], 0])
                found.append((deep, tuple(points[row].tolist()), number, name))
    return found
