"""Weights and gradients of every shape, as the kernels get them, against (19), (20), (23)."""

from itertools import product

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from kernel_driver import KINDS, SEED, VARIANTS, entry, follows, initial_half, make_frame
from quadrature import chi_of, integrals

from pgimp.jit.kernel import kernel
from pgimp.jit.vectors.simd import stack
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import Window
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.transfer import supports as batch
from pgimp.kernels.transfer.first_vertex import first_vertex, half_widths
from pgimp.kernels.transfer.lane_io import four_rows
from pgimp.kernels.transfer.supports import SUPPORT_SIZE
from pgimp.physics.shapes import SHAPES
from pgimp.physics.shapes.base import weights

pytestmark = pytest.mark.slow(195)

ORIGIN, CELL, CELLS = (-1.1, 0.3, 2.0), (0.7, 1.3, 0.25), (5, 4, 3)

CASES = [
    pytest.param(
        name,
        per_cell,
        id=f"{name}-{'x'.join(map(str, per_cell))}",
        marks=[pytest.mark.wide] * (len(per_cell) == 3 and name not in ("mpm", "gimp", "cpdi")),
    )
    for name in VARIANTS
    for per_cell in ((1,), (2,), (4,), (3, 1), (2, 2), (1, 3, 4), (2, 2, 2))
    if name != "cpdi-corners" or len(per_cell) == 1  # else no products: see tests/kernels
]

EPS = np.finfo(float).eps


@kernel
def collect(shape, frame, window, particles, order, lowest, place, weight, slope, extent):
    """What `batch.supports` says of every particle, its layer as the solver finds it."""
    buffer = stack(SUPPORT_SIZE)
    for k in range(len(order)):
        p = order[k]
        half = half_widths(shape, frame, particles, p)
        layer = first_vertex(frame, 0, half[0], particles.x[p, 0])
        rows = four_rows(order, k, k + 1 + p % 4 if k + 4 < len(order) else k + 1)
        batch.supports(shape, frame, window, particles, rows, layer, buffer, ())
        place[p] = batch.first_offset(buffer, 0)
        for d in range(lowest.shape[1]):
            lowest[p, d] = first_vertex(frame, d, half[d], particles.x[p, d])
            extent[p, d] = batch.extent(shape, buffer, d, 0)
            for i in range(weight.shape[2]):
                weight[p, d, i] = batch.entry(buffer, d, 0, i, 0)
                slope[p, d, i] = batch.entry(buffer, d, 1, i, 0)


def supports(shape, frame, x, F):
    """Weights and slopes along each direction over all its vertices: lists of (n, vertices)."""
    n, D = x.shape
    s = shape.vertices
    extent = (*frame.vertices, 1, 1)[:3]
    lower = (0, *range(-1, -D, -1), 0, 0)[:3]  # windows need not begin with the first vertex
    window = Window.over(lower, extent)
    lowest, extents = np.zeros((2, n, D), np.int64)
    weight, slope = np.zeros((2, n, D, s))
    at = np.zeros(n, np.int64)
    particles = Particles.empty(n, Carried(D))
    particles.x[:], particles.F[:] = x, F.reshape(n, -1)
    parameters = shape.parameters(frame.cell)
    order = np.arange(n, dtype=np.int32)
    collect(parameters, frame, window, particles, order, lowest, at, weight, slope, extents)
    # What is left out has neither weight nor gradient, or one that is lost to rounding.
    for i in range(s):
        assert (np.abs(weight[..., i][extents <= i]) == 0.0).all()
        assert (np.abs(slope[..., i][extents <= i]) < 1e-100).all()
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


def special(rng, frame, half, n):
    """Positions (n, D) in the domain: random, vertices, middles, chi's ends on vertices, faces."""
    columns = []
    for origin, L, cells, l0 in zip(frame.origin, frame.cell, frame.cells, half, strict=True):
        vertices = np.arange(cells + 1.0)
        xi = np.concatenate(
            [
                vertices,
                np.nextafter(vertices[1:], 0),
                np.nextafter(vertices[:-1], 1),
                vertices[1:] - 0.5,
                vertices[1:] - l0,
                vertices[:-1] + l0,
                [1e-14, 1e-6, cells - 1e-6],
                rng.uniform(0, cells, 40),
                rng.uniform(0, 0.2, 10),
                cells - rng.uniform(0, 0.2, 10),
            ]
        )
        columns.append(origin + L * np.clip(rng.choice(xi, n), 0, cells))
    return np.stack(columns, axis=1)


