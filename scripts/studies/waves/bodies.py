"""Frequencies of free bodies cut anywhere by the grid, from the kernels of a step.

References are Ritz's: polynomials over the body, of a degree at which they are exact to 1e-5.
"""

from itertools import product

import numpy as np
from studies.scenes import ball, box, case_of, core

from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD

COURANT, MODES = 0.3, 12
SHIFT = np.array([3.37, 3.21, 3.59])
LAW = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
LAME, SHEAR = 100.0 * 0.3 / (1.3 * 0.4), 100.0 / 2.6
SPEED = float(np.sqrt(LAME + 2.0 * SHEAR))

#: Sides in cells, () of what is round; degree of the reference.
BODIES = {
    "square": ((16.0, 16.0), 18), "disk": (16.0, 14), "strip": ((16.0, 4.0), 24),
    "cube": ((12.0, 12.0, 12.0), 12), "ball": (12.0, 9),
}  # fmt: skip
WAYS = tuple(product(("boxes", "cut"), ("lumped", "averaged")))

#: Vectors beyond the modes that are looked for, and degree of the polynomials that filter them.
_MORE, _DEGREE = 8, 30


def _sides(name):
    """Extents of a body."""
    size = BODIES[name][0]
    return np.array(size if isinstance(size, tuple) else [size] * (3 if name == "ball" else 2))


class Operator:
    """M^-1 K of a body: the velocities that a step gives to a body at rest that is displaced."""

    def __init__(self, name, surface, mass):
        sides = _sides(name)
        D = len(sides)
        low = SHIFT[:D]
        round_one = name in ("disk", "ball")
        region = ball(low + 0.5 * sides, 0.5 * sides[0]) if round_one else box(low, low + sides)
        body = {"material": "soft", "formulation": "total-lagrangian", "region": region}
        self.dt = COURANT / SPEED
        bodies = {"body": body | {"surface": surface}}
        cells = [int(s) + 8 for s in sides]
        case = case_of(cells, 1.0, {"soft": LAW}, bodies, 1.0, method={"mass": mass})
        case["time"] = {"end": 1e9 * self.dt, "step": self.dt}
        self.sim = core(case)
        self.values = self.sim.rank.grid.kept.values.reshape(-1, RECORD)
        self.there = np.flatnonzero(self.values[:, KEPT_MASS] > 0.0)
        self.root, self.D = np.sqrt(np.repeat(self.values[self.there, KEPT_MASS], D)), D
        self.start = [column.copy() for column in self.sim.particles]

    def __call__(self, u):
        """The product with a vector, both times the roots of the lumped masses."""
        rank, size = self.sim.rank, 1e-6 / np.abs(u / self.root).max()
        for column, before in zip(self.sim.particles, self.start, strict=True):
            column[:] = before
        velocity = slice(KEPT_VELOCITY, KEPT_VELOCITY + self.D)
        self.values[:, DISPLACEMENT : DISPLACEMENT + 3] = 0.0
        given = size / self.dt * (u / self.root)
        self.values[self.there, velocity] = given.reshape(-1, self.D)
        if rank.slaves:
            rank.slaves.spread(rank, rank.grid.kept.values, KEPT_VELOCITY)
        self.sim.advance()
        self.values[:, velocity] = 0.0
        self.sim.advance()
        v = self.values[self.there, velocity]
        return self.root * v.reshape(-1) / (-self.dt * size)


def frequencies(name, surface, mass):
    """The first frequencies, as steps of the Courant number give them, and the highest one.

    By subspaces that polynomials of Chebyshev filter.
    """
    A, rigid = Operator(name, surface, mass), 3 if len(_sides(name)) == 2 else 6
    rng, n = np.random.default_rng(1), len(A.root)
    u = rng.normal(size=n)
    for _ in range(60):
        u /= np.sqrt(u @ u)
        u = A(u)
    top = np.sqrt(u @ u)
    X, low, before = rng.normal(size=(n, rigid + MODES + _MORE)), 0.06 * top, np.zeros(MODES)
    middle = 1.02 * top
    for _ in range(30):
        half, centre = 0.5 * (middle - low), 0.5 * (middle + low)
        for x in X.T:
            last, now = x.copy(), (A(x) - centre * x) / half
            for _ in range(_DEGREE - 1):
                last, now = now, 2.0 / half * (A(now) - centre * now) - last
            x[:] = now / np.sqrt(now @ now)
        X = np.linalg.qr(X)[0]
        squares, V = np.linalg.eig(X.T @ np.stack([A(x) for x in X.T], axis=1))
        V = np.where(squares.imag < 0.0, V.imag, V.real)  # of pairs that have not settled, both
        order = np.argsort(squares.real)
        X, squares = X @ V[:, order], squares[order].real
        low, found = squares[-1], squares[rigid : rigid + MODES]
        if np.abs(found / np.where(before > 0.0, before, 1.0) - 1.0).max() < 1e-5:
            break
        before = found
    w = np.sqrt(found)
    return 2.0 / A.dt * np.arcsin(0.5 * A.dt * w), float(np.sqrt(top))


