"""Loads of a case besides stress and gravity, and the particles that carry them."""

from collections.abc import Container, Hashable, Iterable, Sequence
from typing import Any

import numpy as np

from pgimp.case.body import has_means
from pgimp.case.locations import located
from pgimp.case.schema import Case
from pgimp.decomposition.population import Population
from pgimp.errors import CaseError
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.loads.wall_gap import Sides
from pgimp.kernels.update.viscosity import Viscosity
from pgimp.mpi.communicator import Communicator
from pgimp.physics.loads.constraints import LEAST_PART, at_places
from pgimp.physics.loads.tractions import Spread, overlaps
from pgimp.scene.bodies.merge import LEAST_FRACTION
from pgimp.scene.liquids import relaxation_rate
from pgimp.scene.surfaces import SurfaceLoads, face_stretches
from pgimp.scene.water import SceneWater


def covered_fractions(low: float, high: float, edges: np.ndarray) -> np.ndarray:
    """Covered fraction of each lattice column, given by `edges`, for the interval [low, high].

    Small fractions merge inwards, as for particles.
    """
    begin, end = edges[:-1], edges[1:]
    part = (np.minimum(end, high) - np.maximum(begin, low)) / (end - begin)
    part = np.maximum(part, 0.0)
    inside = np.flatnonzero(part)
    if len(inside) > 1:
        for small, target in ((inside[0], inside[1]), (inside[-1], inside[-2])):
            if part[small] < LEAST_FRACTION <= part[target]:
                part[target] += part[small]
                part[small] = 0.0
    return part


def ring_factors(low: float, high: float, edges: np.ndarray) -> np.ndarray:
    """Radius of the covered part's centroid over the column's, for the interval [low, high]."""
    middle = 0.5 * (np.maximum(edges[:-1], low) + np.minimum(edges[1:], high))
    return np.where(middle > 0.0, middle / (0.5 * (edges[:-1] + edges[1:])), 1.0)


