"""Torque of the twisted bar of `scenes.TWISTED` over Saint-Venant's, by quadratic finite elements.

The grips, as long as half the bar's width, hinder the warping of the section beside them. Small
strain; an eighth of the bar in hexahedra of 27 nodes. Run it to see how it converges, with grips to
1.006, and where only the end sections are turned to 1, which is Saint-Venant's:

    PYTHONPATH=scripts .venv/bin/python -m studies.auto.twisted_bar
"""

from itertools import product

import numpy as np
from studies.elements import lagrange, rule


def stiffness(along, across, grip=0.5, poisson=0.3, free=3.0):
    """Torque over 0.1406 G a^4 by the twist a length, of a square bar with sides a = 1.

    `along` and `across` are elements of half the free length and of half a side.
    """
    held = np.linspace(0.0, grip, 2 * max(2, along // 4) + 1)[1:] if grip else []
    x = np.append(np.linspace(0.0, 0.5 * free, 2 * along + 1), 0.5 * free + np.array(held))
    y = np.linspace(0.0, 0.5, 2 * across + 1)
    shape = len(x), len(y), len(y)
    number = np.arange(np.prod(shape)).reshape(shape)
    X, Y, Z = np.meshgrid(x, y, y, indexing="ij")
    K = np.zeros((3 * number.size,) * 2)
    for i, j, k in product(*(range(0, n - 1, 2) for n in shape)):
        nodes = number[i : i + 3, j : j + 3, k : k + 3].ravel()
        at = (3 * nodes[:, None] + np.arange(3)).ravel()
        K[np.ix_(at, at)] += _element(float(x[i + 2] - x[i]), float(y[2]), poisson)
    # It turns against its middle section; sides of the eighth that the symmetries hold.
    known, u = np.zeros((*shape, 3), dtype=bool), np.zeros((*shape, 3))
    known[:, 0, :, ::2] = known[:, :, 0, :2] = known[0, :, :, 1:] = True
    turned = 0.5 * free - 1e-9 < X
    known[turned, 1:] = True
    u[turned, 1], u[turned, 2] = -Z[turned], Y[turned]
    known, u = known.ravel(), u.ravel()
    u[~known] = -np.linalg.solve(K[np.ix_(~known, ~known)], K[np.ix_(~known, known)] @ u[known])
    # G = 1; the twist of half the free length is 1, and its energy half of torque times twist.
    return float(4.0 * u @ K @ u) / (0.140577 / (0.5 * free))


_KNOWN = {}


def _element(length, side, poisson):
    """Stiffness of an element with the shear modulus 1."""
    if (length, side) not in _KNOWN:
        C, K = np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0]), np.zeros((81, 81))
        C[:3, :3] += 2.0 * poisson / (1.0 - 2.0 * poisson)
        for points in product(zip(*rule(3), strict=True), repeat=3):
            values = [lagrange(s) for s, _ in points]
            B = np.zeros((6, 81))
            for d, size in enumerate((length, side, side)):
                parts = [values[e][e == d] for e in range(3)]
                slope = np.einsum("i,j,k", *parts).ravel() * 2.0 / size
                B[d, d::3] = slope
                for row, (a, b) in enumerate(((0, 1), (1, 2), (0, 2)), start=3):
                    if d in (a, b):
                        B[row, a + b - d :: 3] = slope
            K += np.prod([w for _, w in points]) * length * side * side / 8.0 * B.T @ C @ B
        _KNOWN[length, side] = K
    return _KNOWN[length, side]


if __name__ == "__main__":
    for along, across in ((4, 2), (8, 3), (12, 4)):
        print(along, across, *(f"{stiffness(along, across, grip):.5f}" for grip in (0.5, 0.0)))
