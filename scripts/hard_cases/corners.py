"""Is a sum of corners worth it? Weights by the corners of a deformed box against those of boxes.

A prototype, apart from pgimp's kernels, in 2D, update stress last, one neo-Hookean body:

- ``box``: weights of ``finite-gimp``, the mean of the tent over a box along the grid's directions;
- ``ends``: those of ``cpdi``, products of the means over the ends of that box;
- ``corners``: those of convected particle domains in full (Sadeghirad, Brannon and Burghardt
  2011), the mean of the grid's functions over the four corners of the parallelogram that the
  particle's square has become, with the mean gradient of what is bilinear between them.

Run as ``python scripts/hard_cases/corners.py``: errors of the generalised vortex and of a block
that spins, and the time of a step by each, which the table of docs/methods.md quotes.
"""

from math import pi, sqrt
from time import process_time

import numpy as np
from numba import njit

WAYS = ("box", "ends", "corners")

#: Cells across the ring and the square.
CELLS = (8, 16)


@njit(inline="always")
def tent(x):
    """Of a vertex, `x` cells from it."""
    return max(1.0 - abs(x), 0.0)


@njit(inline="always")
def integral(x):
    """Of the tent from minus infinity to x."""
    if x <= 0.0:
        return 0.5 * max(1.0 + x, 0.0) ** 2
    return 1.0 - 0.5 * max(1.0 - x, 0.0) ** 2


@njit
def along(way, x, half, w, g):
    """Weights and gradients of four vertices along one direction; the first one's number."""
    first = int(np.floor(x - half))
    for i in range(4):
        low, high = x - half - (first + i), x + half - (first + i)
        w[i] = (0.5 * (tent(low) + tent(high)) if way == 1
                else (integral(high) - integral(low)) / (2.0 * half))  # fmt: skip
        g[i] = (tent(high) - tent(low)) / (2.0 * half)
    return first


@njit
def support(way, x, F, half, places, S, dS):
    """Fill in the vertices of a particle, weights and gradients; how many there are."""
    n = 0
    if way < 2:
        w, g = np.empty((2, 4)), np.empty((2, 4))
        first = np.empty(2, np.int64)
        for d in range(2):
            wide = min(half * sqrt(F[d, 0] ** 2 + F[d, 1] ** 2), 1.0)
            first[d] = along(way, x[d], wide, w[d], g[d])
        for i in range(4):
            for j in range(4):
                if w[0, i] > 0.0 and w[1, j] > 0.0:
                    places[n, 0], places[n, 1] = first[0] + i, first[1] + j
                    S[n] = w[0, i] * w[1, j]
                    dS[n, 0], dS[n, 1] = g[0, i] * w[1, j], w[0, i] * g[1, j]
                    n += 1
        return n
    a0, a1, b0, b1 = half * F[0, 0], half * F[1, 0], half * F[0, 1], half * F[1, 1]
    area = a0 * b1 - a1 * b0
    for corner in range(4):
        s, t = (1.0 if corner in (1, 2) else -1.0), (1.0 if corner > 1 else -1.0)
        cx, cy = x[0] + s * a0 + t * b0, x[1] + s * a1 + t * b1
        # Gradient of what is bilinear between the corners, in the middle, by its columns' inverse.
        gx, gy = 0.25 * (s * b1 - t * a1) / area, 0.25 * (t * a0 - s * b0) / area
        i0, j0 = int(np.floor(cx)), int(np.floor(cy))
        for i in range(2):
            for j in range(2):
                N = tent(cx - i0 - i) * tent(cy - j0 - j)
                places[n, 0], places[n, 1] = i0 + i, j0 + j
                S[n], dS[n, 0], dS[n, 1] = 0.25 * N, gx * N, gy * N
                n += 1
    return n


