"""A step gives the same bits however the layers are cut into slabs."""

from functools import partial
from itertools import combinations

import numpy as np
import pytest
from kernel_driver import (
    KINDS,
    MATERIAL_OF,
    SEED,
    Rank,
    copy_of,
    entry,
    make_frame,
    random_particles,
    random_positions,
    split,
)
from kernel_sums import sums_of
from rank_threads import together

from pgimp.kernels.data.images import Images
from pgimp.physics.boundaries import BOUNDARIES

ORIGIN, CELL = (-1.1, 0.3, 2.0), (0.7, 1.3, 0.9)
DT, GRAVITY = 0.002, (1.5, -9.0, 4.0)
ADVANCED = ("x", "v", "F", "sigma", "V", "layer")


def all_cuts(layers, width, ends=0):
    """Ways to share the layers among two ranks, and among three."""
    for number in (1, 2):
        for inner in combinations(range(1, layers), number):
            cuts = [0, *inner, layers]
            widths = np.diff(cuts)
            if min(widths) >= width and min(widths[0], widths[-1]) >= ends:
                yield cuts


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("spread", ["everywhere", "clustered"])
def test_a_step_on_any_slabs(name, D, spread):
    """Every cut into two or three slabs: vertices, particles, sums, work and impulses."""
    rng = np.random.default_rng(SEED)
    cells = {"everywhere": ((12,), (7, 4), (6, 3, 2)), "clustered": ((16,), (9, 4), (6, 3, 2))}
    shape = entry(name, (2,) * D)
    frame = make_frame(shape, ORIGIN[:D], CELL[:D], cells[spread][D - 1])
    x = random_positions(rng, frame, 60, 0.05)
    if spread == "clustered":  # most slabs are empty
        x[:, 0] = ORIGIN[0] + CELL[0] * rng.uniform(0.1, 1.9, 60)
    particles = random_particles(rng, x)
    face = BOUNDARIES["velocity"].model_validate({"velocity": [0.1, -0.2, 0.3][:D]})
    faces = (face.parameters(D - 1, -1, 0.0, DT),)
    cuts = all_cuts(frame.vertices[0], shape.vertices - 1)
    assert agrees_on(shape, frame, particles, faces, (), cuts) > 20


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("kind", ["slip", "unilateral", "fixed"])
def test_mirrors_on_any_slabs(kind, D):
    """Reflection at all faces: no rank but the first and the last has to do with those along x."""
    rng = np.random.default_rng(SEED)
    shape = entry("fuzzy-constant-fixed", (2,) * D)  # reaches a cell beyond
    frame = make_frame(shape, ORIGIN[:D], CELL[:D], ((12,), (12, 3), (11, 3, 2))[D - 1])
    x = random_positions(rng, frame, 60, 0.05)
    for n, xi in enumerate((0.01, frame.cells[0] - 0.01)):  # some next to the faces along x
        x[5 * n : 5 * n + 5, 0] = ORIGIN[0] + CELL[0] * xi
    particles = random_particles(rng, x)
    condition = BOUNDARIES[kind].model_validate({})
    where = [(axis, side) for axis in range(D) for side in (-1, 1)]
    faces = tuple(condition.parameters(axis, side, 0.0, DT) for axis, side in where)
    mirrors = [
        Images(axis, side, n, kind == "unilateral", kind == "fixed")
        for n, (axis, side) in enumerate(where)
    ]
    cuts = all_cuts(frame.vertices[0], 3, 2 * shape.vertices)
    assert agrees_on(shape, frame, particles, faces, mirrors, cuts) >= 3


def agrees_on(shape, frame, particles, faces, mirrors, every_cut):
    """Compare a step on all slabs with one on a single slab; the number of ways tried."""
    D = len(frame.cells)
    whole = Rank(shape, frame, copy_of(particles))
    bounds = whole.population.vertex_bounds()
    sums = sums_of(whole, D, 2, MATERIAL_OF)
    whole.particles_to_grid(faces)
    added = [plane.copy() for plane in planes(whole)]
    whole.update_momentum(DT, GRAVITY[:D], faces, mirrors=mirrors)
    done = planes(whole)
    assert whole.grid_to_particles(DT)[0] == 0
    after = {n: k for k, n in enumerate(whole.up_to_date().id.tolist())}
    assert np.abs(whole.impulse).max() > 0 and np.abs(whole.work).max() > 0

    tried = 0
    for cuts in every_cut:
        ranks = split(shape, frame, particles, cuts, bounds)
        assert sum(len(rank.population.order) for rank in ranks) == 60
        parts = [sums_of(rank, D, 2, MATERIAL_OF) for rank in ranks]
        assert np.concatenate(parts).tobytes() == sums.tobytes()
        together([partial(rank.particles_to_grid, faces) for rank in ranks])
        agree(ranks, added)
        for rank in ranks:
            rank.update_momentum(DT, GRAVITY[:D], faces, mirrors=mirrors)
        agree(ranks, done)
        owned = [
            slice(None, rank.slab.layers if rank.slab.upper is not None else None) for rank in ranks
        ]
        for quantity in ("work", "impulse"):
            every = [getattr(r, quantity)[own] for r, own in zip(ranks, owned, strict=True)]
            assert np.concatenate(every).tobytes() == getattr(whole, quantity).tobytes()
            for rank, own in zip(ranks, owned, strict=True):
                assert not getattr(rank, quantity)[own.stop or rank.grid.planes :].any()
        for rank in ranks:
            assert rank.grid_to_particles(DT)[0] == 0
            rows = [after[n] for n in rank.up_to_date().id.tolist()]
            for field in ADVANCED:
                expected = getattr(whole.up_to_date(), field)[rows]
                assert getattr(rank.up_to_date(), field).tobytes() == expected.tobytes(), field
        tried += 1
    return tried


def planes(rank):
    """Planes of a rank's window, (planes, plane); None where inactive."""
    return [
        plane if active else np.zeros_like(plane)
        for plane, active in zip(
            rank.grid.G.reshape(rank.grid.planes, -1).copy(), rank.grid.active, strict=True
        )
    ]


def agree(ranks, expected):
    for rank in ranks:
        for i, plane in enumerate(planes(rank)):
            assert plane.tobytes() == expected[rank.slab.first + i].tobytes()
