"""Rings of an axisymmetric scene: weights by quadrature, the sums of a step, and what they keep."""

from itertools import pairwise

import numpy as np
import pytest
from kernel_driver import SEED, Rank, entry, initial_half
from tiers import wide

from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import AxialFrame
from pgimp.kernels.data.particles import Particles

pytestmark = pytest.mark.slow(60)

KINDS = ("mpm", "gimp", "finite-gimp", "cpdi")
CELL, CELLS, PER_CELL = (0.7, 1.3), (5, 4), (2, 1)
COUNT, DT = 40, 0.002
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def tent(x, vertices):
    """Tents of the vertices, in cells, at x, (vertices,)."""
    return np.maximum(1.0 - np.abs(x - vertices), 0.0)


def radial(kind, r, half, vertices):
    """S, dS/dr and T of a ring about the radius r, all in cells, by quadrature with weight r.

    A point has the tents' values; ends have the line between their values.
    """
    if kind == "mpm":
        slope = np.sign(vertices - r) * (np.abs(r - vertices) < 1.0)
        return tent(r, vertices), slope, tent(r, vertices) / r
    low, high = r - half, r + half
    inner = np.arange(np.floor(low) + 1, high) if kind != "cpdi" else []
    knots = np.array([low, *inner, high])
    S, G, T = np.zeros((3, len(vertices)))
    for a, b in pairwise(knots):
        x = 0.5 * (a + b) + 0.5 * (b - a) * NODES
        weight = 0.5 * (b - a) * WEIGHTS
        ends = tent(a, vertices), tent(b, vertices)
        for xi, w in zip(x, weight, strict=True):
            N = ends[0] + (ends[1] - ends[0]) * (xi - a) / (b - a)
            S += w * xi * N
            G += w * xi * (ends[1] - ends[0]) / (b - a)
            T += w * N
    whole = 0.5 * (high**2 - low**2)
    return S / whole, G / whole, T / whole


def axial(kind, y, half, vertices):
    """S and dS/dy along the axis, in cells: rings have the weight 1 there."""
    if kind == "mpm":
        return tent(y, vertices), np.sign(vertices - y) * (np.abs(y - vertices) < 1.0)
    ends = tent(y - half, vertices), tent(y + half, vertices)
    slope = (ends[1] - ends[0]) / (2 * half)
    if kind == "cpdi":
        return 0.5 * (ends[0] + ends[1]), slope
    knots = np.array([y - half, *np.arange(np.floor(y - half) + 1, y + half), y + half])
    S = np.zeros(len(vertices))
    for a, b in pairwise(knots):
        S += 0.5 * (b - a) * (tent(a, vertices) + tent(b, vertices))
    return S / (2 * half), slope


class Rings:
    """A rank with random rings, some at the axis, and their weights."""

    def __init__(self, kind, mean=False):
        rng = np.random.default_rng(SEED)
        shape = entry(kind, PER_CELL)
        frame = AxialFrame(
            (0.0, 0.3), CELL, tuple(1.0 / h for h in CELL), CELLS, shape.vertices - 1
        )
        p = Particles.empty(COUNT, Carried(2, axial=True, mean=mean))
        p.x[:] = rng.uniform(0.05, 0.95, (COUNT, 2)) * np.array(CELLS) * CELL + (0.0, 0.3)
        p.x[:4, 0] = CELL[0] * np.array([2e-3, 0.02, 0.1, 0.2])  # boxes reach the axis
        p.v[:] = rng.normal(size=p.v.shape)
        p.F[:] += 0.2 * rng.uniform(-1.0, 1.0, p.F.shape)
        p.sigma[:] = rng.normal(size=p.sigma.shape)
        p.V0[:] = rng.uniform(0.5, 1.5, COUNT)
        p.V[:] = p.V0 * rng.uniform(0.8, 1.2, COUNT)
        p.m[:] = rng.uniform(0.5, 2.0, COUNT)
        p.id[:] = rng.permutation(COUNT)
        p.isolation[:] = rng.uniform(0.0, 1.0, p.isolation.shape)
        self.rank, self.frame, self.kind = Rank(shape, frame, p), frame, kind
        self.p = p = Particles(*(a[self.rank.population.order].copy() for a in p))
        self.r = np.arange(frame.vertices[0]) - frame.ghost
        self.z = np.arange(frame.vertices[1]) - frame.ghost
        n, m = len(self.r), len(self.z)
        self.S, self.R, self.Z, self.T = np.zeros((4, COUNT, n, m))
        self.half = np.zeros((COUNT, 2))
        l0 = np.array([initial_half(kind, k) for k in PER_CELL])
        for k in range(COUNT):
            half = l0.copy()
            if kind in ("finite-gimp", "cpdi"):
                F = p.F[k, :4].reshape(2, 2)
                half = np.minimum(np.sqrt(((F * (l0 * CELL)) ** 2).sum(axis=1)) / CELL, 1.0)
            x = (p.x[k] - frame.origin) / CELL
            half[0] = min(half[0], x[0])
            self.half[k] = half
            S, G, T = radial(kind, x[0], half[0], self.r)
            A, B = axial(kind, x[1], half[1], self.z)
            self.S[k], self.R[k] = np.outer(S, A), np.outer(G, A) / CELL[0]
            self.Z[k], self.T[k] = np.outer(S, B) / CELL[1], np.outer(T, A) / CELL[0]

    def forces(self):
        """Forces (16) of the stresses, with the hoop's, (vertices, vertices, 2)."""
        V, (xx, yy, zz, xy) = self.p.V, self.p.sigma.T
        radial = np.einsum("p,pij", V * xx, self.R) + np.einsum("p,pij", V * xy, self.Z)
        radial += np.einsum("p,pij", V * zz, self.T)
        along = np.einsum("p,pij", V * xy, self.R) + np.einsum("p,pij", V * yy, self.Z)
        return -np.stack([radial, along], axis=-1)

    def gradients(self, v):
        """Velocity gradients of the rings in a field v of the vertices, (n, 5)."""
        pairs = ((self.R, 0), (self.Z, 0), (self.R, 1), (self.Z, 1), (self.T, 0))
        return np.stack([np.einsum("pij,ij", w, v[..., c]) for w, c in pairs], axis=1)


