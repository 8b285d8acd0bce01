"""Watches for surfaces too deep in another body: for stress there, or to meet it at all."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import pi
from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.surfaces.data import Surface
from pgimp.kernels.contact.surfaces.gaps import DEEPEST
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.spread import scratch_of
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.surfaces.table import Table
from pgimp.solver.time.clock import Step

#: Cells by which surfaces may overlap without a word.
MOST = 0.05

#: Steps between two looks, at least. There is one besides as soon as surfaces overlap too much, and
#: at the end: a blow may be over by then.
PAUSE = 200

#: Solid angle all round a point, by dimensions, and diameters of a cluster beyond which its facets
#: are seen as one.
_ALL_ROUND, _FAR = (0.0, 2.0, 2.0 * pi, 4.0 * pi), 1.5

#: Part of the area of a closed surface that its area vectors may leave.
_CLOSED = 1e-3

#: Cosine with its normal from which a way leads into a body, or out of it.
_ASKEW = 0.3


class OverrunWatch:
    """Counts patches deeper than `DEEPEST` in a body that they should have met, or in their own.

    A point is in a body that it sees all round: the solid angle of its surface is 4 pi. So the
    watch does not rest on the search for what is near, nor on how thin a body is. Particles in
    rigid bodies are counted elsewhere.

    Parameters
    ----------
    scene : Scene
        The scene.
    names : list of str
        Names of bodies and rigid bodies.
    """

    def __init__(self, scene: Scene, names: list[str]) -> None:
        self._scene, self._names, self._call = scene, names, Bound()
        self._told: set[tuple[int, int]] = set()
        self._last = -PAUSE

    def due(self, done: Step) -> bool:
        """Whether it is time for another look, and note that it was."""
        if done.number < self._last + PAUSE:
            return False
        self._last = done.number
        return True

    def look(
        self, table: Table, acts: np.ndarray, u: np.ndarray, rigid: Any, done: Step
    ) -> list[str]:
        """Return a warning for each pair of bodies in which contact was overrun, once.

        Parameters
        ----------
        acts : (bodies, bodies) uint8
            Whether facets of the first body look for those of the second.
        u : (vertices, 4) float64
            Displacements of all surface vertices, the last 0.
        rigid : RigidBodies or ()
            The rigid bodies at their positions.
        """
        said = []
        frame, D, soft = self._scene.domain.frame, self._scene.dimension, self._scene.body_names
        surface = table.surface
        # Of rings the section is looked at.
        area = 2.0 * surface.radius if D == 2 else surface.area
        surface = surface._replace(now=surface.x.copy(), turned=surface.normal.copy(), area=area)
        table = table._replace(surface=surface)
        every, deep = np.arange(len(surface.x)), DEEPEST * min(frame.cell)
        self._call(move_facets, frame, rigid, surface, table.cells, u, every, scratch_of(D))
        order = np.lexsort((every, -surface.area, surface.patch))
        some = order[np.unique(surface.patch[order], return_index=True)[1]]
        point, normal, body = surface.now[some], surface.turned[some], surface.body[some]
        periods = self._scene.domain.periods
        for a, b in _overlapping(
            acts | acts.T, (body, point), (surface.body, surface.now), deep, periods
        ):
            two = (min(a, b), max(a, b))
            if two in self._told or (a < len(soft)) != (b < len(soft)):
                continue
            of, its = surface.now[surface.body == b], np.flatnonzero(body == a)
            low, high = of.min(axis=0)[:D] + deep, of.max(axis=0)[:D] - deep
            images = point[its]
            images[:, :D] -= periods * np.round(
                (images[:, :D] - 0.5 * (low + high)) / np.where(periods > 0.0, periods, np.inf)
            )
            inside = ((images[:, :D] > low) & (images[:, :D] < high)).all(axis=1)
            its, images = its[inside], images[inside]
            if not len(its) or not self._closed(table, b):
                continue
            for way in (*np.eye(3)[:D], *-np.eye(3)[:D]):  # inside, and so far from its surface
                least = np.full(len(its), 0.5)
                if a == b:  # its own surface is there, too
                    along = normal[its] @ way
                    least += np.where(along < -_ASKEW, 1.0, np.where(along > _ASKEW, 0.0, 0.5))
                in_it = self._turns(table, surface, b, u, images + deep * way) > least
                its, images = its[in_it], images[in_it]
                if not len(its):
                    break
            if len(its):
                self._told.add(two)
                said.append(self._text(self._names[a], self._names[b], point[its], done))
        return said

    def _closed(self, table: Table, b: int) -> bool:
        """Whether a body's surface is closed, with its images beyond planes of symmetry."""
        some = table.surface.body == b
        area = table.surface.area[some]
        left = np.abs(area @ table.surface.normal[some])
        left[[axis for axis, _ in self._planes]] = 0.0
        return bool(left.max() < _CLOSED * area.sum())

    @property
    def _planes(self) -> list[tuple[int, int]]:
        periodic, held = self._scene.domain.periodic, self._scene.interaction.loads.surfaces.closed
        axis = [(0, -1)] if self._scene.case.axisymmetric else []
        return [*(face for face in held if not periodic[face[0]]), *axis]

    def _images(self, points: np.ndarray) -> Iterator[np.ndarray]:
        """Points, their images beyond planes at which surfaces end, and the next across seams."""
        frame, periods = self._scene.domain.frame, self._scene.domain.periods
        ways: list[list[float | None]] = [[None] for _ in range(self._scene.dimension)]
        for axis, side in self._planes:
            length = frame.cells[axis] * frame.cell[axis]
            ways[axis].append(frame.origin[axis] + (length if side > 0 else 0.0))
        turns = product(*((-1, 0, 1) if period > 0.0 else (0,) for period in periods))
        for way, turn in product(product(*ways), [*turns]):
            image = points.copy()
            for axis, place in enumerate(way):
                if place is not None:
                    image[:, axis] = 2.0 * place - points[:, axis]
                image[:, axis] += turn[axis] * periods[axis]
            yield image

    def _turns(
        self, table: Table, surface: Any, b: int, u: np.ndarray, points: np.ndarray
    ) -> np.ndarray:
        """Solid angle of a body's surface at points, over that all round: 1 inside, 0 outside."""
        D, found = self._scene.dimension, np.zeros(len(points))
        images = list(self._images(points))
        for c in np.flatnonzero(table.body == b).tolist():
            some = table.members[table.first[c] : table.first[c + 1]]
            x, area = surface.now[some], self._areas(table, surface, some, u)
            middle = 0.5 * (x.min(axis=0) + x.max(axis=0))
            size = max(np.sqrt(((x - middle) ** 2).sum(axis=1).max()), 1e-9 * surface.area.max())
            for image in images:
                away = np.sqrt(((image - middle) ** 2).sum(axis=1))
                far = away > 2.0 * _FAR * size
                found[far] += _angle(middle[None], area.sum(axis=0)[None], image[far], D)
                found[~far] += _angle(x, area, image[~far], D)
        return found / _ALL_ROUND[D]

    def _areas(self, table: Table, surface: Any, some: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Current area vectors of facets, (n, 3), by Nanson's formula."""
        frame, D, c = self._scene.domain.frame, self._scene.dimension, surface.cell[some]
        if c[0] < 0:
            return surface.turned[some] * surface.area[some, None]
        F = np.tile(np.eye(3), (len(some), 1, 1))
        place = surface.place[some]
        for number, corner in enumerate(product((0, 1), repeat=D)):
            at = u[table.cells.corners[c, number], :3]
            hats = [place[:, d] if corner[d] else 1.0 - place[:, d] for d in range(D)]
            for j in range(D):
                rest = [hats[d] for d in range(D) if d != j]
                way = (1.0 if corner[j] else -1.0) * frame.inverse[j]
                F[:, :, j] += way * at * np.prod([np.ones(len(some)), *rest], axis=0)[:, None]
        cofactor = np.cross(F[:, :, [1, 2, 0]], F[:, :, [2, 0, 1]], axis=1)
        normal = np.einsum("nij,nj->ni", cofactor, surface.normal[some])
        return normal * surface.area[some, None]

    def _text(self, a: str, b: str, points: np.ndarray, done: Step) -> str:
        whose = f"its own, '{a}'" if a == b else f"'{b}'"
        many = "a place" if len(points) == 1 else f"{len(points)} places"
        at = ", ".join(f"{x:.4g}" for x in points[0, : self._scene.dimension])
        return (
            f"contact was overrun: at {many} the surface of '{a}' is deeper than a quarter of a "
            f"cell in {whose} at time {done.end:.6g}, as near ({at}). There it meets nothing, and "
            "what follows is no result: take shorter steps, smaller cells, or edges less sharp"
        )


def _overlapping(
    acts: np.ndarray, own: tuple[np.ndarray, np.ndarray], its: tuple[np.ndarray, np.ndarray],
    deep: float, periods: np.ndarray,
) -> list[tuple[int, int]]:  # fmt: skip
    """Pairs of bodies of which points of the first may be deep in the second, ascending.

    Both have bodies, (n,), and points there, (n, 3); `periods` are (D,), 0 without one.
    """
    D = len(periods)
    ends = np.full((4, len(acts), D), np.inf)
    for k, (body, x) in enumerate((own, its)):
        np.minimum.at(ends[2 * k], body, x[:, :D])
        np.minimum.at(ends[2 * k + 1], body, -x[:, :D])
    least, most, low, high = ends[0], -ends[1], ends[2] + deep, -ends[3] - deep
    a, b = np.nonzero(acts)
    joined = (periods > 0.0) & np.isfinite(most[a]) & np.isfinite(high[b])
    near = (((most[a] > low[b]) & (least[a] < high[b])) | joined).all(axis=1)
    return [*zip(a[near].tolist(), b[near].tolist(), strict=True)]


def _angle(x: np.ndarray, area: np.ndarray, points: np.ndarray, D: int) -> np.ndarray:
    """Solid angle of facets at each point, of outer sides seen from within."""
    way = x - points[:, None]
    distance = np.sqrt((way * way).sum(axis=2))
    angle = np.einsum("pfd,fd->pf", way, area) / np.where(distance > 0.0, distance, 1.0) ** D
    half = 0.5 * _ALL_ROUND[D]  # no facet is more, however near
    return np.clip(angle, -half, half).sum(axis=1)


class Depth:
    """The deepest facet since the last line of the history.

    Parameters
    ----------
    scene : Scene
        The scene.
    names : list of str
        Names of bodies and rigid bodies; walls come after them.
    """

    def __init__(self, scene: Scene, names: list[str]) -> None:
        self._names, self._D, self._cell = names, scene.dimension, min(scene.domain.frame.cell)
        self._told: set[tuple[int, int]] = set()
        self._found: list[tuple] = []  # gap, bodies, time and place

    def note(self, every: np.ndarray, deepest: int, surface: Surface, time: float) -> None:
        """Note the deepest facet of a step, of those near others; below 0 there is none."""
        least = self._found[0][0] if self._found else -MOST * self._cell
        if 0 <= deepest < len(every) and every["gap"][deepest] < least:
            at = every[deepest]
            a, facet = int(at["body"]), int(at["facet"])
            place = tuple(surface.now[facet, : self._D].tolist())
            self._found = [(float(at["gap"]), int(surface.body[facet]), a, time, place)]

    def look(self, comm: Communicator) -> list[str]:
        """Return a warning for two bodies, once, if they overlapped too much; collective."""
        every = sorted(each for found in comm.allgather(self._found) for each in found)
        self._found = []
        for gap, a, b, time, place in every[:1]:
            two = (min(a, b), max(a, b))
            if two in self._told:
                continue
            self._told.add(two)
            names = [f"'{self._names[n]}'" if n < len(self._names) else "a wall" for n in (a, b)]
            at = ", ".join(f"{x:.4g}" for x in place)
            return [
                f"surfaces overlap: {names[0]} was {-gap / self._cell:.2g} cells deep in "
                f"{names[1]} at time {time:.6g}, near ({at}). More than {MOST:g} is too much for "
                "stress there to be right: take smaller cells, shorter steps, or edges less sharp"
            ]
        return []
