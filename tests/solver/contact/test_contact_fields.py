"""Velocity fields of bodies that may meet: those that cannot yet share one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from scenes import box, finish, scene, start

from pgimp.solver.contact.velocity_fields import assign, where_near

#: Boxes of up to eight bodies in a plane, in cells.
BOXES = some.lists(
    some.tuples(*[some.floats(0.0, 60.0)] * 2, *[some.floats(0.1, 12.0)] * 2),
    min_size=1,
    max_size=8,
)


@given(BOXES, some.floats(1.0, 4.0))
@settings(deadline=None)
def test_bodies_that_share_a_field_cannot_meet(bodies, reach):
    """Not before the next look, if both move by a cell a step towards each other."""
    table = np.array(bodies)
    boxes = np.stack([table[:, :2], table[:, :2] + table[:, 2:]])
    fields, steps = assign(boxes, reach)
    assert steps >= 1
    for a in range(len(bodies)):
        for b in range(a):
            apart = max(
                max(boxes[0, a, d] - boxes[1, b, d], boxes[0, b, d] - boxes[1, a, d])
                for d in (0, 1)
            )
            if fields[a] == fields[b]:
                assert apart - 2.0 * steps >= reach
    # No field is left out, and one is enough for bodies that are far apart.
    assert set(fields) == set(range(max(fields) + 1))
    # In which planes those of different fields may share vertices meanwhile.
    ends, far = where_near(boxes, fields, reach, steps), steps + 0.5 * reach
    for plane in np.arange(-80.0, 150.0, 1.7):
        for a in range(len(bodies)):
            for b in range(a):
                apart = boxes[0, [a, b]] - boxes[1, [b, a]] - 2.0 * far
                both = (boxes[0, [a, b], 0] - far <= plane) & (plane <= boxes[1, [a, b], 0] + far)
                if fields[a] != fields[b] and both.all() and (apart < 0.0).all():
                    assert ((ends[:, 0] <= plane) & (plane <= ends[:, 1])).any()


def plain_fields(boxes, reach):
    """Fields, steps and intervals as `assign` and `where_near`, in NumPy."""
    low, high = boxes
    apart = np.full((len(low),) * 2, -np.inf)
    for d in range(low.shape[1]):
        np.maximum(apart, low[:, None, d] - high[None, :, d], out=apart)
    apart = np.maximum(apart, apart.T)
    alone = np.floor(0.5 * np.maximum(apart - reach, 0.0))
    fields, steps = np.zeros(len(low), int), 64
    for b in range(len(low)):
        taken = set(fields[:b][alone[b, :b] < 2].tolist())
        fields[b] = min(set(range(b + 1)) - taken)
        steps = min(steps, int(alone[b, :b][fields[:b] == fields[b]].min(initial=64)))
    steps = min(steps, 16) if fields.any() else steps
    a, b = np.triu_indices(len(low), 1)
    wide = 2.0 * steps + reach
    near = (fields[a] != fields[b]) & (apart[a, b] < wide)
    a, b = a[near], b[near]
    ends = [np.maximum(low[a, 0], low[b, 0]) - 0.5 * wide,
            np.minimum(high[a, 0], high[b, 0]) + 0.5 * wide]  # fmt: skip
    return tuple(fields.tolist()), steps, np.stack(ends, axis=1)


@pytest.mark.parametrize("seed", range(20))
def test_fields_of_hundreds_of_bodies_are_those_of_numpy(seed):
    """Heaps and sparse grains, in 1D to 3D, also bodies of which no particle is left."""
    random = np.random.default_rng(seed)
    D, count = 1 + seed % 3, int(random.integers(1, 300))
    low = random.uniform(0.0, random.choice([8.0, 60.0, 400.0]), (count, D))
    boxes = np.stack([low, low + random.uniform(0.5, 6.0, (count, D))])
    empty = random.random(count) < 0.1
    boxes[0, empty], boxes[1, empty] = np.inf, -np.inf
    reach = float(random.uniform(2.0, 4.0))
    fields, steps = assign(boxes, reach)
    ends = where_near(boxes, fields, reach, steps)
    expected = plain_fields(boxes, reach)
    assert (fields, steps) == expected[:2]
    if any(fields):
        np.testing.assert_array_equal(ends, expected[2])


def test_bodies_apart_share_a_field():
    bodies = {
        "left": box([2.0, 2.0], [5.0, 5.0], [1.0, 0.0]),
        "right": box([18.0, 2.0], [21.0, 5.0], [-1.0, 0.0]),
    }
    case = scene(2, bodies, cells=[26, 8], end=2.5, contact=[{"bodies": "all"}])
    sim, counts = start(case), []
    while not sim.finished:
        sim.advance()
        counts.append(1 + max(sim.rank.contact.fields))
    assert counts[0] == 1
    case["bodies"]["right"]["velocity"] = [-5.0, 0.0]
    sim = start(case | {"time": {"end": 2.5, "step": 0.01}})
    while 1 + max(sim.rank.contact.fields) == 1:
        sim.advance()
    assert sim.diagnostics()["contact.all.normal-impulse"] == 0.0
    assert finish(sim).diagnostics()["contact.all.normal-impulse"] > 0.0
