"""What every problem of scripts/pareto has: its case, its start, and its error.

Young's modulus, density and the length of a body are 1 unless a case of cases/ says otherwise, so
that waves cross a body in a unit of time. Boxes are run on the grid's lines, as a body that has
been fitted to it, and 0.3 cells off them, as one that has not or that has moved: errors of free
surfaces show in one of them only, and may be of either sign. The error is the root mean square.
"""

from abc import ABC, abstractmethod

import numpy as np
from studies.scenes import by_id, case_of, core, throw

#: Places of a box on the grid, in cells.
PLACES = (0.0, 0.3)


class Problem(ABC):
    """A problem with a reference.

    It has a name as key and a title in pictures, `sizes` of cells across the length that it is
    resolved by, coarsest first, `quick` cells of a run that only shows that it works, and the
    `target`, the error whose price is asked for. Whether MLS-MPM on one grid can do it is `peer`,
    whether its error is known in the initial configuration, `initial`.
    """

    name: str
    title: str
    D: int
    sizes: tuple[int, ...]
    quick: int
    target: float
    peer: bool = True
    initial: bool = True
    #: Walls and their kinds, in the words of the case.
    walls: tuple[tuple[str, str], ...] = ()
    poisson = 0.0

    def __init__(self, kind, D, places=PLACES):
        """Of a kind, in D dimensions; `off` is the present place on the grid."""
        self.name, self.title, self.D = f"{kind}-{D}d", f"{kind}, {D}D", D
        self.places, self.off = places, places[-1]
        self.target = 0.01 if D == 2 else 0.1

    @abstractmethod
    def case(self, method, n):
        """The case of a method with n cells."""

    def start(self, X, n):
        """Velocity (k, D) and its gradient (k, D, D) at places; None: those of the case."""
        return None

    def error(self, n, X, x, v, m):
        """Relative L2 error at the end, of particles that began at X."""
        raise NotImplementedError  # where `found` is another

    def begin(self, method, n):
        """Simulation, and the particles' first places by id."""
        sim = core(self.case(method, n))
        p, rows = sim.particles, sim.live()
        X = by_id(sim, p.x[rows])
        start = self.start(X, n)
        if start is not None:
            v, L = start
            throw(sim, v[p.id[rows]], L[p.id[rows]])
            if sim.watch:  # of steps that pgimp chooses
                sim.watch.begin(sim.rank)
        return sim, X

    def vortex(self, stiffness):
        """For the peer, what the body force of a generalised vortex needs; None: there is none."""
        return None

    def step(self, sim):
        """Called after every step, which is not timed."""

    def found(self, sim, X, n):
        """Error of a simulation that has ended."""
        p, rows = sim.particles, sim.live()
        ids = p.id[rows]
        return self.error(n, X[ids], p.x[rows], p.v[rows], p.m[rows])


def body_case(problem, method, size, h, region, end):
    """A case of one elastic body; the domain's size is in cells, whose edge is h."""
    elastic = {"model": "neo-hookean", "young": 1.0, "poisson": problem.poisson, "density": 1.0}
    body = {
        "material": "elastic",
        "formulation": "total-lagrangian" if method.initial else "current",
        "region": region,
    }
    return case_of(
        [float(round(s)) * h for s in size[: problem.D]], h, {"elastic": elastic}, {"body": body},
        end, courant=method.courant, per_cell=method.per_cell, boundaries=dict(problem.walls),
        method={"shape": method.shape, "affine": method.affine, "mass": method.mass},
    )  # fmt: skip


def rms(difference, exact, m):
    """Relative L2 error: the root of the sums of squares, weighted with the masses."""
    above, below = (m @ (u.reshape(len(m), -1) ** 2).sum(axis=1) for u in (difference, exact))
    return float(np.sqrt(above / below))
