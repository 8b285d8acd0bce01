"""The surfaces of bodies that meet by them, for frames: where they are, with their loads."""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.surfaces.data import Patches, Surface
from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.loads import HEAT, IMPULSE, PRESSED, SLIP
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.scene.bodies.facet_polygons import Polygons, polygons_of
from pgimp.scene.bodies.surface_patches import Facets
from pgimp.solver.contact.surfaces.candidates import candidates_of, find_facets
from pgimp.solver.contact.surfaces.contact import SurfaceContact
from pgimp.solver.contact.surfaces.loads import Smoothed, smooth
from pgimp.solver.contact.surfaces.table import Table
from pgimp.solver.contact.surfaces.wide import parted
from pgimp.solver.rank_state import RankState

#: Cells of gap below which a facet is next to those under load.
_CLOSE = 0.01


class Sheet(NamedTuple):
    """Surfaces at one time. Of a facet that is several cells each has its part of the area."""

    position: np.ndarray  #: (points, 3) float64: Positions.
    cells: np.ndarray  #: (cells, 2^(D - 1)) int64: Points of each cell.
    #: dict of str to ndarray: Fields of cells: `body`, `normal`, `area`, and those of `SURFACE`.
    fields: dict[str, np.ndarray]


class Now(NamedTuple):
    """Facets and points where they are."""

    x: np.ndarray  #: (facets, 3) float64: Centroids.
    normal: np.ndarray  #: (facets, 3) float64: Unit normals.
    area: np.ndarray  #: (facets,) float64: Areas.
    points: np.ndarray  #: (points, 3) float64: Points of polygons.


class Sheets:
    """Makes the sheets of a run; polygons are found once."""

    def __init__(self) -> None:
        self.call = Bound()
        self._surface: Surface | None = None
        self._polygons: Polygons | None = None

    def sheet(self, rank: RankState, time: float) -> Sheet | None:
        """The present surfaces, on rank 0; collective. The loads begin anew with them."""
        contact = rank.contact
        assert isinstance(contact, SurfaceContact)
        assert contact.loads is not None
        table = contact.known(rank)
        u = contact.proximity.all_displacements(rank, table)
        loads, since = contact.loads.taken(table.surface, contact.proximity.labels)
        every = contact.proximity.everyone()
        rigid = _placed(rank, contact.rigid_bodies, time)
        beside = contact.material_gaps(rank, rigid)
        if rank.comm.rank > 0:
            return None
        if self._surface is not table.surface:
            self._surface, surface, D = table.surface, table.surface, rank.scene.dimension
            area = 2.0 * surface.radius if D == 2 else surface.area  # of rings their section's
            self._polygons = polygons_of(
                Facets(surface.x, surface.normal, area, surface.radius, surface.middle,
                       surface.half, surface.edges, surface.patch),
                surface.body, D,
            )  # fmt: skip
        assert self._polygons is not None
        poses = rank.scene.interaction.rigid_bodies.poses(
            time, rank.free.states if rank.free else []
        )
        gap = self._gaps(rank, contact, table, (u, *every), rigid)
        np.fmin.at(gap, *beside)
        now = _now(rank, table, self._polygons, u, poses)
        self._smooth(rank, table.surface, now, loads, gap)
        return _sheet(table.surface, self._polygons, now, _values(loads, since, gap))

    def _gaps(
        self,
        rank: RankState,
        contact: SurfaceContact,
        table: Table,
        near: tuple[np.ndarray, np.ndarray, np.ndarray],
        rigid: Any,
    ) -> np.ndarray:
        """Gaps of all facets, the least one of each; nan where nothing is near.

        `near` are displacements of surface vertices, candidates, facets near others; of all ranks.
        """
        (u, candidates, moving), proximity, call = near, contact.proximity, self.call
        frame, found = rank.scene.domain.frame, np.full(len(table.surface.x), np.nan)
        if not len(candidates):
            return found
        surface = table.surface._replace(
            now=np.full_like(table.surface.now, np.inf), turned=table.surface.turned.copy()
        )
        scratch = proximity.scratch
        laws = contact.laws._replace(rigid_bodies=rigid)
        moving = moving[moving < len(found)]
        call(move_facets, frame, rigid, surface, table.cells, u, moving, scratch)
        acts, marks = np.ascontiguousarray(contact.acts.T), np.zeros(len(found), np.uint8)
        others = candidates_of(
            surface,
            find_facets(
                call, surface, acts, moving, frame.cell[0], (proximity.reach, 0.0), (0, 1), marks
            ),
        )
        for every in (parted(table, candidates)[0], others):
            both = every, Patches.of(surface, every, -1.0)
            call(
                find_gaps, frame, laws, proximity.walls, surface, (table.cells, u), scratch,
                proximity.far, both,
            )  # fmt: skip
            some = every[np.isfinite(every["gap"])]
            np.fmin.at(found, some["facet"], some["gap"])
            if every is not others:  # of a body that meets itself one side looks for the other
                own = some[some["other"] >= 0]
                own = own[table.surface.body[own["facet"]] == own["body"]]
                np.fmin.at(found, own["other"], own["gap"])
        return found

    def _smooth(
        self, rank: RankState, surface: Surface, now: Now, loads: np.ndarray, gap: np.ndarray
    ) -> None:
        """Make impulses and heat smooth, in place."""
        side = min(rank.scene.domain.frame.cell)
        near = (loads[:, PRESSED] != 0.0) | (gap < _CLOSE * side)
        for columns, some in (
            (slice(IMPULSE, PRESSED + 1), near),
            (slice(HEAT, HEAT + 1), loads[:, HEAT] > 0.0),
        ):
            facets = Smoothed(now.x[some], now.normal[some], now.area[some], surface.body[some])
            loads[some, columns] = smooth(
                self.call, facets, loads[some, columns], side, rank.scene.dimension
            )


