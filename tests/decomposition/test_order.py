"""Canonical order, migration and the cutting into slabs, against plain sorting."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from kernel_driver import entry, initial_half, make_frame
from rank_threads import Comm, together

from pgimp.decomposition.migrate import Migration, pack, unpack
from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab, cut, slab_of
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.particles import Particles
from pgimp.physics.shapes import SHAPES

CELL, CELLS = (0.3, 0.7), (9, 3)


class World:
    """All particles in plain Python: position, cell at the last re-sort, a signature each."""

    def __init__(self, name, ppc, xi, ranks, cut_at):
        self.shape = entry(name, (ppc, ppc))
        self.half = initial_half(name, ppc)
        self.frame = make_frame(self.shape, (-1.0, 2.0), CELL, CELLS)
        self.x = {n: x * CELL + self.frame.origin for n, x in enumerate(xi)}
        self.layer = {n: self.vertex(x, 0) for n, x in self.x.items()}
        self.sort()
        self.decompose(ranks, cut_at)

    def vertex(self, x, d):
        """First vertex that the particle reaches along direction d."""
        xi = (x[d] - self.frame.origin[d]) * self.frame.inverse[d]
        return math.floor(xi - self.half) + self.frame.ghost

    def sort(self):
        self.cell = {n: self.number(x) for n, x in self.x.items()}

    def number(self, x):
        """Layer, then block of four cells, then how many vertices have weight, then cell."""
        first = [self.vertex(x, d) for d in (0, 1)]
        breadth = 0
        for d in (0, 1):
            f = (x[d] - self.frame.origin[d]) / CELL[d] - (first[d] - self.frame.ghost)
            reached = sum(f + self.half > k for k in range(1, self.shape.vertices - 1))
            breadth = 3 * breadth + reached
        block = first[0] * (self.frame.vertices[1] // 4 + 1) + first[1] // 4
        return (block * 27 + breadth) * 4 + first[1] % 4

    def expected(self, slab):
        """Numbers of the slab's particles in canonical order."""
        own = [n for n, at in self.layer.items() if slab.first <= at < slab.first + slab.layers]
        return sorted(own, key=lambda n: (self.layer[n], self.cell[n], n))

    def decompose(self, ranks, cut_at):
        width, layers = self.shape.vertices - 1, self.frame.vertices[0]
        cuts = [0]
        for k in range(1, ranks):
            low, high = cuts[-1] + width, layers - (ranks - k) * width
            cuts.append(low + cut_at % (high - low + 1))
        cuts.append(layers)
        boxes = {}
        self.ranks = []
        for rank in range(ranks):
            slab = slab_of(cuts, rank)
            own = self.expected(slab)[::-1]
            p = Particles.empty(max(len(own), 1), Carried(2))
            for row, n in enumerate(own):
                p.x[row], p.id[row], p.m[row], p.sigma[row, 3] = self.x[n], n, n + 0.5, -n
            population = Population(p, len(own), self.shape.parameters(CELL), self.frame, slab)
            self.ranks.append((Migration(Comm(rank, boxes), slab, p), slab, population))

    def move(self, steps):
        """One step: particle n moves by ``steps[n]`` cells, then the ranks restore their order."""
        # Not to the edge: there rounding decides whether a vertex has weight.
        low = np.array(self.frame.origin) + 1e-3
        high = np.array(self.frame.origin) + np.array(CELL) * CELLS - 1e-3
        for n, step in steps.items():
            x = np.clip(self.x[n] + step * CELL, low, high)
            layer = self.vertex(x, 0)
            if abs(layer - self.layer[n]) <= 1:  # two, by rounding, would have stopped the run
                self.x[n], self.layer[n] = x, layer
        together([lambda r=rank: self.advance(*r) for rank in self.ranks])

    def advance(self, migration, slab, population):
        p, order, changed, found = population.up_to_date(), population.order, population.changed, 0
        for place, row in enumerate(order):
            n = int(p.id[row])
            p.x[row] = self.x[n]
            if p.layer[row] != self.layer[n]:
                p.layer[row] = self.layer[n]
                changed[found] = place
                found += 1
        left = changed[:found]
        migration.proceed(population, left)
        coming = migration.receive(population)
        if found or len(coming):
            population.restore_order(left, coming)

    def resort(self):
        self.sort()
        for _, _, population in self.ranks:
            population.sort()
            count = len(population.order)
            assert (population.order == np.arange(count)).all()

    def check(self):
        for _, slab, population in self.ranks:
            p, order = population.up_to_date(), population.order
            expected = self.expected(slab)
            assert p.id[order].tolist() == expected
            assert p.layer[order].tolist() == [self.layer[n] for n in expected]
            assert p.cell[order].tolist() == [self.cell[n] for n in expected]
            assert p.m[order].tolist() == [n + 0.5 for n in expected]
            assert p.sigma[order, 3].tolist() == [-n for n in expected]
            assert p.x[order].tolist() == [self.x[n].tolist() for n in expected]
            beginnings = np.searchsorted(p.layer[order], slab.first + np.arange(slab.layers + 1))
            assert (population.start == beginnings).all()
            assert len(population.changed) >= len(order)
            assert p.capacity >= len(order)


