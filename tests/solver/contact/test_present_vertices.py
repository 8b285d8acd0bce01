"""What vertices see where bodies of the initial configuration are now, and whose they are."""

import numpy as np
import pytest
from scenes import SOFT, scene, start
from tiers import wide

from pgimp.solver.contact.lagrangian.lagrangian import LagrangianContact
from pgimp.solver.contact.lagrangian.shares import divide, undivided

pytestmark = pytest.mark.slow(30)


def first_contact(monkeypatch, **method):
    """Two disks that fly unstrained, at the first step with pairs: what is found in it."""
    bodies = {
        name: {"material": "soft", "velocity": v, "configuration": "initial",
               "surface": "whole", "region": {"ball": {"centre": centre, "radius": 2.0}}}
        for name, centre, v in (("a", [3.1, 3.0], [0.4, 0.1]), ("b", [8.2, 3.3], [-0.3, 0.0]))
    }  # fmt: skip
    case = scene(2, bodies, cells=[12, 7], end=3.0, step={"courant": 0.3},
                 materials={"soft": SOFT | {"young": 1000.0}},
                 contact=[{"bodies": "all"}])  # fmt: skip
    case["method"] |= method
    find, kept = LagrangianContact._find, []

    def look(self, near, t):
        found = find(self, near, t)
        kept.append((near, t.start, *found))
        return found

    monkeypatch.setattr(LagrangianContact, "_find", look)
    sim = start(case)
    while not kept or len(kept[-1][2].ends) == 0:
        sim.advance()
    return sim, bodies, *kept[-1]


@pytest.mark.parametrize(
    "shape", ["gimp", "cpdi", *map(wide, ("finite-gimp", "bspline-quadratic", "mpm"))]
)
def test_vertices_see_an_affine_motion_where_they_are(shape, monkeypatch):
    """Rows of B add up to 1, and give the vertex's place from those of the start's vertices.

    A body that has moved by u and is not strained was at x - u at the start.
    """
    sim, bodies, near, time, contact_pairs, coupling = first_contact(monkeypatch, shape=shape)
    frame = sim.scene.domain.frame
    rest, field = np.divmod(near.vertices.keys, 2)
    across = 1
    while across < frame.cells[1] + 1 + 2 * frame.ghost:
        across *= 2  # each number has bits of its own
    number = np.transpose(np.divmod(rest, across))
    assert set(field) == {0, 1}
    places = np.array(frame.origin) + (number - frame.ghost) * np.array(frame.cell)
    for end in contact_pairs.ends:
        x = np.array(frame.origin) + (end["vertex"][:2] - frame.ghost) * frame.cell
        for side, name in enumerate("ab"):
            row = slice(*coupling.start[end["rows"][side] : end["rows"][side] + 2])
            B, j = coupling.entry[row, 0], coupling.column[row]
            assert B.sum() == pytest.approx(1.0, abs=1e-12)
            moved = np.array(bodies[name]["velocity"]) * time
            assert B @ places[j] == pytest.approx(x - moved, abs=1e-10)


class Ranks:
    """A communicator of several ranks, of which this one alone has particles."""

    def __init__(self, size):
        self.size = size

    def Allreduce(self, counts, found, _):
        """Find the counts."""
        found[:] = counts


@pytest.mark.parametrize("size", [2, 3, 7])
@pytest.mark.parametrize("seed", range(4))
def test_shares_take_every_vertex_once_and_are_even(size, seed):
    """A flat cloud is cut across, by a hundredth of its particles as nearly as planes allow."""
    random, most, vertices = np.random.default_rng(seed), np.array([9, 60, 60]), 3
    first = np.floor(random.uniform([4, 5, 5], [6, 55, 15], (4000, 3)))
    shares = divide(Ranks(size), first, vertices, most)
    assert shares.axis == 1
    assert (np.diff(shares.ends) > 0).all()
    numbers = first.astype(int)[:, :, None] + np.arange(vertices)
    owners = np.array([
        ((numbers[:, 1] >= low) & (numbers[:, 1] <= high)).any(axis=1)
        for _, low, high in map(shares.within, range(size))
    ])  # fmt: skip
    reached = np.array([shares.reached(first, first + vertices - 1, rank) for rank in range(size)])
    np.testing.assert_array_equal(reached, owners)
    begins = np.array([(numbers[:, 1, 0] >= low) & (numbers[:, 1, 0] <= high)
                       for _, low, high in map(shares.within, range(size))])  # fmt: skip
    np.testing.assert_array_equal(begins.sum(axis=0), 1)
    assert begins.sum(axis=1).max() < 4000 / size + 2 * 4000 / 50


def test_before_anything_is_divided_the_first_rank_has_all():
    """So where particles come near between two searches, when none was near at the first."""
    shares, first = undivided(3), np.random.default_rng(0).integers(-9, 99, (50, 3)).astype(float)
    reached = [shares.reached(first, first + 2, rank) for rank in range(3)]
    assert reached[0].all()
    assert not np.any(reached[1:])
    for rank in (1, 2):
        _, least, greatest = shares.within(rank)
        assert least > greatest