def _placed(rank: RankState, rigid: Any, time: float) -> Any:
    """The rigid bodies where they are now; the arrays of the step stay as they are."""
    if isinstance(rigid, tuple) and not rigid:
        return rigid
    every = rank.scene.interaction.rigid_bodies
    states = rank.free.states if rank.free else []
    now = rigid._replace(motion=rigid.motion.copy())
    free = dict(zip(every.free, states, strict=True))
    for number, pose in enumerate(every.poses(time, states)):
        every.place(now.motion[number], number, pose, time, free)
    return now


def _values(loads: np.ndarray, since: float, gap: np.ndarray) -> dict[str, np.ndarray]:
    """Fields of facets; those that are over the area are not divided by it yet."""
    rate = 1.0 / since if since > 0.0 else 0.0
    return {
        "contact-pressure": loads[:, PRESSED] * rate,
        "traction": loads[:, IMPULSE : IMPULSE + 3] * rate,
        "gap": gap,
        "slip": loads[:, SLIP].copy(),
        "wear-work": loads[:, HEAT].copy(),
    }


def _now(rank: RankState, table: Table, polygons: Polygons, u: np.ndarray, poses: Any) -> Now:
    """Where facets and points are, given displacements of the surface vertices."""
    surface, D = table.surface, rank.scene.dimension
    size, cell = np.array(rank.scene.domain.frame.cell), surface.cell[polygons.facet]
    points, soft = polygons.x.copy(), cell >= 0
    place = np.zeros_like(points)
    place[soft, :D] = (points[soft, :D] - table.cells.low[cell[soft], :D]) / size
    for corner, weight, _ in _hats(D, place[soft], size):
        points[soft] += weight[:, None] * u[table.cells.corners[cell[soft], corner], :3]
    x, normal, area = surface.x.copy(), surface.normal.copy(), surface.area.copy()
    own = surface.cell >= 0
    F = np.tile(np.eye(3), (int(own.sum()), 1, 1))
    for corner, weight, gradient in _hats(D, surface.place[own], size):
        moved = u[table.cells.corners[surface.cell[own], corner], :3]
        x[own] += weight[:, None] * moved
        F += moved[:, :, None] * gradient[:, None]
    # The cofactor of F times the normal, as `turned_normal`.
    cofactor = np.stack([np.cross(F[:, (i + 1) % 3], F[:, (i + 2) % 3]) for i in range(3)], axis=1)
    turned = np.einsum("nij,nj->ni", cofactor, surface.normal[own])
    length = np.sqrt((turned * turned).sum(axis=1))
    normal[own], area[own] = turned / length[:, None], area[own] * length
    rigid, first = rank.scene.interaction.rigid_bodies, len(rank.scene.body_names)
    for number, (centre, turn) in enumerate(poses):
        R, reference = np.array(turn).reshape(3, 3).T, np.array(rigid.reference(number))
        mine = surface.body == first + number
        normal[mine] = normal[mine] @ R
        x[mine] = (x[mine] - reference) @ R + np.array(centre)
        some = mine[polygons.facet]
        points[some] = (points[some] - reference) @ R + np.array(centre)
    return Now(x, normal, area, points)


def _sheet(surface: Surface, polygons: Polygons, now: Now, values: dict[str, np.ndarray]) -> Sheet:
    """The sheet, given fields of facets."""
    of = polygons.of
    fields = {"body": surface.body[of], "normal": now.normal[of]}
    fields["area"] = now.area[of] * polygons.part
    for name, each in values.items():
        whole = now.area if each.ndim == 1 else now.area[:, None]
        fields[name] = (each if name in ("gap", "slip") else each / whole)[of]
    return Sheet(now.points, polygons.cells, fields)


def _hats(D: int, place: np.ndarray, size: np.ndarray) -> Any:
    """Corners of a cell, with their weights at places, (n,), and gradients, (n, 3)."""
    for corner, ends in enumerate(product((0, 1), repeat=D)):
        each = [place[:, d] if end else 1.0 - place[:, d] for d, end in enumerate(ends)]
        gradient = np.zeros((len(place), 3))
        for d, end in enumerate(ends):
            others = np.prod([w for j, w in enumerate(each) if j != d], axis=0)
            gradient[:, d] = others * (1.0 if end else -1.0) / size[d]
        yield corner, np.prod(each, axis=0), gradient
