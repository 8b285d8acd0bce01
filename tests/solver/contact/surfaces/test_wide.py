"""Facets of flat faces that lie on each other are joined: exact weights, loads, the same bits."""

import warnings
from functools import cache

import numpy as np
import pytest
from scenes import SOFT, box, field, scene, start

from pgimp.kernels.contact.surfaces.data import Patches
from pgimp.kernels.contact.surfaces.nearest import FLAT
from pgimp.physics.columns import SURFACE
from pgimp.solver.contact.surfaces.rectangles import with_wide

pytestmark = pytest.mark.slow(60)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}


def blocks(surface=(), end=0.3):
    """A block that slides on another one, off its lattice, on a floor that lets go, in 3D."""
    bodies = {
        "base": box([1.3, 1.2, 0.0], [8.6, 6.4, 2.1]) | EXACT,
        "top": box([2.4, 1.7, 2.1], [6.5, 5.8, 4.3], [3.0, 0.5, 0.0]) | EXACT,
    }
    return scene(
        3, bodies, cells=[11, 8, 6], end=end, step={"courant": 0.3},
        materials={"soft": SOFT | {"young": 1000.0}}, gravity=[0.0, 0.0, -9.81],
        boundaries={"z-min": {"unilateral": {"friction": 0.3}}},
        contact=[{"bodies": "all", "friction": 0.3}],
        output={"every": end, **({"surface": [*surface]} if surface else {})},
    )  # fmt: skip


@cache
def at_rest():
    """A solver after two steps, and its surfaces."""
    sim = start(blocks())
    sim.advance()
    sim.advance()
    return sim, sim.rank.contact.known(sim.rank)


def test_joined_facets_have_the_sums_and_the_weights_of_their_parts():
    """Area, centroid, and the means of the weights of the cell's vertices."""
    _, table = at_rest()
    every, parts = table.every, np.flatnonzero(table.wide >= 0)
    assert len(every.x) > len(table.wide) > len(parts) > 0
    for wide in range(len(table.wide), len(every.x)):
        own = parts[table.wide[parts] == wide]
        area = every.area[own]
        assert len(own) > 1
        assert every.area[wide] == pytest.approx(area.sum(), rel=1e-12)
        assert every.area[wide] < 1.0 + 1e-9
        for name in ("x", "means", "normal"):
            mean = area @ getattr(every, name)[own] / area.sum()
            np.testing.assert_allclose(getattr(every, name)[wide], mean, atol=1e-12)
        corners = np.linalg.norm(np.cross(*every.edges[wide]))
        assert 4.0 * corners == pytest.approx(area.sum(), rel=1e-9)


def test_only_what_lies_on_a_plane_is_joined():
    """Beside edges are rows of facets, at corners small ones; the middle has one for each cell."""
    sim, table = at_rest()
    every = sim.rank.contact.proximity.candidates
    of, body = every["facet"], every["body"]
    on_floor = (body == 2) & (table.every.body[of] == 0)
    between = body == 1
    wide = of >= len(table.wide)
    assert on_floor.any()
    assert between.any()
    x, low, high = table.every.x[of], np.array([1.3, 1.2]), np.array([8.6, 6.4])
    edge = np.minimum(x[:, :2] - low, high - x[:, :2]).min(axis=1)
    rows, x = table.every.half[of][wide & (edge < 0.25), :2], x[:, :2]
    corners = (x < low + 0.25).all(axis=1)
    assert (rows.min(axis=1) < 0.13).all()
    assert (rows.max(axis=1) > 0.2).any()
    assert not wide[corners].any()
    assert corners[on_floor].any()
    assert wide[on_floor & (edge > 1.0)].all()
    assert wide[between].any()
    assert (table.surface.tip[every["other"][wide & ~on_floor]] & FLAT != 0).all()


def test_slivers_without_a_width_are_not_joined():
    """Cells of a face that is turned may end on its edge, to rounding."""
    sim, table = at_rest()
    surface, count = table.surface, len(table.surface.x)
    flat = (np.ones(count, bool), np.zeros((count, 3)))
    cell, number = np.array(sim.scene.domain.frame.cell), np.zeros((count, 3), np.int64)
    _, wide = with_wide(surface, flat, cell, number)
    sliver = np.flatnonzero(wide == wide.max())[0]  # the first of its joined facet
    edges = surface.edges.copy()
    edges[sliver, 1] = 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _, found = with_wide(surface._replace(edges=edges), flat, cell, number)
    np.testing.assert_array_equal(found, np.where(wide == wide.max(), -1, wide))


def test_frames_of_surfaces_change_nothing_and_have_the_force():
    """Loads on the parts of joined facets add up to what the floor bears; bits are the same."""
    alone, shown = start(blocks()), start(blocks(SURFACE))
    while not alone.finished:
        alone.advance()
        shown.advance()
    for name in ("x", "v", "sigma"):
        assert np.array_equal(field(alone, name), field(shown, name))
    contact = shown.rank.contact
    table = contact.known(shown.rank)
    loads, time = contact.loads.taken(table.surface, contact.proximity.labels)
    assert time == pytest.approx(0.3)
    inner = loads[table.surface.body == 1, :3].sum(axis=0)
    base = loads[table.surface.body == 0, :3].sum(axis=0)
    mass = alone.diagnostics()["mass"]
    bears = (inner + base)[2]
    moved = shown.diagnostics()["momentum-z"]
    assert bears - mass * 9.81 * 0.3 == pytest.approx(moved, abs=1e-2 * mass)
    assert np.abs(loads[table.wide >= 0]).max() > 0.0


def test_a_run_goes_on_with_the_facets_that_were_joined():
    """A checkpoint is read in each step: the same bits."""
    whole, other = start(blocks(end=0.1)), start(blocks(end=0.1))
    while not whole.finished:
        whole.advance()
        other.advance()
        contact = other.rank.contact
        search, forces = contact.search, contact.kept_forces
        contact.__init__(other.scene, other.comm)
        contact.assign_fields(other.rank)
        contact.restore_search(search)
        contact.restore_forces(forces)
    for name in ("x", "v", "sigma"):
        assert np.array_equal(field(other, name), field(whole, name))


def test_a_rank_without_candidates_solves_for_nothing():
    """Others have them: what it moves falls freely."""
    sim = start(blocks())
    sim.advance()
    proximity = sim.rank.contact.proximity
    before, time = sim.diagnostics()["momentum-z"], sim.time
    proximity.candidates = proximity.candidates[:0]
    proximity.patches = Patches.of(sim.rank.contact.known(sim.rank).every, proximity.candidates)
    sim.advance()
    after = sim.diagnostics()
    fallen = after["mass"] * 9.81 * (sim.time - time)
    assert before - after["momentum-z"] == pytest.approx(fallen, rel=1e-9)
