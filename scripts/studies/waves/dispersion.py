"""Speeds of plane waves on an endless lattice, with averaged mass: by the code's own weights."""

from itertools import product
from math import floor

import numpy as np

from pgimp.physics.shapes import SHAPES
from pgimp.physics.shapes.averaging import averaged_part

#: Cells a wave at which errors count.
CELLS = {1: (6, 8, 10), 2: (8, 10, 13), 3: (8, 10, 13)}

#: Part of the best alpha that is taken: hardly less accurate, and steps may be longer.
TAKEN = {1: 1.0, 2: 0.9, 3: 0.9}
#: Poisson's ratio.
RATIO = 0.3


def directions(D, count=40):
    """Unit vectors, evenly spread over the symmetric part: along axes and between."""
    if D == 1:
        return np.ones((1, 1))
    rng = np.random.default_rng(1)
    found = rng.normal(size=(count, D))
    return found / np.linalg.norm(found, axis=1)[:, None]


def lattice(shape, n):
    """Weights and gradients at vertices -4 to 4 of the particles of a cell, cells of size 1."""
    entry = SHAPES[shape].model_validate({"shape": shape, "particles-per-cell": [n]})
    own = entry.fixed((1.0,))
    half, found = own.half[0], []
    for i in range(n):
        x = (i + 0.5) / n
        first = floor(x - half + 1e-9)
        w, g = type(own).weights(own, half, x - first)
        row = np.zeros((2, 9))
        row[0, first + 4 : first + 4 + len(w)], row[1, first + 4 : first + 4 + len(w)] = w, g
        found.append(row)
    return found


def waves(shape, n, k):
    """Squares of the frequencies of exp(i k x) with lumped mass, and C/L; rho = E = 1."""
    D, one = len(k), lattice(shape, n)
    nu = 0.0 if D == 1 else RATIO
    lam, mu = nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 / (1.0 + nu)
    e = [np.exp(1j * q * np.arange(-4, 5)) for q in k]
    N, G = ([[row[i] @ e[d] for row in one] for d in range(D)] for i in (0, 1))
    C, K = 0.0, np.zeros((D, D), complex)
    for at in product(range(n), repeat=D):
        g = np.array([
            np.prod([(G if d == a else N)[d][at[d]] for d in range(D)]) for a in range(D)
        ])  # fmt: skip
        C += abs(np.prod([N[d][at[d]] for d in range(D)])) ** 2 / n**D
        K += (lam * np.outer(g.conj(), g) + mu * np.outer(g, g.conj())
              + mu * np.vdot(g, g).real * np.eye(D)) / n**D  # fmt: skip
    return np.linalg.eigvalsh((K + K.conj().T) / 2), C


def speeds(D):
    """Speeds of waves, in the order of `waves`: shear waves first."""
    if D == 1:
        return np.ones(1)
    lam, mu = RATIO / ((1.0 + RATIO) * (1.0 - 2.0 * RATIO)), 0.5 / (1.0 + RATIO)
    return np.array([mu**0.5] * (D - 1) + [(lam + 2.0 * mu) ** 0.5])


class Errors:
    """Relative errors of speeds of waves of some lengths in all directions, for any part alpha."""

    def __init__(self, shape, D, n, cells=None):
        self.rows = []
        for count, u in product(cells or CELLS[D], directions(D)):
            k = 2.0 * np.pi / count
            self.rows.append((k, *waves(shape, n, k * u)))
        self.c = speeds(D)

    def __call__(self, alpha, courant):
        """(waves, kinds) errors, with steps of a Courant number."""
        found, dt = [], courant / self.c[-1]
        for k, squares, C in self.rows:
            w = np.sqrt(np.abs(squares) * (1.0 + alpha * (1.0 - C)))
            w = 2.0 / dt * np.arcsin(np.minimum(1.0, dt * w / 2.0)) if dt else w
            found.append(w / k / self.c - 1.0)
        return np.array(found)

    def rms(self, alpha, courant):
        """Of P and S waves alike."""
        e = self(alpha, courant) ** 2
        parts = [e[:, -1:], e[:, :-1]] if e.shape[1] > 1 else [e]
        return float(np.sqrt(np.mean([part.mean() for part in parts])))


def part(shape, D, n, courant):
    """The part that pgimp takes."""
    return averaged_part(shape, (n,) * D, courant)


def best(shape, D, n):
    """Alpha = a - b courant^2 with the least errors; (a, b)."""
    errors, scan = Errors(shape, D, n), np.linspace(0.0, 1.0, 201)
    courants = np.array([0.0, 0.3, 0.5, 0.7])
    parts = [scan[np.argmin([errors.rms(x, c) for x in scan])] for c in courants]
    inner = np.array(parts) < 1.0
    if inner.sum() < 2:
        return TAKEN[D], 0.0
    b, a = np.polyfit(courants[inner] ** 2, np.array(parts)[inner], 1)
    return TAKEN[D] * float(a), -TAKEN[D] * float(b)
