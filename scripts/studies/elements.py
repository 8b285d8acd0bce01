"""Quadratic finite elements for references: nine-node quadrilaterals of a beam held at x = 0."""

import numpy as np


def rule(count):
    """Gauss's points and weights on [-1, 1]."""
    return np.polynomial.legendre.leggauss(count)


def lagrange(s):
    """Quadratic functions on [-1, 1] and their derivatives, (3, ...)."""
    values = np.array([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)])
    return values, np.array([s - 0.5, -2.0 * s, s + 0.5])


class Mesh:
    """Equal elements of a beam, so many along it and across it."""

    def __init__(self, length, height, elements):
        self.elements = nx, ny = elements
        self.size = length / nx, height / ny
        self.rows = 2 * ny + 1
        self.nodes = (2 * nx + 1) * self.rows
        #: Displacements that are not held.
        self.free = np.arange(2 * self.rows, 2 * self.nodes)

    def points(self, count):
        """Strains (3, 18) of the displacements, functions (9,) and area at an element's points."""
        hx, hy = self.size
        for s, ws in zip(*rule(count), strict=True):
            for t, wt in zip(*rule(count), strict=True):
                (a, da), (b, db) = lagrange(s), lagrange(t)
                B = np.zeros((3, 18))
                B[0, 0::2] = B[2, 1::2] = np.outer(da, b).ravel() * 2.0 / hx
                B[1, 1::2] = B[2, 0::2] = np.outer(a, db).ravel() * 2.0 / hy
                yield B, np.outer(a, b).ravel(), ws * wt * hx * hy / 4.0

    def displacements(self):
        """Place of each element along the beam, and its 18 displacements among all."""
        for i in range(self.elements[0]):
            for j in range(self.elements[1]):
                node = [(2 * i + p) * self.rows + 2 * j + q for p in range(3) for q in range(3)]
                yield i, np.array([2 * n + d for n in node for d in range(2)])

    def matrix(self, element):
        """The sum of an element's matrix (18, 18) over all, of the displacements not held."""
        found = np.zeros((2 * self.nodes, 2 * self.nodes))
        for _, at in self.displacements():
            found[np.ix_(at, at)] += element
        return found[np.ix_(self.free, self.free)]
