"""Every kernel gives a particle the same bits, whatever its place in the arrays."""

import numpy as np
import pytest
from kernel_driver import (
    IDENTITIES,
    KINDS,
    SEED,
    Rank,
    copy_of,
    entry,
    initial_half,
    make_frame,
    place,
    random_particles,
    random_positions,
)
from kernel_sums import rate_of, sums_of
from tiers import wide

from pgimp.jit.kernel import kernel
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.order.order import cell_numbers, grow_vertex_bounds, locate, vertices_of
from pgimp.kernels.transfer.first_vertex import half_widths

ORIGIN, CELL = (-1.1, 0.3, 2.0), (0.7, 1.3, 0.9)
DT, GRAVITY = 0.002, (1.5, -9.0, 4.0)
LENGTHS = (*range(1, 18), 33, 64, 100)
ADVANCED = ("x", "v", "F", "sigma", "V", "layer")

EVERY = pytest.mark.parametrize(
    ("name", "D"),
    [(name, D) if D == 2 or (name, D) == ("gimp", 3) else wide(name, D)
     for name in KINDS for D in (1, 2, 3)],
)  # fmt: skip


def bits(array):
    """Bit patterns, row by row: unlike numbers, NaN equals NaN and -0 differs from 0."""
    return [row.tobytes() for row in np.ascontiguousarray(array)]


def setting(name, D, cells, per_cell=2):
    shape = entry(name, (per_cell,) * D)
    return shape, make_frame(shape, ORIGIN[:D], CELL[:D], cells[:D])


