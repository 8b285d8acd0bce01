"""Candidate vertices and the particles within their reach, against loops over all of them."""

from itertools import product

import numpy as np
import pytest

from pgimp.kernels.contact.lagrangian.candidates import find_candidates, find_reach
from pgimp.kernels.contact.lagrangian.vertices import (
    NEAR_MOTION,
    NEAR_PARTICLE,
    VERTEX_SUMS,
    ContactVertices,
    Reached,
)
from pgimp.kernels.data.frame import Frame

VERTICES, HALF, SLACK, GROUPS = 3, 0.25, 0.1, 3


def frame_of(D):
    """A grid of cells with sides that are no powers of two."""
    cells, cell = (12,) * D, (0.3,) * D
    return Frame(
        origin=(0.1,) * D, cell=cell, inverse=tuple(1.0 / c for c in cell), cells=cells, ghost=2
    )


def cloud(D, seed, spread):
    """Particles of three groups at random positions."""
    random = np.random.default_rng((D, seed))
    table, motion = np.zeros(150, NEAR_PARTICLE), np.zeros(150, NEAR_MOTION)
    table["group"] = random.integers(0, GROUPS, 150)
    table["half_width"][:, :D] = HALF
    middles = random.uniform(1.0, 2.0, (GROUPS, D))
    motion["position"][:, :D] = middles[table["group"]] + random.normal(0.0, spread, (150, D))
    return table, motion


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize(("seed", "spread"), [(0, 0.1), (1, 0.3), (2, 0.6)])
def test_candidates_are_vertices_that_several_groups_may_reach(D, seed, spread):
    """All their entries are found, in the order of their keys, with all particles in reach."""
    frame, (table, motion) = frame_of(D), cloud(D, seed, spread)
    none = np.empty(0, np.int64)
    contact_vertices = ContactVertices(
        np.full(3, -20), np.full(3, 60), GROUPS, none, none, none, Reached.empty(0, 0),
        np.empty(0, VERTEX_SUMS), none, none,
    )  # fmt: skip
    within = np.array([0, 2, 9])
    slacks, boxes = (SLACK, SLACK), np.empty((0, 2, 3), np.int64)
    patches = find_candidates(
        frame, (table, motion), slacks, VERTICES, within, boxes, (), contact_vertices
    )
    order = np.argsort(patches.keys)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    reach = find_reach(frame, table, motion, SLACK, VERTICES, patches, rank, len(order))

    xi = (motion["position"][:, :D] - 0.1) / 0.3 - HALF
    low, high = np.zeros((2, len(table), 3), np.int64)
    low[:, :D] = np.floor(xi - SLACK) + frame.ghost
    ends = np.ceil(xi + 2.0 * HALF + SLACK + 1e-6)  # a cell beyond the half-width
    high[:, :D] = np.minimum(np.floor(xi + SLACK) + VERTICES - 1, ends) + frame.ghost
    met: dict = {}
    for i in range(len(table)):
        for v in product(*(range(a, b + 1) for a, b in zip(low[i], high[i], strict=True))):
            if 2 <= v[0] <= 9:
                met.setdefault(v, {}).setdefault(int(table["group"][i]), []).append(i)
    expected = {
        (*v, group): rows
        for v, by_group in met.items() if len(by_group) > 1
        for group, rows in by_group.items()
    }  # fmt: skip
    found = {}
    for n, key in enumerate(patches.keys[order].tolist()):
        vertex, group = divmod(key, GROUPS)
        v = np.array(np.unravel_index(vertex, (60, 60, 60))) - 20
        some = reach.rows[reach.particle[reach.start[n] : reach.start[n + 1]]]
        found[*v.tolist(), group] = some.tolist()
    for entry, rows in found.items():  # patches are whole cells: they may have a few more vertices
        if entry in expected:
            assert rows == expected[entry]
        else:
            assert not rows or len(met[entry[:3]]) == 1
    assert set(expected) <= set(found)
    assert (np.diff(reach.rows) > 0).all()
