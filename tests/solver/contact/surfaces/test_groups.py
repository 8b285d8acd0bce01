"""Connected groups of bodies: each is solved for as if it were alone, whichever rank has it."""

import numpy as np
import pytest
from scenes import box, field, scene, start

from pgimp.solver.contact.surfaces.groups import find_groups

pytestmark = pytest.mark.slow(20)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}
HEAPS = {
    "one": box([1.2, 1.1], [4.6, 3.3], [2.0, 0.5]) | EXACT,
    "other": box([5.1, 1.7], [8.2, 4.1], [-1.0, 0.0]) | EXACT,
    "third": box([2.3, 5.9], [5.2, 8.0], [1.0, 0.0]) | EXACT,
    "fourth": box([5.8, 5.6], [8.3, 7.7], [-2.5, 0.3]) | EXACT,
}


def run(*names):
    """The simulation of some of the bodies, at its end, and its greatest number of groups.

    It searches in each step: when it is time for that, the fastest of all bodies says.
    """
    sim = start(
        scene(2, {name: HEAPS[name] for name in names}, cells=[11, 9], step=0.01, end=0.8,
              contact=[{"bodies": "all", "friction": 0.3}])
    )  # fmt: skip
    groups = 0
    while not sim.finished:
        sim.rank.contact.proximity.restart()
        sim.advance()
        groups = max(groups, len(sim.rank.contact._proximity.groups.rank))
    return sim, groups


#: Gaps are found anew when their search is, which the fastest bodies of all tell: to 5e-12.
FOUND = 1e-9


def test_two_heaps_move_as_each_alone():
    whole, groups = run("one", "other", "third", "fourth")
    assert groups == 2
    for first, names in ((0, ("one", "other")), (2, ("third", "fourth"))):
        alone, groups = run(*names)
        assert groups == 1
        mine = np.isin(field(whole, "body"), [first, first + 1])
        for name in ("x", "v", "sigma"):
            np.testing.assert_allclose(field(whole, name)[mine], field(alone, name), atol=FOUND)
        before = np.array([HEAPS[name]["velocity"] for name in names])
        after = field(alone, "v")[:, :2] - before[field(alone, "body")]
        assert np.abs(after).max() > 0.5  # they have met


def test_groups_are_joined_by_what_may_move_and_shared_out_along_x():
    # Bodies 0 to 5, of which 4 and 5 are bonded; a free rigid body, 6; a prescribed one, 7; a wall.
    labels = np.array([0, 1, 2, 3, 4, 4, 6, -1, -1])
    pairs = np.array([[0, 1], [1, 0], [2, 7], [3, 7], [3, 8], [5, 6], [0, 6], [4, 7], [0, 8]])
    x = np.array([5.0, 5.0, 1.0, 9.0, 9.0, 5.0, 5.0, 5.0, 5.0])
    met, of = np.unique(pairs, axis=0, return_inverse=True)
    groups = find_groups(labels, met, of.reshape(-1), x, 3)
    np.testing.assert_array_equal(groups.of[[0, 1, 4, 5, 6]], groups.of[0])
    assert len({groups.of[0], groups.of[2], groups.of[3]}) == 3
    np.testing.assert_array_equal(groups.of[7:], -1)
    np.testing.assert_array_equal(groups.number(pairs), groups.of[[0, 0, 2, 3, 3, 0, 0, 0, 0]])
    np.testing.assert_array_equal(groups.rank[groups.of[[2, 0, 3]]], [0, 1, 2])
    np.testing.assert_array_equal(find_groups(labels, met, of.reshape(-1), x, 1).of, groups.of)
    assert len(find_groups(labels, met[:0], of.reshape(-1)[:0], x[:0], 2).rank) == 0
