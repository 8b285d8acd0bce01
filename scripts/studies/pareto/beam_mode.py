"""Slowest vibration of a clamped beam by quadratic finite elements, Poisson's ratio 0.

Nine-node quadrilaterals, small strain. With Poisson's ratio 0 plane strain is plane stress, and a
beam in 3D moves as one in 2D: one mode serves both.
"""

from functools import cache

import numpy as np

GAUSS = np.polynomial.legendre.leggauss(3)


def _functions(s):
    """Quadratic functions on [-1, 1] and their derivatives, (3, ...)."""
    values = np.array([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)])
    return values, np.array([s - 0.5, -2.0 * s, s + 0.5])


class Mode:
    """The slowest mode of a beam held at x = 0, with a greatest displacement of 1.

    Young's modulus and density are 1.

    Attributes
    ----------
    rate : float
        Angular frequency.
    """

    def __init__(self, length, height, elements):
        nx, ny = elements
        self.size, self.elements = np.array([length / nx, height / ny]), np.array(elements)
        self.rows = 2 * ny + 1
        nodes = (2 * nx + 1) * self.rows
        K, M = np.zeros((2 * nodes, 2 * nodes)), np.zeros((2 * nodes, 2 * nodes))
        stiffness, mass = self._element()
        for i in range(nx):
            for j in range(ny):
                node = [(2 * i + p) * self.rows + 2 * j + q for p in range(3) for q in range(3)]
                at = np.array([2 * n + d for n in node for d in range(2)])
                K[np.ix_(at, at)] += stiffness
                M[np.ix_(at, at)] += mass
        free = np.arange(2 * self.rows, 2 * nodes)
        K, M = K[np.ix_(free, free)], M[np.ix_(free, free)]
        flexible = np.linalg.inv(K)
        u = np.ones(len(free))
        for _ in range(12):  # the next mode is six times as fast
            u = flexible @ (M @ u)
            u /= np.abs(u).max()
        self.rate = float(np.sqrt((u @ K @ u) / (u @ M @ u)))
        self.nodal = np.concatenate([np.zeros(2 * self.rows), u]).reshape(-1, 2)

    def _element(self):
        stiffness, mass = np.zeros((18, 18)), np.zeros((18, 18))
        C = np.diag([1.0, 1.0, 0.5])
        hx, hy = self.size
        for s, ws in zip(*GAUSS, strict=True):
            for t, wt in zip(*GAUSS, strict=True):
                (a, da), (b, db) = _functions(s), _functions(t)
                B, N = np.zeros((3, 18)), np.zeros((2, 18))
                B[0, 0::2] = B[2, 1::2] = np.outer(da, b).ravel() * 2.0 / hx
                B[1, 1::2] = B[2, 0::2] = np.outer(a, db).ravel() * 2.0 / hy
                N[0, 0::2] = N[1, 1::2] = np.outer(a, b).ravel()
                area = 0.25 * ws * wt * hx * hy
                stiffness += area * B.T @ C @ B
                mass += area * N.T @ N
        return stiffness, mass

    def at(self, places):
        """Displacement (n, 2) and its gradient (n, 2, 2) at places (n, 2); y from the low edge."""
        inside = np.clip((places / self.size).astype(int), 0, self.elements - 1)
        (a, da), (b, db) = map(_functions, (2.0 * (places / self.size - inside) - 1.0).T)
        first = 2 * inside[:, 0] * self.rows + 2 * inside[:, 1]
        nodes = first + (self.rows * np.arange(3)[:, None, None] + np.arange(3)[:, None])
        u = self.nodal[nodes]  # (3, 3, n, 2)
        value = np.einsum("pn,qn,pqnd->nd", a, b, u)
        slope = np.stack(
            [
                np.einsum("pn,qn,pqnd->nd", da, b, u) * 2.0 / self.size[0],
                np.einsum("pn,qn,pqnd->nd", a, db, u) * 2.0 / self.size[1],
            ],
            axis=-1,
        )
        return value, slope


@cache
def beam(length=4.0, height=1.0, elements=(32, 8)):
    """The mode of the beam of `small_bodies.Bending`."""
    return Mode(length, height, elements)