def _quadrature(name, count):
    """Points in a body, with its centre at 0, and their weights."""
    sides, (x, w) = _sides(name), np.polynomial.legendre.leggauss(count)
    D = len(sides)
    if name not in ("disk", "ball"):
        points = np.stack(np.meshgrid(*(0.5 * s * x for s in sides), indexing="ij"), axis=-1)
        weights = np.ones(())
        for s in sides:
            weights = weights[..., None] * (0.5 * s * w)
        return points.reshape(-1, D), weights.reshape(-1)
    R, angle = 0.5 * sides[0], np.arange(2 * count) * np.pi / count
    r, wr = 0.5 * R * (x + 1.0), 0.5 * R * w
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    around = np.full(2 * count, np.pi / count)
    if D == 3:
        sine = np.sqrt(1.0 - x * x)[:, None, None] * unit
        unit = np.concatenate([sine, np.broadcast_to(x[:, None, None], (count, 2 * count, 1))], -1)
        unit, around = unit.reshape(-1, 3), (w[:, None] * around).reshape(-1)
    points = (r[:, None, None] * unit).reshape(-1, D)
    return points, ((wr * r ** (D - 1))[:, None] * around).reshape(-1)


def reference(name, degree=None):
    """The first frequencies of the continuum, from polynomials of a degree."""
    degree = degree or BODIES[name][1]
    sides, (points, weights) = _sides(name), _quadrature(name, degree + 2)
    D, half = len(sides), 0.5 * sides
    powers = np.array([p for p in product(range(degree + 1), repeat=D) if sum(p) <= degree])
    eye = np.eye(degree + 1)
    legendre = np.polynomial.legendre
    each = [legendre.legvander(points[:, d] / half[d], degree) for d in range(D)]
    slope = [
        legendre.legval(points[:, d] / half[d], legendre.legder(eye)).T / half[d] for d in range(D)
    ]

    def values(which):
        found = np.sqrt(weights)[:, None] * np.ones(len(powers))
        for d in range(D):
            found = found * (slope if d == which else each)[d][:, powers[:, d]]
        return found

    R = np.linalg.qr(values(-1), mode="r")
    gradients = [np.linalg.solve(R.T, values(d).T).T for d in range(D)]
    G = [[a.T @ b for b in gradients] for a in gradients]
    trace = sum(G[d][d] for d in range(D))
    K = np.block([
        [LAME * G[i][j] + SHEAR * (G[j][i] + (trace if i == j else 0.0)) for j in range(D)]
        for i in range(D)
    ])  # fmt: skip
    squares = np.linalg.eigvalsh(0.5 * (K + K.T))
    rigid = 3 if D == 2 else 6
    return np.sqrt(squares[rigid : rigid + MODES])


def rows(names=tuple(BODIES)):
    """Rows: errors by surface and mass, and the highest frequencies over those of lumped mass."""
    for name in names:
        exact = reference(name)
        found = {way: frequencies(name, *way) for way in WAYS}
        errors = [100.0 * np.sqrt(np.mean((w / exact - 1.0) ** 2)) for w, _ in found.values()]
        tops = [found[way, "averaged"][1] / found[way, "lumped"][1] for way in ("boxes", "cut")]
        cells = f"{_sides(name)[0]:g} cells"
        yield [f"{name}, {cells}", *(f"{each:.2f}" for each in errors),
               *(f"{each:.3f}" for each in tops)]  # fmt: skip