@njit
def step(way, affine, x, v, F, L, m, V0, b, half, dt, lam, mu, M, P, Q, least):
    """One step; lengths in cells."""
    places, S, dS = np.empty((16, 2), np.int64), np.empty(16), np.empty((16, 2))
    M[:], P[:], Q[:] = 0.0, 0.0, 0.0
    for p in range(len(x)):
        n = support(way, x[p], F[p], half, places, S, dS)
        f = F[p]
        J = f[0, 0] * f[1, 1] - f[0, 1] * f[1, 0]
        ln = lam * np.log(J)
        t00 = mu * (f[0, 0] ** 2 + f[0, 1] ** 2 - 1.0) + ln
        t11 = mu * (f[1, 0] ** 2 + f[1, 1] ** 2 - 1.0) + ln
        t01 = mu * (f[0, 0] * f[1, 0] + f[0, 1] * f[1, 1])
        for k in range(n):
            i, j = places[k]
            w = m[p] * S[k]
            r0, r1 = i - x[p, 0], j - x[p, 1]
            M[i, j] += w
            P[i, j, 0] += w * (v[p, 0] + affine * (L[p, 0, 0] * r0 + L[p, 0, 1] * r1))
            P[i, j, 1] += w * (v[p, 1] + affine * (L[p, 1, 0] * r0 + L[p, 1, 1] * r1))
            Q[i, j, 0] += w * b[p, 0] - V0[p] * (t00 * dS[k, 0] + t01 * dS[k, 1])
            Q[i, j, 1] += w * b[p, 1] - V0[p] * (t01 * dS[k, 0] + t11 * dS[k, 1])
    for i in range(M.shape[0]):
        for j in range(M.shape[1]):
            if M[i, j] > least:
                for d in range(2):
                    Q[i, j, d] /= M[i, j]
                    P[i, j, d] = P[i, j, d] / M[i, j] + dt * Q[i, j, d]
            else:
                P[i, j], Q[i, j] = 0.0, 0.0
    for p in range(len(x)):
        n = support(way, x[p], F[p], half, places, S, dS)
        u0 = u1 = c0 = c1 = l00 = l01 = l10 = l11 = 0.0
        for k in range(n):
            i, j = places[k]
            u0 += S[k] * P[i, j, 0]
            u1 += S[k] * P[i, j, 1]
            c0 += S[k] * Q[i, j, 0]
            c1 += S[k] * Q[i, j, 1]
            l00 += P[i, j, 0] * dS[k, 0]
            l01 += P[i, j, 0] * dS[k, 1]
            l10 += P[i, j, 1] * dS[k, 0]
            l11 += P[i, j, 1] * dS[k, 1]
        x[p, 0] += dt * u0
        x[p, 1] += dt * u1
        v[p, 0] += dt * c0
        v[p, 1] += dt * c1
        L[p, 0, 0], L[p, 0, 1], L[p, 1, 0], L[p, 1, 1] = l00, l01, l10, l11
        a, c = F[p, 0, 0] + dt * (l00 * F[p, 0, 0] + l01 * F[p, 1, 0]), F[p, 1, 0]
        e, g = F[p, 0, 1] + dt * (l00 * F[p, 0, 1] + l01 * F[p, 1, 1]), F[p, 1, 1]
        F[p, 1, 0] = c + dt * (l10 * F[p, 0, 0] + l11 * c)
        F[p, 1, 1] = g + dt * (l10 * F[p, 0, 1] + l11 * g)
        F[p, 0, 0], F[p, 0, 1] = a, e
        within = 3.0 < x[p, 0] < M.shape[0] - 4.0 and 3.0 < x[p, 1] < M.shape[1] - 4.0
        if not (within and F[p, 0, 0] * F[p, 1, 1] - F[p, 0, 1] * F[p, 1, 0] > 0.0):
            return False
    return True


class Body:
    """Particles of a region on a lattice, two a cell and direction, in cells of size 1."""

    def __init__(self, inside, size, per_cell=2, young=1.0, poisson=0.3, density=1.0):
        self.half = 0.5 / per_cell
        c = (np.arange(size * per_cell) + 0.5) / per_cell
        x = np.stack(np.meshgrid(c, c, indexing="ij"), axis=-1).reshape(-1, 2)
        fine = (np.arange(8) + 0.5) / 8.0 - 0.5
        parts = np.stack(np.meshgrid(fine, fine, indexing="ij"), axis=-1).reshape(-1, 2) / per_cell
        share = np.array([inside(x + part) for part in parts]).mean(axis=0)
        x, share = x[share > 1e-3], share[share > 1e-3]
        self.X, self.x, self.v = x.copy(), x, np.zeros_like(x)
        self.V0 = share / per_cell**2
        self.m = density * self.V0
        self.F, self.L = np.tile(np.eye(2), (len(x), 1, 1)), np.zeros((len(x), 2, 2))
        self.lam = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
        self.mu = 0.5 * young / (1.0 + poisson)
        self.speed = sqrt((self.lam + 2.0 * self.mu) / density)
        self.grid = np.zeros((size + 1, size + 1))
        self.vectors = np.zeros((2, size + 1, size + 1, 2))

    def advance(self, way, affine, dt, b):
        """One step; whether no particle is inside out."""
        return step(
            WAYS.index(way), float(affine), self.x, self.v, self.F, self.L, self.m, self.V0, b,
            self.half, dt, self.lam, self.mu, self.grid, *self.vectors, 1e-12 * self.m.min(),
        )  # fmt: skip


