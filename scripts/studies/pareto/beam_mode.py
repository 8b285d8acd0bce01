"""Slowest vibration of a clamped beam by quadratic finite elements, Poisson's ratio 0.

Nine-node quadrilaterals, small strain. With Poisson's ratio 0 plane strain is plane stress, and a
beam in 3D moves as one in 2D: one mode serves both.
"""

from functools import cache

import numpy as np
from studies.elements import Mesh, lagrange


class Mode:
    """The slowest mode of a beam held at x = 0, with a greatest displacement of 1.

    Young's modulus and density are 1; `rate` is the angular frequency.
    """

    def __init__(self, length, height, elements):
        self.mesh = mesh = Mesh(length, height, elements)
        C = np.diag([1.0, 1.0, 0.5])
        stiffness, mass = np.zeros((18, 18)), np.zeros((18, 18))
        for B, functions, area in mesh.points(3):
            N = np.zeros((2, 18))
            N[0, 0::2] = N[1, 1::2] = functions
            stiffness += area * B.T @ C @ B
            mass += area * N.T @ N
        K, M = mesh.matrix(stiffness), mesh.matrix(mass)
        flexible = np.linalg.inv(K)
        u = np.ones(len(mesh.free))
        for _ in range(12):  # the next mode is six times as fast
            u = flexible @ (M @ u)
            u /= np.abs(u).max()
        self.rate = float(np.sqrt((u @ K @ u) / (u @ M @ u)))
        self.nodal = np.concatenate([np.zeros(2 * mesh.rows), u]).reshape(-1, 2)

    def at(self, places):
        """Displacement (n, 2) and its gradient (n, 2, 2) at places (n, 2); y from the low edge."""
        size, elements = np.array(self.mesh.size), np.array(self.mesh.elements)
        inside = np.clip((places / size).astype(int), 0, elements - 1)
        (a, da), (b, db) = map(lagrange, (2.0 * (places / size - inside) - 1.0).T)
        first = 2 * inside[:, 0] * self.mesh.rows + 2 * inside[:, 1]
        nodes = first + (self.mesh.rows * np.arange(3)[:, None, None] + np.arange(3)[:, None])
        u = self.nodal[nodes]  # (3, 3, n, 2)
        value = np.einsum("pn,qn,pqnd->nd", a, b, u)
        slope = np.stack(
            [
                np.einsum("pn,qn,pqnd->nd", da, b, u) * 2.0 / size[0],
                np.einsum("pn,qn,pqnd->nd", a, db, u) * 2.0 / size[1],
            ],
            axis=-1,
        )
        return value, slope


@cache
def beam(length=4.0, height=1.0, elements=(32, 8)):
    """The mode of the beam of `small_bodies.Bending`."""
    return Mode(length, height, elements)
