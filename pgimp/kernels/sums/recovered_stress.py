"""Stress of linear functions that fit the particles near a point, best by least squares.

A particle counts by its initial volume times a tent about the point, a cell wide on either side. So
a linear stress is found as it is, at surfaces too.
"""

from math import nan

from pgimp.jit.kernel import kernel

#: Weight of the slopes' squares beside those of the deviations, in cells^2: none is found along a
#: direction in which particles hardly differ.
_SLOPES = 1e-4


@kernel
def fit_stresses(points, first, near, x, volumes, sigma, work, found):
    """Find stresses at points, which come cell by cell.

    Parameters
    ----------
    points : (n, D) float64
        In cells, as `x`.
    first : (cells + 1,) int64
        Beginning of each cell's points.
    near : (cells, k, 2) int64
        First and end of k runs of particles in the cells round it.
    x, volumes : (m, D) float64, (m,) float64
        Places and initial volumes of particles.
    sigma : (m, S) float64
        Their stresses.
    work : (D + 1, D + 1 + S) float64
        Normal equations: of the slopes, then of the value; and their right-hand sides.
    found : (n, S) float64
        Set; nan without any particle.
    """
    D, S = x.shape[1], sigma.shape[1]
    for cell in range(len(first) - 1):
        for n in range(first[cell], first[cell + 1]):
            for i in range(D + 1):
                for j in range(D + 1 + S):
                    work[i, j] = 0.0
            for k in range(near.shape[1]):
                for p in range(near[cell, k, 0], near[cell, k, 1]):
                    w = volumes[p]
                    for i in range(D):
                        w *= max(1.0 - abs(x[p, i] - points[n, i]), 0.0)
                    for i in range(D + 1 if w > 0.0 else 0):
                        a = w * (x[p, i] - points[n, i]) if i < D else w
                        for j in range(D):
                            work[i, j] += a * (x[p, j] - points[n, j])
                        work[i, D] += a
                        for c in range(S):
                            work[i, D + 1 + c] += a * sigma[p, c]
            total = work[D, D]
            for i in range(D):
                work[i, i] += _SLOPES * total
            if not total > 0.0:
                for c in range(S):
                    found[n, c] = nan
                continue
            for i in range(D):
                for j in range(i + 1, D + 1):
                    factor = work[j, i] / work[i, i]
                    for k in range(i + 1, D + 1 + S):
                        work[j, k] -= factor * work[i, k]
            for c in range(S):
                found[n, c] = work[D, D + 1 + c] / work[D, D]
