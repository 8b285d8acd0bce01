"""Weights and gradients of every shape, as the kernels get them, against (19), (20), (23)."""

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from kernel_driver import SEED, entry, make_frame

from pgimp.kernels.jit import kernel
from pgimp.kernels.transfer import first_vertex, support
from pgimp.shapes import SHAPES
from pgimp.solver.particles import Window

ORIGIN, CELL, CELLS = (-1.1, 0.3, 2.0), (0.7, 1.3, 0.25), (5, 4, 3)

CASES = [
    pytest.param(name, per_cell, id=f"{name}-{'x'.join(map(str, per_cell))}")
    for name in SHAPES
    for per_cell in ((1,), (2,), (3,), (4,), (2, 2), (3, 1), (2, 2, 2), (1, 3, 4))
]

NODES, NODE_WEIGHTS = np.polynomial.legendre.leggauss(3)


@kernel
def collect(shape, frame, window, x, lowest, place, weight, slope, stride):
    """What `support` says of every particle, its layer as the solver finds it."""
    for p in range(len(x)):
        layer = first_vertex(shape, frame, 0, x[p, 0])
        place[p], W = support(shape, frame, window, x, p, layer)
        for d in range(len(W)):
            lowest[p, d] = first_vertex(shape, frame, d, x[p, d])
            stride[p, d] = W[d][2]
            for i in range(len(W[d][0])):
                weight[p, d, i] = W[d][0][i]
                slope[p, d, i] = W[d][1][i]


def supports(shape, frame, x):
    """Weights and slopes along each direction over all its vertices: lists of (n, vertices)."""
    n, D = x.shape
    s = shape.vertices
    extent = (*frame.vertices, 1, 1)[:3]
    lower = (0, *range(-1, -D, -1), 0, 0)[:3]  # windows need not begin with the first vertex
    window = Window.over(lower, extent)
    lowest, stride = np.zeros((2, n, D), np.int64)
    weight, slope = np.zeros((2, n, D, s))
    at = np.zeros(n, np.int64)
    collect(shape.parameters(), frame, window, x, lowest, at, weight, slope, stride)
    assert (stride == window.stride[:D]).all()
    along = [lowest[:, d] - lower[d] for d in range(1, D)]
    assert (at == sum((a * window.stride[d + 1] for d, a in enumerate(along)), 0)).all()
    full = []
    for values in (weight, slope):
        dense = [np.zeros((n, vertices)) for vertices in frame.vertices]
        for d, i in product(range(D), range(s)):
            dense[d][np.arange(n), lowest[:, d] + i] += values[:, d, i]
        full.append(dense)
    return full


def coordinates(frame):
    """Of the vertices along each direction."""
    return [
        o + (np.arange(n) - frame.ghost) * L
        for o, n, L in zip(frame.origin, frame.vertices, frame.cell, strict=True)
    ]


def special(rng, frame, per_cell, n=400):
    """Positions (n, D) in the domain: random, vertices, lattice, box ends on vertices, faces."""
    columns = []
    for origin, L, cells, ppc in zip(frame.origin, frame.cell, frame.cells, per_cell, strict=True):
        vertices = np.arange(cells + 1.0)
        half = 0.5 / ppc
        xi = np.concatenate(
            [
                vertices,
                np.nextafter(vertices[1:], 0),
                np.nextafter(vertices[:-1], 1),
                (np.arange(cells * ppc) + 0.5) / ppc,
                vertices[1:] - half,
                vertices[:-1] + half,
                [1e-14, 1e-6, cells - 1e-6],
                rng.uniform(0, cells, 40),
                rng.uniform(0, half, 10),
                cells - rng.uniform(0, half, 10),
            ]
        )
        columns.append(origin + L * np.clip(rng.choice(xi, n), 0, cells))
    return np.stack(columns, axis=1)


def setting(name, per_cell):
    D = len(per_cell)
    shape = entry(name, per_cell)
    frame = make_frame(shape, ORIGIN[:D], CELL[:D], CELLS[:D])
    return shape, frame, special(np.random.default_rng(SEED), frame, per_cell)


def products(weight, slope):
    """S_vp (n, vertices...) and grad S_vp (n, vertices..., D) from those along each direction."""
    D = len(weight)
    along = "abc"[:D]
    spell = ",".join(f"n{a}" for a in along) + f"->n{along}"
    S = np.einsum(spell, *weight)
    grad = [np.einsum(spell, *(slope[d] if d == i else weight[d] for d in range(D)))
            for i in range(D)]  # fmt: skip
    return S, np.stack(grad, axis=-1)


@pytest.mark.parametrize(("name", "per_cell"), CASES)
def test_partition_of_unity(name, per_cell):
    """(23), and what follows from it: gradients that sum to zero."""
    shape, frame, x = setting(name, per_cell)
    S, grad = products(*supports(shape, frame, x))
    over = tuple(range(1, S.ndim))
    assert np.abs(S.sum(axis=over) - 1).max() < 1e-14
    assert np.abs(grad.sum(axis=over) * frame.cell).max() < 1e-14
    assert S.min() > -1e-15