class SceneLoads:
    """Viscosity, tractions, constraints and the body force.

    Parameters
    ----------
    materials : list of str
        Names of the materials in use, in the order of their parameters.
    forces : (NamedTuple or (), SceneWater or None)
        Parameters of the body force, or of an exact solution with a body force; and the water in
        the ground.
    walls : tuple of Sides or ()
        Walls whose clearances are needed, see `Loads`.
    follows : (bodies,) bool
        Whether the size of each body's particles follows the deformation.
    """

    def __init__(
        self,
        case: Case,
        materials: list[str],
        forces: tuple[Any, SceneWater | None] = ((), None),
        walls: tuple[Sides, ...] = (),
        follows: Iterable[bool] = (),
    ) -> None:
        self.case = case
        self.bodies = list(case.bodies)
        entries = [case.materials[name].viscosity for name in materials]
        self.viscosity: Viscosity | tuple[()] = ()
        if any(entries):
            self.viscosity = Viscosity(
                np.array([entry.linear if entry else 0.0 for entry in entries]),
                np.array([entry.quadratic if entry else 0.0 for entry in entries]),
                float(min(case.grid.cell)),
            )
        self.lagrangian = [body.formulation == "total-lagrangian" for body in case.bodies.values()]
        moving = not all(self.lagrangian)  # else the vertices keep the velocities
        self.relaxation: float | tuple[()] = (relaxation_rate(case) if moving else 0.0) or ()
        holds = (face.motion(0.0) is not None for face in case.boundaries.values())
        self.affine: float | tuple[()] = 1.0 if case.method.affine and moving else ()
        means = np.array([has_means(body, case.method) for body in case.bodies.values()])
        means &= case.dimensions > 1  # same in 1D
        law = [case.materials[body.material] for body in case.bodies.values()]
        rests = np.array([entry.RESTS for entry in law])
        self.rest: np.ndarray | tuple[()] = rests if rests.any() and any(holds) else ()
        weighs = case.gravity is not None
        #: Bodies whose particles always have the rates at their own places.
        self._alone = ~means | np.array([entry.LIQUID and weighs for entry in law])
        here = ~np.array(self.lagrangian, bool)
        self.mean: float | np.ndarray | tuple[()] = ()
        if means[here].any():
            self.mean = self._alone.astype(float) if self._alone[here].any() else 1.0
        self.mean_lagrangian: float | tuple[()] = 1.0 if means[~here].any() else ()
        (self.force, self.water), self.walls = forces, walls
        self.constraints = list(case.constraints.values())
        #: Of each constraint, see `LEAST_PART`; 0 where it holds all vertices that it reaches.
        self.least_parts = np.array(
            [
                LEAST_PART
                * (case.bodies[entry.body].formulation == "total-lagrangian")
                * all(force is None for force in entry.force)
                for entry in self.constraints
            ]
        )
        grid, method = case.grid, case.method
        self.half = 0.5 * np.array(grid.cell) / np.array(method.particles_per_cell)
        size = np.array(method.parameters(tuple(grid.cell)).half) * np.array(grid.cell)
        self._spread = Spread(2.0 * self.half, size, method.chi, method.ends)
        self._follows = dict(zip(self.bodies, follows, strict=False))
        self.surfaces = SurfaceLoads(case, self._follows)
        self.on_faces = self.surfaces.patched
        self.tractions = [case.tractions[name] for name in self.on_faces]
        self._width = 2.0 * size if method.chi == "box" else size
        self._varies = bool(self.force) or any(entry.varies for entry in case.tractions.values())
        self._varies |= self.surfaces.varies or bool(self.water and self.water.varies)
        self.turning = [name for name, entry in case.constraints.items() if entry.rotation]
        self.placed = any(entry.placed for entry in self.constraints)
        own = (entry.field for entry in self.constraints)
        self.velocity_fields = tuple(field.source() for field in own if field)
        self._constraints_vary = any(entry.varies for entry in self.constraints)
        self._loads = self._at(0.0)
        self._constraints = self._constraints_at(0.0, 0.0)

    @property
    def averages(self) -> bool:
        """Whether cells have one dilatation each, of any bodies."""
        return not (isinstance(self.mean, tuple) and isinstance(self.mean_lagrangian, tuple))

    @property
    def carried(self) -> dict[str, Any]:
        """Particle columns of the loads, see `Carried`."""
        return {
            "affine": bool(self.affine),
            "viscous": bool(self.viscosity),
            "mean": self.averages,
            "cell_F": not isinstance(self.mean_lagrangian, tuple),
            "tractions": len(self.tractions),
            "surfaces_loaded": len(self.surfaces.entries),
            "follows_surfaces": bool(self.surfaces.following.any()),
        }

    def at(self, t: float) -> Loads:
        """Loads of the step that begins at time `t`."""
        return self._at(t) if self._varies else self._loads

    def constraints_at(self, start: float, end: float) -> tuple:
        """Parameters of the constraints for a step."""
        return self._constraints_at(start, end) if self._constraints_vary else self._constraints

    def _at(self, t: float) -> Loads:
        from pgimp.physics.exact.base import BodyForce

        tractions = tuple(
            entry.parameters(i, self._spread, bool(self._follows.get(entry.body, False)), t)
            for i, entry in enumerate(self.tractions)
        )
        source = self.water.at(t, self.force) if self.water else self.force
        force = BodyForce(source, t) if source else ()
        mean_lagrangian = self.mean_lagrangian if all(self.lagrangian) else ()
        return Loads(
            self.viscosity, tractions, force, self.relaxation, self.affine, self.walls, self.mean,
            mean_lagrangian, self.rest, self.surfaces.at(t),
        )  # fmt: skip

    def _constraints_at(self, start: float, end: float) -> tuple:
        if not self.placed:
            return tuple(entry.parameters(start, end) for entry in self.constraints)
        like, before = (0.0,) * self.case.dimensions, self.case.staged.displacements
        return at_places(self.case.constraints, (start, end), before, (self.velocity_fields, like))

    @property
    def booked_constraints(self) -> list[Hashable]:
        """Names of the rows of constraints in the ledger: impulses, then moments of what turns."""
        return [*self.case.constraints, *((name, "moment") for name in self.turning)]

    @property
    def booked_tractions(self) -> list[Hashable]:
        """Names of the rows of tractions in the ledger: on faces, then on regions' surfaces."""
        return [*self.on_faces, *self.surfaces.entries]

    def angle(self, number: int, t: float) -> float:
        """Angle by which a constraint of `turning` has turned until `t`, with previous stages."""
        name = self.turning[number]
        return self.case.staged.angles.get(name, 0.0) + self.case.constraints[name].angle(t)

    def displacement(
        self, number: int, t: float, moved: Sequence[float]
    ) -> tuple[float | None, ...]:
        """Displacement of a constraint's particles until `t`, with previous stages.

        `moved` is the displacement under given forces. None along directions that are free.
        """
        name, entry = list(self.case.constraints)[number], self.constraints[number]
        before = self.case.staged.displacements.get(name, (0.0,) * len(entry.rigid))
        each = zip(entry.rigid, entry.displacement(t), before, moved, strict=False)
        return tuple(
            (shift or 0.0) + offset + more if rigid else None for rigid, shift, offset, more in each
        )

    def initialise(self, p: Particles, n: int) -> None:
        """Set patches and constraints of the first `n` particles, in their initial state."""
        rows = slice(0, n)
        if self.averages and self._alone.any():
            p.isolation[rows, 0] = self._alone[p.body[rows]]
        for i, entry in enumerate(self.tractions):
            mine = np.flatnonzero(p.body[rows] == self.bodies.index(entry.body))
            body = self.case.bodies[entry.body]
            low, high = body.region.bounds()
            parts, columns = [], []
            for d in range(len(self.half)):
                edges, centres = self._lattice(d)
                columns.append(np.searchsorted(centres, p.x[mine, d]))
                if body.surface != "whole-particles":
                    parts.append(covered_fractions(low[d], high[d], edges))
                    if d == 0 and self.case.axisymmetric:
                        parts[0] *= ring_factors(low[0], high[0], edges)
                else:
                    parts.append(((low[d] <= centres) & (centres < high[d])).astype(float))
            overlap = overlaps(self._width[entry.axis], 2.0 * self.half[entry.axis])
            p.patch[mine, i] = entry.areas(parts, columns, 2.0 * self.half, overlap)
            if self.case.axisymmetric:  # at the middle, or the outer side, of each box
                side = self.half[0] * entry.side * (entry.axis == 0)
                p.patch[mine, i] *= 2.0 * np.pi * (self._lattice(0)[1] + side)[columns[0]]
        for name in {entry.body for entry in self.constraints}:
            number = self.bodies.index(name)
            mine = np.flatnonzero(p.body[rows] == number)
            p.constraint[mine, 0] = self.held(number, p.x[mine])

    def held(self, body: int, x: np.ndarray) -> np.ndarray:
        """Constraint of each particle of a body, in its initial state, (n,) int64.

        Constraints are numbered from 1; the last of several takes precedence; 0 stands for none.
        """
        number = np.zeros(len(x), np.int64)
        for i, entry in enumerate(self.constraints):
            if entry.body == self.bodies[body]:
                number[entry.region.contains(x)] = i + 1
        return number

    def require_held(self, counts: np.ndarray, bodies: Container[str] | None = None) -> None:
        """Refuse constraints that hold no particle, of all bodies that are there or of some.

        `counts`, (constraints + 1,) int64, are of the particles of each, numbered as in `held`.

        Raises
        ------
        CaseError
            If there is one.
        """
        for i, (name, entry) in enumerate(self.case.constraints.items()):
            awaited = entry.body in self.case.staged.awaited
            if counts[i + 1] == 0 and not awaited and (bodies is None or entry.body in bodies):
                with located(self.case):
                    raise CaseError(
                        f"constraints.{name}.region: contains no particle of body "
                        f"'{self.constraints[i].body}'; its particles are "
                        f"{', '.join(f'{2 * h:.6g}' for h in self.half)} apart"
                    )

    def require_all_hold(
        self, p: Particles, n: int, comm: Communicator, bodies: Container[str] | None = None
    ) -> None:
        """Refuse constraints that hold none of the first `n` particles of any rank; collective.

        `bodies` are those of the particles, by default all that are there.

        Raises
        ------
        CaseError
            On every rank, if there is one.
        """
        if self.constraints:
            held = np.bincount(p.constraint[:n, 0], minlength=len(self.constraints) + 1)
            self.require_held(np.sum(comm.allgather(held), axis=0), bodies)

    def _lattice(self, d: int) -> tuple[np.ndarray, np.ndarray]:
        """Edges and centres of the lattice's columns along direction `d`, as `Lattice` has them."""
        grid, n = self.case.grid, self.case.method.particles_per_cell[d]
        points = np.arange(grid.cells[d] * n + 1)
        low, cell = grid.origin[d], grid.cell[d]
        return low + points / n * cell, low + (points[:-1] + 0.5) / n * cell

    def scale_patches(
        self, population: Population, comm: Communicator, bodies: Container[str] | None = None
    ) -> None:
        """Scale the patches of each traction to the whole area of its face; collective.

        By default of all bodies.

        Small parts merged into other particles leave some area without a carrier.
        """
        if not self.tractions:
            return
        p, start = population.up_to_date(), population.start
        rows = population.order.astype(np.int64)
        sums = np.zeros((len(start) - 1, len(self.tractions)))
        layer = np.repeat(np.arange(len(sums)), np.diff(start))
        areas = p.patch[rows]
        for i, entry in enumerate(self.tractions):  # of what begins deformed, current ones
            areas[:, i] *= face_stretches(p.F[rows], entry.axis, self.case.dimensions)
        np.add.at(sums, layer, areas)  # one after the other, in canonical order
        total = np.add.reduce(np.concatenate(comm.allgather(sums)), axis=0)
        for i, (entry, area) in enumerate(zip(self.tractions, total, strict=True)):
            if area > 0.0 and (bodies is None or entry.body in bodies):
                region = self.case.bodies[entry.body].region
                ring = self.case.axisymmetric
                exact = entry.area_of_ring(region) if ring else entry.area(region)
                if exact is not None:
                    p.patch[rows, i] *= exact / area