def half_of(name, per_cell, F):
    """Half-widths, (n, D) in cells: of the deformed box's or tent's second moments, at most 1."""
    D = len(per_cell)
    l0 = np.array([initial_half(name, n) for n in per_cell])
    if not follows(name):
        return np.tile(l0, (len(F), 1))
    moments = F @ np.diag((l0 * CELL[:D]) ** 2) @ F.transpose(0, 2, 1)
    return np.minimum(np.sqrt(np.einsum("nii->ni", moments)) / CELL[:D], 1.0)


def setting(name, per_cell, n=400):
    """Shape, frame, and particles: positions, deformation (in half of them), half-widths."""
    D = len(per_cell)
    rng = np.random.default_rng(SEED)
    shape = entry(name, per_cell)
    frame = make_frame(shape, ORIGIN[:D], CELL[:D], CELLS[:D])
    F = np.tile(np.eye(D), (n, 1, 1))
    F[n // 2 :] += rng.uniform(-0.7, 0.7, (n - n // 2, D, D))
    x = special(rng, frame, [initial_half(name, k) for k in per_cell], n)
    return shape, frame, x, F, half_of(name, per_cell, F)


def roundoff(name, half):
    """Of a weight, (n,): a sum of squares over the half-width, or of cubes over its square."""
    power = {"mpm": 0}.get(name, 2 if name.startswith("fuzzy") else 1)
    return 16 * EPS * (1.0 + (half**-power if power else 0.0 * half)).max(axis=1)


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
def test_partition_of_unity_and_linear_completeness(name, per_cell):
    """(23), gradients that sum to zero; a linear field has the particle's value and gradient."""
    shape, frame, x, F, half = setting(name, per_cell)
    S, grad = products(*supports(shape, frame, x, F))
    over = tuple(range(1, S.ndim))
    rounding = roundoff(name, half)
    assert np.abs(S.sum(axis=over) - 1).max() < 1e-14
    assert (np.abs(grad.sum(axis=over) * frame.cell).max(axis=1) < 1e-14 + rounding).all()
    assert S.min() > -1e-15
    for d, xv in enumerate(coordinates(frame)):
        xv = xv.reshape([-1 if i == d else 1 for i in range(x.shape[1])])
        assert (np.abs((S * xv).sum(axis=over) - x[:, d]) < 2e-14 + rounding).all()
        gradient = (grad * xv[..., None]).sum(axis=over) - np.eye(x.shape[1])[d]
        # Coordinates of up to 12 cells from the origin, cells that differ by a factor of five.
        assert (np.abs(gradient).max(axis=1) < 60 * (1e-14 + rounding)).all()


@pytest.mark.parametrize(("name", "per_cell"), CASES)
def test_quadrature(name, per_cell):
    """Weights and gradients are the integrals (19) and (20) for the half-width of each particle."""
    shape, frame, x, F, half = setting(name, per_cell)
    xi = (x - frame.origin) / frame.cell
    if name == "mpm":  # which side of a vertex a point is on must not hang on rounding here
        chosen = (np.abs(xi - np.rint(xi)) > 1e-13).all(axis=1)
        x, F, half = x[chosen], F[chosen], half[chosen]
        assert len(x) > 30
    elif name == "fuzzy-constant":
        assert (half[len(x) // 2 :, 0] == 1.0).sum() > 30  # clamped
    weight, slope = supports(shape, frame, x, F)
    rounding = 2e-14 + roundoff(name, half)[:, None]
    for d, (xv, L) in enumerate(zip(coordinates(frame), frame.cell, strict=True)):
        expected, expected_slope = integrals(chi_of(name), half[:, d] * L, x[:, d], xv, L)
        assert (np.abs(weight[d] - expected) < rounding).all()
        # Rounding of the coordinate shifts the slope by its own slope, at most 1/half.
        steep = 1.0 if name == "mpm" else 1.0 / half[:, d, None]
        assert (np.abs(slope[d] - expected_slope) * L < rounding * np.maximum(steep, 1.0)).all()


@kernel
def weigh(shape, half, f, w, g):
    """What the kernel of a shape says for one half-width and position."""
    found, slopes = weights(shape, half, f)
    for i in range(len(found)):
        w[i] = found[i]
        g[i] = slopes[i]


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "mpm"])
@settings(max_examples=200, deadline=None)
@given(half=st.floats(0.004, 1.0), offset=st.floats(0.0, 1.0, exclude_max=True))
@example(half=1.0, offset=0.0)
@example(half=0.5, offset=0.0)
@example(half=0.5, offset=0.5)
@example(half=1.0, offset=1.0 - 2.0**-53)
def test_any_half_width_at_any_place(name, half, offset):
    """From four thousandths of a cell to the widest there are, against the general integrator."""
    shape = entry(name, (1,))
    if not follows(name):  # none is wider than that of a particle alone in its cell
        widest = initial_half(name, 1)
        half = widest if initial_half(name, 2) == widest else half * widest
    w, g = np.zeros((2, shape.vertices))
    f = half + offset
    weigh(shape.parameters((1.0,)), half, f, w, g)
    expected, slope = integrals(chi_of(name), half, f, np.arange(shape.vertices), 1.0)
    rounding = roundoff(name, np.array([[half]]))
    assert np.abs(w - expected).max() < rounding
    assert np.abs(g - slope).max() < rounding / half**0.5
    assert (w >= -1e-16).all(), "a negative mass at a vertex would be a fault to look for"


def test_point_on_a_vertex():
    """A material point on a vertex gives all to it; its gradient is that of the cell above."""
    shape = entry("mpm", (1,))
    frame = make_frame(shape, (0.0,), (0.5,), (8,))
    weight, slope = supports(shape, frame, np.arange(9.0)[:, None] * 0.5, np.ones((9, 1, 1)))
    ghost = frame.ghost
    # The other vertex gets next to nothing, but something: it must have a velocity.
    at = weight[0][:, ghost : ghost + 10]
    assert (at == np.eye(9, 10) + 1e-60 * np.eye(9, 10, 1)).all()
    assert (slope[0][:, ghost : ghost + 10] == 2 * (np.eye(9, 10, 1) - np.eye(9, 10))).all()


@pytest.mark.parametrize(("name", "per_cell"), [c for c in CASES if "cpdi" not in c.values[0]])
def test_gradient_is_the_derivative_of_the_weight(name, per_cell):
    """Central differences in each direction, the first vertex found anew at each position.

    Not of cpdi, whose gradient is the mean over the box, and whose weight that of its ends.
    """
    shape, frame, x, F, half = setting(name, per_cell)
    xi = (x - frame.origin) / frame.cell
    h = 1e-5
    inside = (xi > 2 * h).all(axis=1) & (xi < np.array(frame.cells) - 2 * h).all(axis=1)
    if name == "mpm":  # the weight has kinks
        inside &= (np.abs(xi - np.rint(xi)) > 2 * h).all(axis=1)
    x, F, half = x[inside], F[inside], half[inside]
    assert len(x) > 30
    _, grad = products(*supports(shape, frame, x, F))
    # A box's weight has a second derivative of up to 1/half, which jumps, a tent's a third one of
    # up to 2/half^2; where a half-width is below h, the difference sees nothing of that.
    smooth = 1.0 if name == "mpm" else 1.0 / half
    bend = h**2 * 2 * smooth**2 if name.startswith("fuzzy") else 2 * h * smooth
    for d, L in enumerate(frame.cell):
        step = np.eye(x.shape[1])[d] * h * L
        above, below = (products(*supports(shape, frame, x + s * step, F))[0] for s in (1, -1))
        difference = (above - below) / (2 * h * L)
        bound = bend if name == "mpm" else bend[:, d]
        found = np.abs(difference - grad[..., d]).reshape(len(x), -1).max(axis=1) * L
        assert (found < bound + roundoff(name, half) / h + 1e-9).all()


@pytest.mark.parametrize("name", VARIANTS)
def test_support_is_no_larger_than_need_be(name):
    """Somewhere every one of the support's vertices has weight: storage and speed depend on it."""
    shape, frame, x, F, _ = setting(name, (1,))
    weight, _ = supports(shape, frame, x, F)
    assert (weight[0] > 1e-9).sum(axis=1).max() == shape.vertices
    assert set(KINDS) < set(VARIANTS)