@pytest.mark.parametrize("kind", [wide("mpm"), *KINDS[1:]])
def test_sums_of_rings(kind):
    """Mass, momentum, forces and motion of a step equal sums with weights by quadrature."""
    rings = Rings(kind)
    p, rank = rings.p, rings.rank
    rank.particles_to_grid()
    G = rank.records()
    mass = np.einsum("p,pij", p.m, rings.S)
    momentum = np.einsum("pc,pij->ijc", p.m[:, None] * p.v, rings.S)
    force = rings.forces()
    for found, expected in ((G[..., 0], mass), (G[..., 1:3], momentum), (G[..., 5:7], force)):
        assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()
    # Nothing is lost: mass, and momentum along the axis.
    assert G[..., 0].sum() == pytest.approx(p.m.sum(), rel=1e-14)
    assert abs(force[..., 1].sum()) <= 1e-13 * np.abs(force[..., 1]).sum()

    rank.update_momentum(DT)
    G = rank.records()
    v, a = G[..., 1:3].copy(), G[..., 5:7].copy()
    # The power of the forces is the power of the stresses, for any motion.
    xx, yy, zz, xy = p.sigma.T
    L = rings.gradients(v)
    power = p.V @ (xx * L[:, 0] + xy * (L[:, 1] + L[:, 2]) + yy * L[:, 3] + zz * L[:, 4])
    assert (force * v).sum() == pytest.approx(-power, rel=1e-11)

    rank.grid_to_particles(DT)
    q = rank.up_to_date()
    rows = np.argsort(q.id[rank.population.order])
    after = Particles(*(a[rank.population.order][rows] for a in q))
    rows = np.argsort(p.id)
    expected = p.v + DT * np.einsum("pij,ijc->pc", rings.S, a)
    assert np.abs(after.v - expected[rows]).max() <= 1e-11 * np.abs(expected).max()
    one = np.eye(2)
    grown = (one + DT * L[:, :4].reshape(-1, 2, 2)) @ p.F[:, :4].reshape(-1, 2, 2)
    F = np.column_stack([grown.reshape(-1, 4), (1 + DT * L[:, 4]) * p.F[:, 4]])
    assert np.abs(after.F - F[rows]).max() <= 1e-11
    # The radius grows as the hoop stretches; along the axis boxes move with their middle.
    radius = p.x[:, 0] * (1.0 + DT * L[:, 4])
    assert np.abs(after.x[:, 0] - radius[rows]).max() <= 1e-13
    middle = p.x[:, 1] + DT * p.x[:, 0] * np.einsum("pij,ij", rings.T, v[..., 1])
    assert np.abs(after.x[:, 1] - middle[rows]).max() <= 1e-12