def vortex(way, affine, cells, amplitude, courant=0.2):
    """Error of displacement and of stress of the generalised vortex at a quarter of its period.

    Parameters
    ----------
    cells : int
        Across the ring, whose mean radius is twice its width.
    amplitude : float
        Greatest angle, radians.

    Returns
    -------
    (float, float)
        Mean square of the displacement's error over the greatest displacement; mean difference of
        J from 1, which it keeps.
    """
    # Lengths in cells; the wave takes a third of a quarter period to cross the ring.
    width, size = float(cells), 6 * cells
    mean, centre = 2.0 * width, 0.5 * size
    body = Body(lambda x: np.abs(np.hypot(*(x - centre).T) - mean) < 0.5 * width, size)
    w = 2.0 * pi * body.speed / (12.0 * width)
    R = np.hypot(*(body.X - centre).T)
    s = np.clip((R - mean) / width, -0.5, 0.5)
    q = 1.0 - 4.0 * s * s
    h, slope, bend = q * q, -16.0 * s * q / width, 16.0 * (12.0 * s * s - 1.0) / width**2
    across = (body.X - centre)[:, ::-1] * [-1.0, 1.0]
    body.v[:] = (amplitude * w * h)[:, None] * across
    if affine:
        c = (body.X - centre) / R[:, None]
        turn = np.stack([-c[:, 1], c[:, 0]], 1)
        sheared = (R * slope)[:, None, None] * turn[:, :, None] * c[:, None, :]
        body.L[:] = amplitude * w * (h[:, None, None] * [[0.0, -1.0], [1.0, 0.0]] + sheared)
    steps = round(0.5 * pi / w / (courant / body.speed))
    dt = 0.5 * pi / w / steps
    for n in range(steps):
        g = amplitude * np.sin(w * n * dt)
        angle, rate = g * h, amplitude * w * np.cos(w * n * dt) * h
        C, S = np.cos(angle), np.sin(angle)
        X = body.X - centre
        c = np.stack([C * X[:, 0] - S * X[:, 1], S * X[:, 0] + C * X[:, 1]], 1) / R[:, None]
        radial = R * (body.mu * g * g * slope**2 - rate**2)
        hoop = -R * w * w * angle - body.mu * g * (R * bend + 3.0 * slope)
        b = radial[:, None] * c + hoop[:, None] * np.stack([-c[:, 1], c[:, 0]], 1)
        if not body.advance(way, affine, dt, b):
            return np.inf, np.inf
    angle = amplitude * h
    C, S = np.cos(angle), np.sin(angle)
    X = body.X - centre
    exact = np.stack([C * X[:, 0] - S * X[:, 1], S * X[:, 0] + C * X[:, 1]], 1)
    far = ((body.x - centre - exact) ** 2).sum(axis=1)
    error = sqrt((body.V0 * far).sum() / body.V0.sum()) / (amplitude * mean)
    return error, float(np.average(np.abs(np.linalg.det(body.F) - 1.0), weights=body.V0))


def spin(way, affine, cells=8, turns=1.0, courant=0.3, edge_speed=0.1):
    """Part of a square's spin that is lost, and how far it is from the turned square, in cells."""
    size = 2 * cells + 10
    centre = 0.5 * size
    body = Body(lambda x: np.abs(x - centre).max(axis=1) < 0.5 * cells, size)
    rate = edge_speed * body.speed / (0.5 * cells)
    r = body.x - centre
    body.v[:] = rate * np.stack([-r[:, 1], r[:, 0]], 1)
    body.L[:] = rate * np.array([[0.0, -1.0], [1.0, 0.0]])

    def angular():
        (x, y), (u, v) = (body.x - centre).T, body.v.T
        return float((body.m * (x * v - y * u)).sum())

    first, none = angular(), np.zeros_like(body.x)
    dt = courant / body.speed
    for _ in range(round(2.0 * pi * turns / rate / dt)):
        if not body.advance(way, affine, dt, none):
            return np.inf, np.inf
    a, z = ((x - x.mean(axis=0)) @ np.array([1.0, 1.0j]) for x in (body.X, body.x))
    turned = np.vdot(a, z)
    return 1.0 - angular() / first, float(np.sqrt((np.abs(z - a * turned / abs(turned))**2).mean()))


def cost(way, rounds=5, steps=10):
    """CPU seconds of a particle-step of a sheared body: the least of rounds."""
    body = Body(lambda x: np.abs(x - 32.0).max(axis=1) < 24.0, 64)
    body.F[:, 0, 1], none, least = 0.3, np.zeros_like(body.x), np.inf
    body.advance(way, False, 1e-6, none)
    for _ in range(rounds):
        began = process_time()
        for _ in range(steps):
            body.advance(way, False, 1e-6, none)
        least = min(least, (process_time() - began) / steps / len(body.x))
    return least


def main():
    """Print the errors and costs."""
    for way in WAYS:
        print(f"{way}: {1e9 * cost(way):.0f} ns a particle-step")
    for affine in (False, True):
        for amplitude in (0.15, 0.5, 1.0):
            for cells in (*CELLS, 32) if amplitude < 0.2 else CELLS:
                found = [vortex(way, affine, cells, amplitude) for way in WAYS]
                texts = (f"{way} {e:.2e} (J {j:.1e})"
                         for way, (e, j) in zip(WAYS, found, strict=True))  # fmt: skip
                print(f"vortex, affine {affine}, amplitude {amplitude}, {cells} cells: "
                      + ", ".join(texts), flush=True)  # fmt: skip
        for cells in CELLS:
            found = [spin(way, affine, cells) for way in WAYS]
            texts = (f"{way} {e:.2e} (shape {s:.1e})"
                     for way, (e, s) in zip(WAYS, found, strict=True))  # fmt: skip
            print(f"spin, affine {affine}, {cells} cells: " + ", ".join(texts), flush=True)


if __name__ == "__main__":
    main()