def steps_of(kind, size, seed, n):
    if kind == "all":
        return {k: np.array([size, 0.0]) for k in range(n)}
    if kind == "against":
        return {k: np.array([size if k % 2 else -size, 0.0]) for k in range(n)}
    rng = np.random.default_rng(seed)
    return {k: rng.uniform(-1, 1, 2) for k in range(n) if rng.random() < 0.4}


moves = st.tuples(
    st.sampled_from(["all", "against", "some", "re-sort"]),
    st.sampled_from([1.0, 0.5, -0.5, -1.0, 0.9]),
    st.integers(0, 2**20),
)


@settings(max_examples=60, deadline=None)
@given(
    name=st.sampled_from(sorted(SHAPES)),
    ppc=st.sampled_from([1, 2, 3]),
    xi=st.lists(
        st.tuples(st.integers(0, 35), st.integers(0, 11)).map(lambda k: (np.array(k) + 0.5) / 4),
        max_size=40,
    ),
    ranks=st.integers(1, 4),
    cut_at=st.integers(0, 100),
    script=st.lists(moves, max_size=12),
)
@example("mpm", 1, [np.array([4.5, 0.5])] * 3 + [np.array([5.5, 0.5])] * 3, 2, 4,
         [("all", 1.0, 0), ("all", -1.0, 0), ("all", 1.0, 0)])  # fmt: skip
@example("mpm", 1, [np.array([8.125, 0.125])], 3, 8, [("all", 1.0, 0), ("all", -1.0, 0)])
@example("mpm", 2, [np.array([k + 0.5, j + 0.5]) for k in range(9) for j in range(3)], 3, 1,
         [("against", 1.0, 0), ("some", 1.0, 1), ("against", -1.0, 0)])  # fmt: skip
def test_order_after_any_moves(name, ppc, xi, ranks, cut_at, script):
    """On 1 to 4 ranks, many steps: the order is that of sorting by (layer, cell, number)."""
    world = World(name, ppc, xi, ranks, cut_at)
    world.check()
    for kind, size, seed in script:
        if kind == "re-sort":
            world.resort()
        else:
            world.move(steps_of(kind, size, seed, len(xi)))
        world.check()


def test_swapping_crowds():
    """Half of a dense crowd moves one way, half the other, to and fro: every row is reused."""
    rng = np.random.default_rng(5)
    xi = [np.array([rng.uniform(0, 9), rng.uniform(0, 3)]) for _ in range(400)]
    world = World("gimp", 2, xi, 3, 3)
    for step in range(24):
        size = 0.8 if step % 4 < 2 else -0.8
        world.move(steps_of("against" if step % 3 else "all", size, step, len(xi)))
        world.check()
        if step == 12:
            world.resort()
            world.check()


