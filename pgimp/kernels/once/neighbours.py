"""Velocity gradients of unordered particles, from the velocities of their neighbours.

The particles are sorted by cells as large as the reach, numbered along the last direction first,
with an empty cell around all of them. Neighbours of a particle are in runs of three cells, found by
bisection. Every particle is computed by itself, its neighbours in their order.
"""

import numpy as np

from pgimp.jit.kernel import allocating_kernel, kernel

#: Candidates tried for a particle; of more, every second, third, ... one.
MAX_CANDIDATES = 4096

#: Smallest spread of the neighbours in a direction, over the largest, that determines a slope.
FLAT = 1e-4

_SWEEPS = 30


@kernel
def first_not_below(keys, key):
    """Number of ascending keys that are below one."""
    low, high = 0, len(keys)
    while low < high:
        middle = (low + high) // 2
        if keys[middle] < key:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def diagonalise(A, V, D):
    """Diagonalise a symmetric (D, D) matrix by Jacobi's rotations: A = V A' V^T."""
    for i in range(D):
        for j in range(D):
            V[i, j] = 1.0 if i == j else 0.0
    for _ in range(_SWEEPS):
        off = 0.0
        for i in range(D):
            for j in range(i):
                off += A[i, j] * A[i, j]
        if off == 0.0:
            return
        for p in range(D):
            for q in range(p + 1, D):
                if A[p, q] == 0.0:
                    continue
                theta = (A[q, q] - A[p, p]) / (2.0 * A[p, q])
                t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
                t = -t if theta < 0.0 else t
                c = 1.0 / np.sqrt(t * t + 1.0)
                s = t * c
                for k in range(D):
                    a, b = A[k, p], A[k, q]
                    A[k, p], A[k, q] = c * a - s * b, s * a + c * b
                for k in range(D):
                    a, b = A[p, k], A[q, k]
                    A[p, k], A[q, k] = c * a - s * b, s * a + c * b
                for k in range(D):
                    a, b = V[k, p], V[k, q]
                    V[k, p], V[k, q] = c * a - s * b, s * a + c * b
                A[p, q] = A[q, p] = 0.0


@allocating_kernel
def fit_gradients(around, chosen, strides, reach, out):
    """Fit a linear field to the velocities around particles: weighted least squares.

    A neighbour at the distance s, over the reach, has the weight (1 - s^2)^2. Directions in which
    the neighbours do not spread get no slope (the solution of least norm); without any it is zero.

    Parameters
    ----------
    around : ((n, D) float64, (n, D) float64, (n,) int64)
        Positions and velocities of particles, and the numbers of their cells, ascending.
    chosen : ((m, D) float64, (m, D) float64, (m,) int64)
        Likewise for the particles in question, in any order.
    strides : (D,) int64
        Stride of the cell number along each direction; 1 along the last.
    reach : (D,) float64
        Half-axes of the ellipsoid in which others count.
    out : (m, D * D) float64
        dv_i/dx_j, row by row.
    """
    (x, v, keys), (at, speed, own) = around, chosen
    D = x.shape[1]
    runs = 3 ** (D - 1)
    begin, end = np.empty(9, np.int64), np.empty(9, np.int64)
    A, V = np.empty((3, 3)), np.empty((3, 3))
    xx, vx = np.empty((3, 3)), np.empty((3, 3))
    sx, sv, dx, dv = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for p in range(len(at)):
        total = 0
        for run in range(runs):
            key, rest = own[p], run
            for d in range(D - 1):
                key += (rest % 3 - 1) * strides[d]
                rest //= 3
            begin[run] = first_not_below(keys, key - 1)
            end[run] = first_not_below(keys, key + 2)
            total += end[run] - begin[run]
        step = 1 + total // MAX_CANDIDATES
        weight, count = 0.0, 0
        xx[:], vx[:], sx[:], sv[:] = 0.0, 0.0, 0.0, 0.0
        for run in range(runs):
            for q in range(begin[run], end[run]):
                count += 1
                if count % step:
                    continue
                square = 0.0
                for d in range(D):
                    dx[d] = (x[q, d] - at[p, d]) / reach[d]
                    dv[d] = v[q, d] - speed[p, d]
                    square += dx[d] * dx[d]
                if square >= 1.0:
                    continue
                w = (1.0 - square) * (1.0 - square)
                weight += w
                for i in range(D):
                    sx[i] += w * dx[i]
                    sv[i] += w * dv[i]
                    for j in range(D):
                        xx[i, j] += w * dx[i] * dx[j]
                        vx[i, j] += w * dv[i] * dx[j]
        for i in range(D):
            for j in range(D):
                out[p, i * D + j] = 0.0
                if weight > 0.0:
                    A[i, j] = xx[i, j] - sx[i] * sx[j] / weight
                    vx[i, j] -= sv[i] * sx[j] / weight
        if weight == 0.0:
            continue
        diagonalise(A, V, D)
        largest = 0.0
        for k in range(D):
            largest = max(largest, A[k, k])
        for k in range(D):
            # Without a spread, but for rounding, there are no neighbours.
            if A[k, k] <= FLAT * FLAT * largest or largest <= 1e-24:
                continue
            for i in range(D):
                slope = 0.0
                for j in range(D):
                    slope += vx[i, j] * V[j, k]
                for j in range(D):
                    out[p, i * D + j] += slope / A[k, k] * V[j, k] / reach[j]
