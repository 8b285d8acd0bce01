"""Deflection of the cantilever of cases/hard/bending.yaml by quadratic finite elements.

Small strain; nine-node quadrilaterals whose volume change is integrated at 2 x 2 points (selective
reduced integration, Malkus and Hughes 1978), so that they do not lock.
"""

import numpy as np

#: Gauss's points and weights on [-1, 1].
FULL = np.polynomial.legendre.leggauss(3)
REDUCED = np.polynomial.legendre.leggauss(2)


def _lagrange(s):
    """Quadratic functions on [-1, 1] and their derivatives."""
    values = np.array([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)])
    return values, np.array([s - 0.5, -2.0 * s, s + 0.5])


def _points(rule, hx, hy):
    """Strains of the 18 displacements, area and functions at each point of an element."""
    for s, ws in zip(*rule, strict=True):
        for t, wt in zip(*rule, strict=True):
            (a, da), (b, db) = _lagrange(s), _lagrange(t)
            B = np.zeros((3, 18))
            B[0, 0::2] = B[2, 1::2] = np.outer(da, b).ravel() * 2.0 / hx
            B[1, 1::2] = B[2, 0::2] = np.outer(a, db).ravel() * 2.0 / hy
            yield B, ws * wt * hx * hy / 4.0, np.outer(a, b).ravel()


def mean_deflection(young, poisson, length, height, traction, elements):
    """Mean of u_y over the beam, held at x = 0, under a shear traction at x = length.

    Parameters
    ----------
    elements : (int, int)
        Along the beam and across it.
    """
    nx, ny = elements
    hx, hy = length / nx, height / ny
    mu = young / (2.0 * (1.0 + poisson))
    lam = 2.0 * mu * poisson / (1.0 - 2.0 * poisson)
    shear, mean = np.zeros((18, 18)), np.zeros(9)
    volume = np.zeros((18, 18))
    C = mu * np.diag([2.0, 2.0, 1.0])
    for B, area, functions in _points(FULL, hx, hy):
        shear += area * B.T @ C @ B
        mean += area * functions
    for B, area, _ in _points(REDUCED, hx, hy):
        trace = B[0] + B[1]
        volume += lam * area * np.outer(trace, trace)
    stiffness = shear + volume
    rows = 2 * ny + 1
    nodes = (2 * nx + 1) * rows
    K, average, force = np.zeros((2 * nodes, 2 * nodes)), np.zeros(2 * nodes), np.zeros(2 * nodes)
    for i in range(nx):
        for j in range(ny):
            node = [(2 * i + p) * rows + 2 * j + q for p in range(3) for q in range(3)]
            at = np.array([2 * n + d for n in node for d in range(2)])
            K[np.ix_(at, at)] += stiffness
            average[at[1::2]] += mean
            if i == nx - 1:
                force[at[[13, 15, 17]]] += traction * hy * np.array([1.0, 4.0, 1.0]) / 6.0
    u = np.zeros(2 * nodes)
    free = np.arange(2 * rows, 2 * nodes)
    u[free] = np.linalg.solve(K[np.ix_(free, free)], force[free])
    return float(average @ u) / (length * height)