def test_large_numbers_sort_alike():
    """Cell and number may be too large for one key; the order is the same."""
    shape = entry("mpm", (1, 1, 1))
    frame = make_frame(shape, (0.0,) * 3, (1.0,) * 3, (2**19,) * 3)
    rng = np.random.default_rng(3)
    n = 50
    for largest in (2**52, 60):
        p = Particles.empty(n, Carried(3))
        p.x[:] = rng.integers(0, 2**19, (n, 3)) + 0.5
        p.x[n // 2 :] = p.x[: n - n // 2]
        p.id[:] = rng.permutation(n) + largest - 60
        keys = np.floor(p.x).astype(int).tolist()
        expected = [k for _, k in sorted(zip(keys, p.id.tolist(), strict=True))]
        slab = Slab(0, frame.vertices[0], None, None)
        population = Population(p, n, shape.parameters(frame.cell), frame, slab)
        assert population.up_to_date().id.tolist() == expected


def test_rows_of_those_that_left_are_used_again():
    """The store grows only when it has no holes left, and keeps what it holds."""
    shape = entry("mpm", (1,))
    frame = make_frame(shape, (0.0,), (1.0,), (9,))
    p = Particles.empty(6, Carried(1, True))
    p.x[:, 0] = np.arange(6) + 0.5
    p.id[:] = np.arange(6)
    slab = Slab(0, 8, None, 1)
    population = Population(p, 6, shape.parameters(frame.cell), frame, slab)
    population.up_to_date().layer[[1, 4]] = 8
    population.free_later(np.array([1, 4], np.int32))
    population.restore_order(np.array([1, 4], np.int32), np.empty(0, np.int32))
    assert population.up_to_date().id[population.order].tolist() == [0, 2, 3, 5]
    assert sorted(population.insert(2).tolist()) == [1, 4]
    assert population.up_to_date().capacity == 6
    assert population.insert(3).tolist() == [6, 7, 8]
    assert population.up_to_date().capacity >= 9
    assert population.up_to_date().id[[0, 2, 3, 5]].tolist() == [0, 2, 3, 5]
    assert population.up_to_date().origin.shape == (population.up_to_date().capacity, 1)


#: As float64: quiet and signalling NaN with payloads, infinity, denormals, zeros of both signs.
PATTERNS = np.array(
    [0x7FF8000000000123, 0x7FF0000000000001, -0x000FFFFFFFFFFFFF, -1, 0x7FF0000000000000, 1,
     0x000FFFFFFFFFFFFF, 0, -(2**63), 2**63 - 1, 42, 2**53 + 1],
    np.int64,
)  # fmt: skip


@pytest.mark.parametrize("origin", [False, True])
@pytest.mark.parametrize("D", [1, 2, 3])
def test_packing_keeps_every_bit(D, origin):
    """Whole numbers and floats of any bit pattern survive the way through a message."""
    rng = np.random.default_rng(D)
    n = len(PATTERNS)

    def filled(capacity):
        p = Particles.empty(capacity, Carried(D, origin))
        for array in p:
            raw = rng.integers(0, 256, array.nbytes, np.uint8)
            array.reshape(-1).view(np.uint8)[:] = raw
        return p

    source, target = filled(n + 3), filled(2 * n)
    rows, places = rng.permutation(n + 3)[:n], rng.permutation(2 * n)[:n]
    source.id[rows] = source.cell[rows[::-1]] = PATTERNS
    source.x[rows, 0] = PATTERNS.view(np.float64)
    others = np.setdiff1d(np.arange(2 * n), places)
    before = [array[others].tobytes() for array in target]

    message = pack(source, rows.astype(np.int32))
    wire = np.frombuffer(message.tobytes(), np.int64).reshape(message.shape)
    unpack(wire, target, places.astype(np.int32))

    for a, b in zip(source, target, strict=True):
        assert a[rows].tobytes() == b[places].tobytes()
    assert [array[others].tobytes() for array in target] == before
    empty = pack(source, rows[:0])
    assert empty.shape == (0, message.shape[1])
    unpack(empty, target, rows[:0])


@settings(max_examples=300, deadline=None)
@given(
    counts=st.lists(st.sampled_from([0, 0, 1, 2, 5, 40, 41, 1000]), min_size=1, max_size=60),
    ranks=st.integers(1, 20),
    width=st.integers(1, 3),
)
def test_cuts(counts, ranks, width):
    """Every layer has one owner, none owns too few; idle ranks come last and only when needed."""
    cuts = cut(np.array(counts), ranks, width)
    layers, active = len(counts), len(cuts) - 1
    assert cuts[0] == 0 and cuts[-1] == layers
    widths = np.diff(cuts)
    assert active == max(1, min(ranks, layers // width))
    assert (widths >= width).all() or active == 1
    slabs = [slab_of(cuts, rank) for rank in range(ranks)]
    owned = [layer for slab in slabs for layer in range(slab.first, slab.first + slab.layers)]
    assert owned == list(range(layers))
    for rank, slab in enumerate(slabs):
        assert (slab.layers > 0) == (rank < active)
        assert slab.lower == (rank - 1 if 0 < rank < active else None)
        assert slab.upper == (rank + 1 if rank + 1 < active else None)
