"""Weights of particles on all vertices of a grid, in plain NumPy, from their equations.

Arrays over all vertices, the ones beyond the faces too, are zero outside the support.
"""

import numpy as np
from kernel_driver import follows, initial_half
from quadrature import chi_of, integrals


def weights(name, xi, L, half):
    """Weight S_vp and its gradient in 1D, xi = x_p - x_v.

    (35) for mpm, (40) for gimp, the integrals (19, 20) themselves for the shapes of any size.
    """
    r, sign = np.abs(xi), np.sign(xi)
    if name == "mpm":
        inside = r < L
        return np.where(inside, 1 - r / L, 0.0), np.where(inside, -sign / L, 0.0)
    if name != "gimp":
        weight, slope = integrals(chi_of(name), half, 0.0, -xi, L)
        return weight[0], slope[0]
    cases = [r < half, r < L - half, r < L + half]
    weight = [
        1 - (xi**2 + half**2) / (2 * L * half),
        1 - r / L,
        (L + half - r) ** 2 / (4 * L * half),
    ]
    slope = [-xi / (L * half), -sign / L, -sign * (L + half - r) / (2 * L * half)]
    return np.select(cases, weight, 0.0), np.select(cases, slope, 0.0)


class ReferenceWeights:
    """A grid, and what particles have of its vertices: arrays over all vertices."""

    def __init__(self, name, per_cell, frame):
        self.name, self.frame = name, frame
        self.D = len(frame.cells)
        cells = [initial_half(name, n) for n in per_cell]
        self.half = np.array(cells) * np.array(frame.cell)
        self.vertices = [
            origin + (np.arange(cells + 1 + 2 * frame.ghost) - frame.ghost) * L
            for origin, L, cells in zip(frame.origin, frame.cell, frame.cells, strict=True)
        ]
        self.shape = tuple(len(x) for x in self.vertices)

    def half_widths(self, F):
        """Of a particle, and whether they had to be clamped to a cell.

        A box of half-widths l has the second moments l^2/3 along the axes and none across; F
        makes them F l^2 F^T/3. A tent's are l^2/6.
        """
        half = self.half
        if self.name == "cpdi-corners":  # of the box round the corners
            half = np.abs(np.reshape(F, (self.D, self.D)) * half).sum(axis=1)
        elif follows(self.name):
            F = np.reshape(F, (self.D, self.D))
            half = np.sqrt(np.diag(F @ np.diag(half**2) @ F.T))
        return np.minimum(half, self.frame.cell), bool((half > self.frame.cell).any())

    def of(self, x, F):
        """S_vp, (vertices), and grad S_vp, (vertices, D), of a particle at x: products (19, 20)."""
        if self.name == "cpdi-corners":
            return self.of_corners(x, F)
        half, _ = self.half_widths(F)
        pairs = [
            weights(self.name, x[d] - self.vertices[d], self.frame.cell[d], half[d])
            for d in range(self.D)
        ]
        S = np.ones(self.shape)
        grad = np.ones((*self.shape, self.D))
        for d, (w, g) in enumerate(pairs):
            along = [1] * self.D
            along[d] = -1
            S = S * w.reshape(along)
            for i in range(self.D):
                grad[..., i] *= (g if i == d else w).reshape(along)
        return S, grad

    def of_corners(self, x, F):
        """Means over the corners, and the gradient of the affine field that fits them best."""
        edges = np.reshape(F, (self.D, self.D)) * self.half
        edges *= np.minimum(self.frame.cell / np.abs(edges).sum(axis=1), 1.0)[:, None]
        S, grad = np.zeros(self.shape), np.zeros((*self.shape, self.D))
        signs = np.array(list(np.ndindex(*[2] * self.D))) * 2.0 - 1.0
        corners = signs @ edges.T
        slopes = np.linalg.pinv(corners)  # (D, corners)
        for c, corner in enumerate(corners):
            N = np.ones(())
            for d, along in enumerate(self.vertices):
                r = np.abs(x[d] + corner[d] - along) / self.frame.cell[d]
                N = np.multiply.outer(N, np.maximum(1.0 - r, 0.0))
            S += N / len(corners)
            grad += N[..., None] * slopes[:, c]
        return S, grad

    def dilatation_of(self, x, F):
        """dD_p/dv_v, (vertices, D): cell by cell, with the part of the particle's box in each.

        A cell's rate is the mean divergence of the multilinear field of its corners.
        """
        half, _ = self.half_widths(F)
        part = np.ones(())
        for d, along in enumerate(self.vertices):
            low = np.maximum(along[:-1], x[d] - half[d])
            high = np.minimum(along[1:], x[d] + half[d])
            part = np.multiply.outer(part, np.maximum(high - low, 0.0) / (2 * half[d]))
        found = np.zeros((*self.shape, self.D))
        for corner in np.ndindex(*[2] * self.D):
            cells = tuple(slice(i, i + n) for i, n in zip(corner, part.shape, strict=True))
            signs = (2.0 * np.array(corner) - 1.0) / 2 ** (self.D - 1)
            found[cells] += part[..., None] * signs / self.frame.cell
        return found