def crowd(name, D, n=100):
    """Rank with overlapping supports."""
    rng = np.random.default_rng(SEED)
    shape, frame = setting(name, D, (6, 4, 3))
    x = random_positions(rng, frame, n, 0.05)
    # Some where layers change, so that any motion to the left takes them to another.
    particles = random_particles(rng, x)
    half = sizes(shape, frame, particles)[: n // 4, 0]
    edges = rng.integers(1, frame.cells[0], n // 4) + half
    particles.x[: n // 4, 0] = ORIGIN[0] + CELL[0] * np.minimum(edges, frame.cells[0] - 0.1)
    return rng, shape, frame, particles


@kernel
def find_sizes(shape, frame, particles, half):
    for p in range(len(half)):
        found = half_widths(shape, frame, particles, p)
        for d in range(len(found)):
            half[p, d] = found[d]


def sizes(shape, frame, particles):
    """Half-widths of the particles, (n, D) in cells."""
    half = np.zeros(particles.x.shape)
    find_sizes(shape.parameters(frame.cell), frame, particles, half)
    return half


def selections(rng, n):
    """Stretches of the canonical order, and rows to store them in: with holes, shuffled."""
    for length in LENGTHS:
        begin = int(rng.integers(0, n - length + 1))
        capacity = 2 * length + int(rng.integers(0, 5))
        yield slice(begin, begin + length), rng.permutation(capacity)[:length], capacity


def restored(rank, chosen, rows, capacity):
    """Let a rank hold only some of its particles, in other rows of arrays at odd addresses."""
    population = rank.population
    taken = Particles(*(array[population.order[chosen]].copy() for array in rank.up_to_date()))
    spread = place(taken, rows + 1, capacity + 1)
    population.replace(Particles(*(array[1:] for array in spread)))
    population.order = rows.astype(np.int32)
    edges = np.arange(rank.slab.layers + 1) + rank.slab.first
    population.start = np.searchsorted(taken.layer, edges)


@EVERY
def test_grid_to_particles_does_not_see_the_neighbours(name, D):
    rng, shape, frame, particles = crowd(name, D)
    whole = Rank(shape, frame, copy_of(particles))
    whole.particles_to_grid()
    whole.update_momentum(DT, GRAVITY[:D])
    before = copy_of(whole.up_to_date())
    assert whole.grid_to_particles(DT)[0] == 0
    expected = {field: bits(getattr(whole.up_to_date(), field)) for field in ADVANCED}
    assert (before.layer != whole.up_to_date().layer).sum() > 3
    rates = []
    for chosen, rows, capacity in selections(rng, len(particles.m)):
        rank = Rank(shape, frame, copy_of(before))
        rank.grid = whole.grid
        restored(rank, chosen, rows, capacity)
        error, _, found, rate, *_ = rank.grid_to_particles(DT)
        assert error == 0
        for field in ADVANCED:
            assert bits(getattr(rank.up_to_date(), field)[rows]) == expected[field][chosen], field
        moved = before.layer[chosen] != whole.up_to_date().layer[chosen]
        assert (rank.population.changed[:found] == np.flatnonzero(moved)).all()
        rates.append(rate)
    assert rates[0] <= rates[-1] and len(set(rates)) > 1


@EVERY
def test_particles_to_grid_does_not_see_the_storage(name, D):
    """The same order in other rows."""
    rng, shape, frame, particles = crowd(name, D)
    rank = Rank(shape, frame, copy_of(particles))
    rank.particles_to_grid()
    expected = rank.records().tobytes()
    for _ in range(3):
        rank = Rank(shape, frame, copy_of(particles))
        restored(rank, slice(None), rng.permutation(170)[:100], 170)
        rank.particles_to_grid()
        assert rank.records().tobytes() == expected


@EVERY
def test_particles_to_grid_does_not_see_the_neighbours(name, D):
    """Of particles too far apart to share a vertex each gives what it gives alone."""
    rng = np.random.default_rng(SEED)
    apart = 4 if name in ("mpm", "gimp") else 5
    shape, frame = setting(name, D, ((120,), (40, 12), (16, 8, 12))[D - 1])
    corners = np.meshgrid(*(np.arange(0, cells, apart) for cells in frame.cells), indexing="ij")
    xi = np.stack([c.ravel() for c in corners], axis=1)
    xi = xi + rng.uniform(0.0, 1.0, xi.shape)
    particles = random_particles(rng, xi * frame.cell + frame.origin)
    n = len(xi)
    alone = []
    for k in range(n):
        rank = Rank(shape, frame, copy_of(particles))
        bounds = rank.population.vertex_bounds()
        restored(rank, slice(k, k + 1), np.array([0]), 1)
        rank.particles_to_grid()
        alone.append(rank.records())
    assert ((np.array(alone)[..., 0] != 0).sum(axis=0) <= 1).all()
    for m in (*range(1, 18), n):
        chosen, rows, capacity = slice(n - m, n), rng.permutation(2 * m)[:m], 2 * m
        rank = Rank(shape, frame, copy_of(particles), bounds=bounds)
        restored(rank, chosen, rows, capacity)
        rank.particles_to_grid()
        assert rank.records().tobytes() == sum(alone[chosen], np.zeros(alone[0].shape)).tobytes()


@pytest.mark.parametrize("D", [1, 2, 3])
def test_sums_and_rate_do_not_see_the_neighbours(D):
    """Each particle a body of its own: sums as it has them alone, the rate is the greatest."""
    rng, shape, frame, particles = crowd("gimp", D)
    n = len(particles.m)
    material_of = rng.integers(0, 2, n)
    particles.body[:] = rng.permutation(n)
    rows_of, rates = [], []
    for k in range(n):
        rank = Rank(shape, frame, copy_of(particles))
        restored(rank, slice(k, k + 1), np.array([0]), 1)
        row = sums_of(rank, D, n, material_of)
        rows_of.append(row)
        rates.append(rate_of(rank, D, material_of))
        assert np.count_nonzero(row[..., 0]) == 1
    for chosen, rows, capacity in selections(rng, n):
        rank = Rank(shape, frame, copy_of(particles))
        restored(rank, chosen, rows, capacity)
        expected = sum(rows_of[chosen], np.zeros(rows_of[0].shape))
        assert sums_of(rank, D, n, material_of).tobytes() == expected.tobytes()
        assert rate_of(rank, D, material_of) == max(rates[chosen])


@EVERY
def test_locate_does_not_see_the_neighbours(name, D):
    rng, shape, frame, particles = crowd(name, D)
    whole = Rank(shape, frame, copy_of(particles))
    order = whole.population.order
    for chosen, rows, capacity in selections(rng, len(particles.m)):
        rank = Rank(shape, frame, copy_of(particles))
        restored(rank, chosen, rows, capacity)
        p = rank.up_to_date()
        p.layer[:], p.cell[:] = -5, 0
        locate(rank.shape, frame, p, rank.population.order, frame.vertices)
        assert (p.layer[rows] == whole.up_to_date().layer[order[chosen]]).all()
        assert (p.cell[rows] == whole.up_to_date().cell[order[chosen]]).all()
        assert (np.delete(p.layer, rows) == -5).all()
        first = vertices_of(p.cell[rows], frame.vertices)
        assert (first[:, 0] == p.layer[rows]).all()
        assert (p.cell >= 0).all() and (p.cell[rows] < cell_numbers(frame.vertices)).all()
        bounds = np.array([[2**62] * 2, [-(2**62)] * 2])
        grow_vertex_bounds(rank.shape, frame, p, rank.population.order, bounds)
        for d in range(1, D):
            assert bounds[0, d - 1] == first[:, d].min() and bounds[1, d - 1] == first[:, d].max()


@EVERY
def test_all_kernels_find_the_same_layer(name, D):
    """Lattice particles sit where layers change, to rounding: at rest they stay in theirs.

    An expression that is contracted in one kernel and not in another puts them into two.
    """
    rng = np.random.default_rng(SEED)
    for trial in range(60):
        per_cell = int(rng.integers(1, 5))
        L = (1 / 3, 0.1, 0.7, 7e-3, rng.random())[trial % 5]
        origin = (0.0, 0.1, -3.3, 1 / 7)[trial % 4]
        shape = entry(name, (per_cell,) * D)
        frame = make_frame(shape, (origin,) * D, (L,) * D, (40, 3, 3)[:D])
        lattice = origin + (np.arange(40 * per_cell) + 0.5) * (L / per_cell)
        vertices = origin + np.arange(1, 40) * L
        edges = vertices + initial_half(name, per_cell) * L
        edges = np.minimum(edges, origin + 39.9 * L)
        x0 = np.concatenate([lattice, vertices, edges])
        x = np.full((len(x0), D), origin + 1.5 * L)
        x[:, 0] = x0
        particles = random_particles(rng, x)
        particles.F[len(lattice) :: 2] = IDENTITIES[D - 1]
        rank = Rank(shape, frame, particles)
        layer = rank.up_to_date().layer.copy()
        rank.grid.active[:] = 1
        assert not rank.grid.G.any()
        error, _, found, *_ = rank.grid_to_particles(1e-3)
        assert (error, found) == (0, 0)
        assert (rank.up_to_date().layer == layer).all()