def rates_of_cells(rings, v):
    """Mean rates of dilatation of the cells, with weight r, in a multilinear field v."""
    r, rate = rings.r * CELL[0], np.zeros((len(rings.r) - 1, len(rings.z) - 1))
    for i in range(len(rings.r) - 1):
        middle = 0.5 * (r[i] + r[i + 1])
        for j in range(len(rings.z) - 1):
            out = 0.5 * (v[i + 1, j, 0] + v[i + 1, j + 1, 0]) * r[i + 1]
            out -= 0.5 * (v[i, j, 0] + v[i, j + 1, 0]) * r[i]
            rate[i, j] = out / (middle * CELL[0]) if middle > 0 else 0.0
            for x, w in zip(NODES, WEIGHTS, strict=True):  # the mean of r dv_y/dy over the radius
                s = 0.5 * (1 + x)
                rise = [v[k, j + 1, 1] - v[k, j, 1] for k in (i, i + 1)]
                slope = (rise[0] * (1 - s) + rise[1] * s) / CELL[1]
                rate[i, j] += 0.5 * w * slope * (r[i] + s * CELL[0]) / middle if middle > 0 else 0.0
    return rate


def parts_in_cells(low, high, vertices, weighted):
    """Parts of an interval in the cells between vertices, by length or by r dr."""
    a, b = np.maximum(low, vertices[:-1]), np.minimum(high, vertices[1:])
    part = np.maximum(b - a, 0.0) * (0.5 * (a + b) if weighted else 1.0)
    return part / part.sum()


@pytest.mark.parametrize("kind", ["gimp", "finite-gimp"])
def test_mean_dilatation_of_rings(kind):
    """Rates are those of the cells, by parts with weight r; forces have the stresses' power."""
    rings = Rings(kind, mean=True)
    p, rank = rings.p, rings.rank
    rank.mean = 1.0
    rank.particles_to_grid()
    force = rank.records()[..., 5:7].copy()
    rank.update_momentum(DT)
    v = rank.records()[..., 1:3].copy()
    cells, L = rates_of_cells(rings, v), rings.gradients(v)
    for k in range(COUNT):
        x, half = (p.x[k] - rings.frame.origin) / CELL, rings.half[k]
        across = parts_in_cells(x[0] - half[0], x[0] + half[0], rings.r, True)
        along = parts_in_cells(x[1] - half[1], x[1] + half[1], rings.z, False)
        e = (across @ cells @ along - L[k, [0, 3, 4]].sum()) / 3.0
        L[k, [0, 3, 4]] += (1.0 - p.isolation[k, 0]) * e
    xx, yy, zz, xy = p.sigma.T
    power = p.V @ (xx * L[:, 0] + xy * (L[:, 1] + L[:, 2]) + yy * L[:, 3] + zz * L[:, 4])
    assert (force * v).sum() == pytest.approx(-power, rel=1e-10)
    assert abs(force[..., 1].sum()) <= 1e-12 * np.abs(force[..., 1]).sum()
    rank.grid_to_particles(DT)
    order = rank.population.order
    hoop = rank.up_to_date().F[order][np.argsort(rank.up_to_date().id[order]), 4]
    assert np.abs(hoop - (p.F[:, 4] * (1 + DT * L[:, 4]))[np.argsort(p.id)]).max() <= 1e-11


@pytest.mark.parametrize("kind", [wide("mpm"), *KINDS[1:]])
def test_fields_linear_in_space(kind):
    """Weights have the sums that a uniform stretch needs, up to the axis."""
    rings = Rings(kind)
    r, z = rings.r * CELL[0], rings.z * CELL[1] + 0.3
    x = rings.p.x
    grid = np.meshgrid(r, z, indexing="ij")
    total = lambda w, v=1.0: (w * v).sum(axis=(1, 2))  # noqa: E731
    assert total(rings.S) == pytest.approx(1.0, abs=1e-12)
    scale = 1.0 / (x[:, 0] + 1e-3)
    assert np.abs(total(rings.R) / scale).max() < 1e-12
    assert total(rings.T) * x[:, 0] == pytest.approx(1.0, abs=1e-12)
    assert total(rings.R, grid[0]) == pytest.approx(1.0, abs=1e-9)
    assert total(rings.T, grid[0]) == pytest.approx(1.0, abs=1e-9)
    half = rings.half[:, 0] * CELL[0]  # 0 of a point
    assert total(rings.S, grid[0]) == pytest.approx(x[:, 0] + half**2 / (3 * x[:, 0]), abs=1e-12)
