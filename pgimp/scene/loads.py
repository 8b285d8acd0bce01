"""What a case adds to stress and gravity, and which of its particles carry or feel it."""

from typing import Any

import numpy as np

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.kernels.loads import Loads
from pgimp.kernels.viscosity import Viscosity
from pgimp.solver.particles import Particles
from pgimp.solver.population import Population

#: Part of a particle's width along a face's normal, below which it is too thin to carry tractions.
_THIN = 1e-3


class SceneLoads:
    """Viscosity, tractions, constraints and the body force of an exact solution.

    Parameters
    ----------
    case : Case
        The case.
    materials : list of str
        Names of the materials in use, in the order of their parameters.
    exact : NamedTuple or ()
        Parameters of the exact solution whose body force acts, if it has one.
    """

    def __init__(self, case: Case, materials: list[str], exact: Any = ()) -> None:
        self.case = case
        self.bodies = list(case.bodies)
        entries = [case.materials[name].viscosity for name in materials]
        self.viscosity: Any = ()
        if any(entries):
            self.viscosity = Viscosity(
                np.array([entry.linear if entry else 0.0 for entry in entries]),
                np.array([entry.quadratic if entry else 0.0 for entry in entries]),
                float(min(case.grid.cell)),
            )
        self.relaxation: Any = float(case.method.relaxation) or ()
        self.exact = exact
        self.tractions = list(case.tractions.values())
        self.constraints = list(case.constraints.values())
        grid, method = case.grid, case.method
        self.half = 0.5 * np.array(grid.cell) / np.array(method.particles_per_cell)
        patch = tuple(float(h) for h in self.half) if method.extended else (0.0,) * len(self.half)
        self._patch = (patch, method.follows)
        self._varies = bool(exact) or any(entry.varies for entry in self.tractions)
        self._grips_vary = any(entry.varies for entry in self.constraints)
        self._loads = self._at(0.0)
        self._grips = self._grips_at(0.0, 0.0)

    @property
    def columns(self) -> dict[str, Any]:
        """The columns that particles need, for `Particles.empty`."""
        return {
            "viscous": bool(self.viscosity),
            "tractions": len(self.tractions),
            "grips": bool(self.constraints),
        }

    def at(self, t: float) -> Loads:
        """Loads of the step that begins at time `t`."""
        return self._at(t) if self._varies else self._loads

    def grips(self, start: float, end: float) -> tuple:
        """Parameters of the constraints for a step."""
        return self._grips_at(start, end) if self._grips_vary else self._grips

    def _at(self, t: float) -> Loads:
        from pgimp.exact.base import BodyForce

        tractions = tuple(
            entry.parameters(2 * i, *self._patch, t) for i, entry in enumerate(self.tractions)
        )
        force = BodyForce(self.exact, t) if self.exact else ()
        return Loads(self.viscosity, tractions, force, self.relaxation)

    def _grips_at(self, start: float, end: float) -> tuple:
        return tuple(entry.parameters(start, end) for entry in self.constraints)

    def attach(self, p: Particles, n: int) -> None:
        """Give the first `n` particles, in their initial state, their patches and grips."""
        rows = slice(0, n)
        for i, entry in enumerate(self.tractions):
            mine = p.body[rows] == self.bodies.index(entry.body)
            patch = np.zeros((int(mine.sum()), 2))
            body = self.case.bodies[entry.body]
            entry.attach(body.region, p.x[rows][mine], self.half, self._outermost(entry), patch)
            p.patch[np.flatnonzero(mine), 2 * i : 2 * i + 2] = patch
            if not self._patch[1] and not self._patch[0][0]:
                p.patch[rows, 2 * i + 1] = 0.0  # a point carries all at its place
        for i, constraint in enumerate(self.constraints):
            mine = p.body[rows] == self.bodies.index(constraint.body)
            p.grip[rows, 0][mine & constraint.region.contains(p.x[rows])] = i + 1

    def _outermost(self, entry: Any) -> float:
        """Coordinate along the normal of the particles nearest to a traction's face."""
        body, d = self.case.bodies[entry.body], entry.axis
        low, high = body.region.min[d], body.region.max[d]
        origin, h = self.case.grid.origin[d], float(self.half[d])
        first = int(np.floor((low - origin) / (2 * h)))
        last = int(np.ceil((high - origin) / (2 * h)))
        x = origin + h * (2.0 * np.arange(first, last) + 1.0)
        if body.surface == "whole":
            enough = (low <= x) & (x < high)
        else:
            part = (np.minimum(x + h, high) - np.maximum(x - h, low)) / (2 * h)
            enough = part >= min(_THIN, part.max())
        return float(x[enough].max() if entry.side > 0 else x[enough].min())

    def settle(self, population: Population, comm: Any) -> None:
        """Let the patches of each traction have the whole area of its face; collective.

        Slivers that were merged into other particles leave a small part without a carrier.

        Raises
        ------
        CaseError
            On every rank: if a constraint holds no particle.
        """
        if not self.tractions and not self.constraints:
            return
        p, start = population.particles, population.start
        rows = population.order.astype(np.int64)
        sums = np.zeros((len(start) - 1, len(self.tractions)))
        layer = np.repeat(np.arange(len(sums)), np.diff(start))
        np.add.at(sums, layer, p.patch[rows, 0::2])  # one after the other, in canonical order
        held = np.bincount(p.grip[rows].ravel(), minlength=len(self.constraints) + 1)
        everywhere = comm.allgather((sums, held))
        total = np.add.reduce(np.concatenate([part[0] for part in everywhere]), axis=0)
        for i, (entry, area) in enumerate(zip(self.tractions, total, strict=True)):
            if area > 0.0:
                exact = entry.area(self.case.bodies[entry.body].region)
                p.patch[rows, 2 * i] *= exact / area
        counts = np.sum([part[1] for part in everywhere], axis=0)
        for i, name in enumerate(self.case.constraints):
            if counts[i + 1] == 0:
                raise CaseError(
                    f"constraints.{name}.region: holds no particle of body "
                    f"'{self.constraints[i].body}'; its particles are "
                    f"{', '.join(f'{2 * h:.6g}' for h in self.half)} apart"
                )
