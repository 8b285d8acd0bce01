"""A ring that shears itself, a disk that hits a wall, cylinders that are pressed together."""

from functools import cache
from math import pi, sin

import numpy as np
from ruamel.yaml import YAML
from studies.harness import CASES
from studies.pareto.candidates import Method
from studies.pareto.problem_base import Problem, body_case, rms
from studies.scenes import ball, finished

from pgimp.solver.state.grid_state import active_grid


def turned(X, amplitude):
    """Places of the vortex's ring, from X: turned most in the middle, at a radius of 1."""
    s = (np.hypot(*X.T) - 1.0) / 0.5
    angle = amplitude * np.where(np.abs(s) < 0.5, (1.0 - 4.0 * s * s) ** 2, 0.0)
    c, q = np.cos(angle), np.sin(angle)
    return np.stack([c * X[:, 0] - q * X[:, 1], q * X[:, 0] + c * X[:, 1]], axis=1)


class Vortex(Problem):
    """The ring of cases/vortex.yaml at a quarter of its period, turned by up to 0.15 radians."""

    sizes, quick = (8, 16, 32), 4
    amplitude, end = 0.15, 0.5
    poisson = 0.3

    def __init__(self):
        super().__init__("vortex", 2, (0.0,))

    def case(self, method, n):
        h, k = 0.5 / n, round(3.0 * n) + 2
        balls = [ball([0.0, 0.0], r) for r in (1.25, 0.75)]
        case = body_case(self, method, [2 * k, 2 * k], h, {"difference": balls}, self.end)
        case["grid"]["origin"] = [-k * h, -k * h]
        case["materials"]["elastic"] |= {"young": 1000.0, "density": 1000.0}
        return case | {
            "exact": {"generalized-vortex": {"amplitude": self.amplitude, "period": 2.0}}
        }

    def vortex(self, stiffness):
        """Amplitude, angular frequency, radius, width, stiffness."""
        return [self.amplitude, pi, 1.0, 0.5, stiffness]

    def error(self, n, X, x, v, m):
        exact = turned(X, self.amplitude * sin(pi * self.end))
        return rms(x - exact, exact - X, m)


class Impact(Problem):
    """A disk hits a wall that lets go, at a twentieth of sqrt(E/rho), and flies off, ringing.

    What is compared with a run on far finer cells is the smooth part of its velocity afterwards,
    the cubic polynomials: the rebound, and the vibrations that have taken the rest of the energy.
    """

    sizes, quick = (8, 16, 32, 64), 4
    walls = (("y-min", "unilateral"),)
    poisson = 0.3
    speed, gap, end = 0.05, 0.05, 8.0
    fine, finest = 128, Method("finite-gimp", True)
    powers = tuple((i, j) for i in range(4) for j in range(4 - i))

    def __init__(self):
        super().__init__("impact", 2, (0.3,))

    def case(self, method, n):
        region = ball(self.centre(n), 0.5)
        case = body_case(self, method, [n + 9, round(1.6 * n)], 1.0 / n, region, self.end)
        case["bodies"]["body"]["velocity"] = [0.0, -self.speed]
        return case

    def centre(self, n):
        """Of the disk at the start."""
        return [0.5 + (4.0 + self.off) / n, 0.5 + self.gap]

    def error(self, n, X, x, v, m):
        places = np.linspace(-0.5, 0.5, 101)
        disk = np.stack(np.meshgrid(places, places), axis=-1).reshape(-1, 2)
        terms = self.terms(disk[(disk**2).sum(axis=1) < 0.25])
        apart = terms @ (self.coefficients(n, X, v, m) - self.reference())
        return float(np.sqrt((apart**2).sum(axis=1).mean()) / self.speed)

    def terms(self, Z):
        """The polynomials at places from the centre, (k, 10)."""
        return np.stack([Z[:, 0] ** i * Z[:, 1] ** j for i, j in self.powers], axis=1)

    def coefficients(self, n, X, v, m):
        """Of the smooth part of a velocity, (10, 2)."""
        root = np.sqrt(m)[:, None]
        return np.linalg.lstsq(self.terms(X - self.centre(n)) * root, v * root, rcond=None)[0]

    @cache
    def reference(self):
        """Coefficients on fine cells."""
        sim, X = self.begin(self.finest, self.fine)
        finished(sim)
        p, rows = sim.particles, sim.live()
        return self.coefficients(self.fine, X[p.id[rows]], p.v[rows], p.m[rows])


class Hertz(Problem):
    """The cylinders of cases/hertz-line.yaml: the forces between them at the grid's vertices.

    Hertz's pressure for the way that they are pressed gives the exact ones. In the initial
    configuration the grid has no such forces: pairs exchange impulses, not determined one by one.
    """

    sizes, quick, peer, initial = (11, 22, 33), 11, False, False
    half_width, top = 10.75e-3, 59.05e3
    held = 0.065  # from then on

    def __init__(self):
        super().__init__("Hertz's contact", 2, (0.0,))
        self.name, self.target, self.forces = "hertz-2d", 0.05, []

    def case(self, method, n):
        case = YAML(typ="safe").load(CASES / "hertz-line.yaml")
        h = 2.4e-3 * 44 / n
        case["grid"] = {"size": [(n + 2) * h, 0.2112], "cell": [h, h]}
        case["method"] = {
            "shape": method.shape, "affine": method.affine,
            "particles-per-cell": [method.per_cell] * 2,
        }  # fmt: skip
        case["time"]["step"] = {"courant": method.courant}
        deep = max(2.4e-3, h / method.per_cell)  # a layer of particles at least
        case["constraints"]["press"]["region"]["box"]["min"][1] = 0.2 - deep
        for key in ("output", "history"):
            del case[key]
        return case

    def begin(self, method, n):
        """As all, with no forces yet."""
        self.forces, self.cell = [], 2.4e-3 * 44 / n
        return super().begin(method, n)

    def step(self, sim):
        """Take down the forces of contact while the flat face is held."""
        if sim.time < self.held + 1e-3 * len(self.forces):
            return
        found = active_grid(sim.rank, sim.time, sim.dt)
        column = np.rint(found.position[:, 0] / self.cell).astype(int)
        force = np.abs(found.contact[:, 1])
        self.forces.append(np.bincount(column[column >= 0], force[column >= 0]))

    def found(self, sim, X, n):
        """Relative L2 error of the mean forces; None if the run did not come there."""
        if not self.forces:
            return None
        width = max(map(len, self.forces))
        mean = np.mean([np.pad(one, (0, width - len(one))) for one in self.forces], axis=0)
        exact = self.exact(width)
        return float(np.linalg.norm(mean - exact) / np.linalg.norm(exact))

    def exact(self, width):
        """Integrals of the pressure times the tents of vertices at 0, h, ..., at 0 of its half."""
        s = np.linspace(0.0, self.half_width, 20001)
        s = 0.5 * (s[1:] + s[:-1])
        each = self.top * np.sqrt(1.0 - (s / self.half_width) ** 2) * (s[1] - s[0])
        tents = np.maximum(0.0, 1.0 - np.abs(s / self.cell - np.arange(width)[:, None]))
        return tents @ each