@pytest.mark.parametrize(("name", "per_cell"), CASES)
def test_linear_completeness(name, per_cell):
    """A field that is linear on the grid has the particle's value and its gradient."""
    shape, frame, x = setting(name, per_cell)
    S, grad = products(*supports(shape, frame, x))
    for d, xv in enumerate(coordinates(frame)):
        xv = xv.reshape([-1 if i == d else 1 for i in range(x.shape[1])])
        over = tuple(range(1, S.ndim))
        assert np.abs((S * xv).sum(axis=over) - x[:, d]).max() < 2e-14
        gradient = (grad * xv[..., None]).sum(axis=over)
        assert np.abs(gradient - np.eye(x.shape[1])[d]).max() < 1e-12


def tent(r):
    """S_v of (35), r = (x - x_v)/L."""
    return np.maximum(1 - np.abs(r), 0)


def tent_slope(r):
    """L dS_v/dx, to the right where it jumps."""
    return np.where((r >= -1) & (r < 0), 1.0, 0.0) - np.where((r >= 0) & (r < 1), 1.0, 0.0)


def point(x, xv, L, ppc):
    """(19) and (20) for chi_p = V_p delta(x - x_p)."""
    r = (x[:, None] - xv) / L
    return tent(r), tent_slope(r) / L


def box(x, xv, L, ppc):
    """(19) and (20) for chi_p = 1 within L/(2 ppc) of x_p: Gauss-Legendre between the kinks."""
    half = 0.5 * L / ppc
    a, b = (x - half)[:, None, None], (x + half)[:, None, None]
    kinks = xv[None, :, None] + L * np.array([-1.0, 0.0, 1.0])
    kinks = np.clip(kinks, a, b)
    ends = np.concatenate([a + 0 * kinks[..., :1], kinks, b + 0 * kinks[..., :1]], axis=-1)
    middle, reach = (ends[..., 1:] + ends[..., :-1]) / 2, (ends[..., 1:] - ends[..., :-1]) / 2
    nodes = middle[..., None] + reach[..., None] * NODES
    r = (nodes - xv[None, :, None, None]) / L
    chi = reach[..., None] * NODE_WEIGHTS / (2 * half)
    return (chi * tent(r)).sum(axis=(2, 3)), (chi * tent_slope(r) / L).sum(axis=(2, 3))


#: Integrals along one direction over chi_p; S_v and chi_p are products of the directions'.
QUADRATURE: dict[str, Callable] = {"mpm": point, "gimp": box}


@pytest.mark.parametrize(("name", "per_cell"), CASES)
def test_quadrature(name, per_cell):
    """Weights and gradients are the integrals (19) and (20)."""
    shape, frame, x = setting(name, per_cell)
    if name == "mpm":  # which side of a vertex a point is on must not hang on rounding here
        xi = (x - frame.origin) / frame.cell
        x = x[(np.abs(xi - np.rint(xi)) > 1e-13).all(axis=1)]
        assert len(x) > 30
    weight, slope = supports(shape, frame, x)
    for d, xv in enumerate(coordinates(frame)):
        L = frame.cell[d]
        expected, expected_slope = QUADRATURE[name](x[:, d], xv, L, per_cell[d])
        assert np.abs(weight[d] - expected).max() < 4e-14
        assert np.abs(slope[d] - expected_slope).max() * L < 4e-14 * per_cell[d]


def test_point_on_a_vertex():
    """A material point on a vertex gives all to it; its gradient is that of the cell above."""
    shape = entry("mpm", (1,))
    frame = make_frame(shape, (0.0,), (0.5,), (8,))
    weight, slope = supports(shape, frame, np.arange(9.0)[:, None] * 0.5)
    ghost = frame.ghost
    # The other vertex gets next to nothing, but something: it must have a velocity.
    at = weight[0][:, ghost : ghost + 10]
    assert (at == np.eye(9, 10) + 1e-60 * np.eye(9, 10, 1)).all()
    assert (slope[0][:, ghost : ghost + 10] == 2 * (np.eye(9, 10, 1) - np.eye(9, 10))).all()


@pytest.mark.parametrize(("name", "per_cell"), CASES)
def test_gradient_is_the_derivative_of_the_weight(name, per_cell):
    """Central differences in each direction, the first vertex found anew at each position."""
    shape, frame, x = setting(name, per_cell)
    xi = (x - frame.origin) / frame.cell
    h = 1e-6
    inside = (xi > 2 * h).all(axis=1) & (xi < np.array(frame.cells) - 2 * h).all(axis=1)
    if name == "mpm":  # the weight has kinks
        inside &= (np.abs(xi - np.rint(xi)) > 2 * h).all(axis=1)
    x = x[inside]
    assert len(x) > 30
    _, grad = products(*supports(shape, frame, x))
    for d, L in enumerate(frame.cell):
        step = np.eye(x.shape[1])[d] * h * L
        above, below = (products(*supports(shape, frame, x + s * step))[0] for s in (1, -1))
        difference = (above - below) / (2 * h * L)
        # Between kinks the weights are quadratic; across one the second derivative jumps.
        assert np.abs(difference - grad[..., d]).max() * L < 2 * h * per_cell[d] + 1e-9


@pytest.mark.parametrize("name", SHAPES)
def test_support_is_no_larger_than_need_be(name):
    """Somewhere every one of the support's vertices has weight: storage and speed depend on it."""
    shape, frame, x = setting(name, (2,))
    weight, _ = supports(shape, frame, x)
    assert (weight[0] > 1e-9).sum(axis=1).max() == shape.vertices
    assert QUADRATURE.keys() == SHAPES.keys()
