"""A rank's particles as they come, go and change layers, against plain sorting."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.particles import Particles
from pgimp.physics.shapes.mpm import MpmParameters

FRAME = Frame((0.0,), (1.0,), (1.0,), (9,), 1)
SHAPE = MpmParameters((0.0,))
SLAB = Slab(3, 3, 0, 2)


def keys(population):
    p, rows = population.up_to_date(), population.order
    return list(zip(p.layer[rows], p.cell[rows], p.id[rows], strict=True))


@settings(deadline=None)
@given(
    seed=st.integers(0, 2**32),
    count=st.integers(0, 30),
    steps=st.lists(st.tuples(st.integers(0, 12), st.floats(0.0, 0.6)), min_size=1, max_size=12),
)
def test_the_order_is_canonical_whoever_comes_and_goes(seed, count, steps):
    rng = np.random.default_rng(seed)
    p = Particles.empty(max(count, 1), Carried(1))
    p.x[:count, 0] = rng.uniform(2.0, 5.0, count)  # layers 3, 4 and 5: one ghost vertex lies below
    p.id[:count] = np.arange(count)
    population = Population(p, count, SHAPE, FRAME, SLAB)
    members, next_id = {*range(count)}, count
    for newcomers, share in steps:
        order, p = population.order, population.up_to_date()
        changed = np.flatnonzero(rng.random(len(order)) < share)
        assert len(population.changed) >= len(order), "room for all, should all move"
        p.layer[order[changed]] += rng.choice([-1, 1], len(changed)).astype(np.int32)
        rows = order[changed]
        gone = (p.layer[rows] < 3) | (p.layer[rows] > 5)
        # As `migrate` does it: rows are given up first, then newcomers get rows.
        population.free_later(rows[gone])
        new = population.insert(newcomers)
        p = population.up_to_date()
        p.id[new] = rng.permutation(newcomers) + next_id
        p.cell[new] = rng.integers(2, 7, newcomers)
        p.layer[new] = rng.choice([3, 5], newcomers)
        members = members - {*p.id[rows[gone]].tolist()} | {*p.id[new].tolist()}
        next_id += newcomers
        population.restore_order(changed.astype(np.int32), np.concatenate([rows[~gone], new]))
        found = keys(population)
        assert found == sorted(found)
        assert {number for _, _, number in found} == members and len(found) == len(members)
        starts = [sum(layer < 3 + i for layer, _, _ in found) for i in range(4)]
        assert population.start.tolist() == starts
