"""The search for surfaces that may meet: its state is the run's, whatever ranks do meanwhile."""

from functools import partial

import numpy as np
import pytest
from scenes import box, field, scene, start

from pgimp.kernels.contact.surfaces.data import Patches
from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.nearest import APART
from pgimp.solver.contact.surfaces.proximity import TRAVEL

pytestmark = pytest.mark.slow(20)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}

TABLE = {"box": {"min": [0.7, 0.0, 0.7], "max": [4.1, 2.0, 4.3]}}


def corners():
    """Two blocks whose corners meet, askew."""
    bodies = {
        "one": box([1.2, 2.1], [4.6, 5.3], [2.0, 1.5]) | EXACT,
        "other": box([5.1, 5.7], [8.2, 8.1], [-1.0, -1.0]) | EXACT,
    }
    return start(
        scene(2, bodies, cells=[11, 9], step={"courant": 0.3}, end=1.5,
              contact=[{"bodies": "all", "friction": 0.3}])
    )  # fmt: skip


def rolling():
    """Two disks and a block that meet, roll on each other, and part again."""
    disk = {"ball": {"centre": [3.5, 4.2], "radius": 1.7}}
    bodies = {
        "one": box([5.4, 3.3], [8.2, 6.1], [-0.2, 0.1]) | EXACT,
        "other": box([0, 0], [1, 1], [0.2, 0.05]) | EXACT | {"region": disk},
        "third": box([0, 0], [1, 1], [0.1, -0.3]) | EXACT
        | {"region": {"ball": {"centre": [5.3, 7.6], "radius": 1.3}}},
    }  # fmt: skip
    return start(
        scene(2, bodies, cells=[11, 11], step={"courant": 0.3}, end=3.0,
              contact=[{"bodies": "all", "friction": 0.3}])
    )  # fmt: skip


@pytest.mark.parametrize("meet", [corners, rolling])
def test_nothing_depends_on_when_ranks_change(meet):
    """Vertices change ranks, or a checkpoint is read, in any step: the same bits."""
    whole, moved, other = meet(), meet(), meet()
    before = field(whole, "v").copy()
    while not whole.finished:
        for sim in (whole, moved, other):
            sim.advance()
        moved.rank.contact.moved()
        contact = other.rank.contact
        search, forces = contact.search, contact.kept_forces
        contact.__init__(other.scene, other.comm)
        contact.assign_fields(other.rank)
        contact.restore_search(search)
        contact.restore_forces(forces)
    assert len(whole.rank.contact.search) > 5
    assert np.abs(field(whole, "v") - before).max() > 0.1  # they have met
    for sim in (moved, other):
        for name in ("x", "v", "sigma"):
            assert np.array_equal(field(sim, name), field(whole, name))


def corner():
    """A corner hits a disk beside it: a small part of its patches is near."""
    bodies = {
        "box": box([5.3955, 5.9785], [7.9045, 8.8615], [0.553, -3.15]) | EXACT,
        "disk": box([0, 0], [1, 1], [-2.25, 2.28]) | EXACT
        | {"region": {"ball": {"centre": [10.2, 3.15], "radius": 2.3364}}},
    }  # fmt: skip
    return start(
        scene(2, bodies, cells=[15, 10], cell=[0.928, 1.15], per_cell=[2, 3], end=0.5,
              step={"courant": 0.233}, contact=[{"bodies": "all", "friction": 0.3}])
    )  # fmt: skip


def fork(length, width, slot, courant, end, left=3.083, velocity=None, per_cell=2, rough=0.0):
    """A plate bends an arm of a fork: its end turns towards the plate, then it meets the other."""
    height = 2.0 * width + slot
    whole = box([left, 0.0], [left + length, height])["region"]
    gap = box([left + width, width], [12.9, width + slot])["region"]
    plate = box([0.0, height + 0.02], [13.0, height + 1.5])["region"]
    bodies = {
        "fork": box([0, 0], [1, 1]) | EXACT | {"region": {"difference": [whole, gap]}},
        "plate": {"rigid": {"velocity": velocity or [0.0, -2.0]}, "region": plate},
    }
    return start(
        scene(2, bodies, cells=[13, 9], end=end, step={"courant": courant},
              boundaries={"y-min": {"unilateral": {"friction": 0.2}}},
              per_cell=per_cell, contact=[
                  {"bodies": "all", "friction": 0.2},
                  {"bodies": ["fork"], "self": True, "friction": rough}])
    )  # fmt: skip


def side_by_side(usual, other):
    """Steps of two runs, the other of which searches in each: whether the first did, searches."""
    watched = None
    while not usual.finished:
        usual.advance()
        other.rank.contact.proximity.restart()
        other.advance()
        every, now = (sim.rank.contact.proximity for sim in (usual, other))
        yield every._watched is not watched, every, now
        watched = every._watched


@pytest.mark.parametrize(
    ("meet", "most"), [(corner, 0.0), (lambda: fork(7.77, 1.72, 2.32, 0.231, 0.6), 1e-8)]
)
def test_nothing_depends_on_when_the_search_is(meet, most):
    """But for which of two facets beside a place is next to it, where a face has a kink."""
    whole, other = meet(), meet()
    before = field(whole, "v").copy()
    for _ in side_by_side(whole, other):
        pass
    assert np.abs(field(whole, "v") - before).max() > 1.0  # they have met
    np.testing.assert_allclose(field(whole, "x"), field(other, "x"), rtol=0.0, atol=most)


def test_what_turns_is_searched_for_before_it_faces_others():
    """A plate bends an arm of a fork and lifts: what meets it is a candidate when it does.

    An end of the arm turns by a third about a place beside the plate, so it hardly moves.
    """
    size = 7.61, 1.62, 2.15
    lifts = {"table": [[0.0, [0.0, -2.84]], [0.77007, [0.0, -2.84]], [0.92408, [0.0, 2.84]]]}
    make = partial(fork, *size, 0.154, 1.232, 2.786, lifts, per_cell=[3, 2], rough=0.2)
    usual, other = make(), make()
    searches, touched = 0, 0
    for searched, every, now in side_by_side(usual, other):
        searches += searched
        known = set(every.candidates[["facet", "body"]].tolist())
        meet = now.candidates[now.candidates["gap"] < 0.02]
        touched += len(meet)
        assert set(meet[["facet", "body"]].tolist()) <= known
    assert touched > 1000
    assert searches < 60  # of four hundred steps


def test_what_a_floor_squashes_is_hardly_searched_for():
    """A block hits a floor: its cells strain by more than a tenth, but what meets it hardly turns.

    By strains it was searched for in every third step.
    """
    bodies = {"block": box([1.0, 1.0, 0.0], [5.0, 4.0, 4.0], [0.0, 0.0, -2.5]) | EXACT}

    def make():
        return start(scene(3, bodies, cells=[6, 5, 5], step={"courant": 0.3}, end=0.5,
                           boundaries={"z-min": "unilateral"}))  # fmt: skip

    usual, other = make(), make()
    height = np.ptp(field(usual, "x")[:, 2])
    searches, touched, least = 0, 0, height
    for searched, every, now in side_by_side(usual, other):
        searches += searched
        least = min(least, np.ptp(field(usual, "x")[:, 2]))
        patch = usual.rank.contact.known(usual.rank).every.patch
        known = set(patch[every.candidates["facet"]].tolist())
        meet = patch[now.candidates["facet"][now.candidates["gap"] < 0.02]]
        touched += len(meet)
        assert set(meet.tolist()) <= known
    assert touched > 300
    assert least < 0.9 * height
    assert searches <= 3


def test_of_two_patches_of_a_body_the_same_one_always_looks():
    """A facet that slides on to what does not meet it would find nothing there from then on."""
    sim, met = fork(6.95, 1.54, 2.31, 0.272, 1.3), 0
    while not sim.finished:
        sim.advance()
        surface, every = sim.rank.contact._table.every, sim.rank.contact.proximity.candidates
        own = every[every["body"] == surface.body[every["facet"]]]
        met += int((own["gap"] < 0.01).sum())
        assert (surface.patch[own["facet"]] < surface.patch[own["other"]]).all()
        way = surface.x[own["facet"]] - surface.x[own["other"]]
        assert (np.linalg.norm(way, axis=1) > APART).all()
    assert met > 100


def test_patches_that_rest_are_too_far_to_act():
    """In each step all gaps are found, as if no patch rested: those of such ones are wide."""
    sim = rolling()
    contact = sim.rank.contact
    proximity, found = contact.proximity, []

    def looked(laws, table, u, values, dt):
        every, cells = proximity.candidates.copy(), proximity.share.cells
        surface = table.surface._replace(
            now=np.full_like(table.surface.now, np.inf), turned=table.surface.turned.copy()
        )
        frame, rigid = sim.scene.domain.frame, contact.rigid_bodies
        move_facets(frame, rigid, surface, cells, u, proximity.share.moving, proximity.scratch)
        find_gaps(frame, laws, contact._walls, surface, (cells, u), proximity.scratch,
                  proximity.far, (every, Patches.of(surface, every, -1.0)))  # fmt: skip
        patches = awake(laws, table, u, values, dt)
        found.append((every["gap"], patches, dt * np.abs(values[:, :3]).max()))
        return patches

    awake, proximity.awake = proximity.awake, looked
    acting, resting, near = 0, 0, 0
    while not sim.finished:
        found.clear()
        sim.advance()
        for gaps, patches, way in found:
            for g in range(len(patches.start) - 1):
                some = slice(patches.start[g], patches.start[g + 1])
                gap = gaps[some].min()
                if g in patches.awake:
                    acting += np.isfinite(proximity.candidates["gap"][some]).any()
                else:
                    assert gap > 1e-3 + way
                    resting, near = resting + 1, near + (gap < 0.4)
    assert acting > 50 and resting > 200 and near > 100


@pytest.mark.parametrize(("gap", "weight"), [(0.1, 25.0), (0.7, 10.0)])
@pytest.mark.parametrize("since", [0.08, 0.2, 0.3])
def test_what_is_at_rest_may_be_pushed_at_once(gap, weight, since):
    """A block near another falls as soon as there is weight, and lands on it."""
    bodies = {
        "table": box([1.2, 0.0], [6.6, 2.03]) | EXACT,
        "rests": box([2.1, 2.03 + gap], [5.2, 4.1 + gap]) | EXACT,
    }
    none, all_of_it = [0.0, 0.0], [0.0, -weight]
    weights = [[0.0, none], [since, none], [since + 1e-4, all_of_it]]
    case = scene(2, bodies, cells=[9, 6], step={"courant": 0.3}, end=since + 0.6,
                 gravity={"table": weights}, boundaries={"y-min": "fixed"},
                 contact=[{"bodies": "all", "friction": 0.3}])  # fmt: skip
    sim, deepest = start(case), 0.0
    while not sim.finished:
        sim.advance()
        deepest = min(deepest, sim.rank.contact.proximity.candidates["gap"].min(initial=0.0))
    line = sim.diagnostics()
    assert line["contact.all.normal-impulse"] > 0.0
    assert -0.05 < deepest < 0.0


def test_a_body_that_a_stage_removes_holds_nothing():
    """What lay on it falls freely."""
    bodies = {
        "table": box([1.2, 0.0], [6.6, 2.03]) | EXACT,
        "rests": box([2.1, 2.03], [5.2, 4.1]) | EXACT,
    }
    case = scene(2, bodies, cells=[9, 6], step={"courant": 0.3}, end=0.5, gravity=[0.0, -1.0],
                 boundaries={"y-min": "fixed"}, contact=[{"bodies": "all"}])  # fmt: skip
    case["time"]["stages"] = [{"name": "gone", "end": 0.8, "remove": ["table"]}]
    sim, begun = start(case), None
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        if line["time"] <= 0.5:
            begun = line
    weight, fell = begun["body.rests.mass"], line["body.rests.momentum-y"]
    assert begun["body.rests.momentum-y"] > -0.4 * weight  # the table bears it
    assert begun["contact.all.normal-impulse"] > 0.0
    np.testing.assert_allclose(fell - begun["body.rests.momentum-y"], -0.3 * weight, rtol=1e-9)
    assert line["contact.all.normal-impulse"] == begun["contact.all.normal-impulse"]


def flying():
    """Two disks that fly side by side and meet, and one that they overtake; and a rigid wheel."""
    bodies = {
        name: box([0, 0], [1, 1], v) | EXACT | {"region": {"ball": {"centre": x, "radius": 1.1}}}
        for name, x, v in (
            ("one", [3.1, 3.0], [1.0, 0.05]), ("other", [3.4, 5.6], [1.0, -0.05]),
            ("third", [7.4, 4.4], [0.6, 0.0]),
        )
    }  # fmt: skip
    wheel = {"rotation": {"about": [3.2, 9.1], "rate": -0.1}, "velocity": [0.9, 0.0]}
    bodies["wheel"] = {"rigid": wheel, "region": {"ball": {"centre": [3.2, 9.1], "radius": 2.1}}}
    return start(
        scene(2, bodies, cells=[22, 12], step={"courant": 0.3}, end=6.0,
              contact=[{"bodies": "all", "friction": 0.3}])
    )  # fmt: skip


def test_what_flies_together_is_not_searched_for():
    """All facets that are near each other are known in each step, of few searches."""
    sim = flying()
    contact = sim.rank.contact
    proximity, last, searches, near = contact.proximity, None, 0, 0
    while not sim.finished:
        sim.advance()
        searches, last = searches + (proximity.facets is not last), proximity.facets
        table, every = contact.known(sim.rank), proximity.candidates
        surface = table.surface._replace(now=table.surface.now.copy())
        u = proximity.all_displacements(sim.rank, table)
        frame, some = sim.scene.domain.frame, np.arange(len(surface.x))
        move_facets(frame, contact.rigid_bodies, surface, table.cells, u, some, proximity.scratch)
        x, n, body = surface.now, surface.turned, surface.body
        away = np.linalg.norm(x[:, None] - x[None], axis=2)
        meets = (away < 0.45) & (n @ n.T < -0.5) & (contact.acts[body][:, body] != 0)
        known = set(zip(every["facet"].tolist(), every["body"].tolist(), strict=True))
        s, f = np.nonzero(meets)
        assert known.issuperset(zip(s.tolist(), body[f].tolist(), strict=True))
        near += len(s)
    assert near > 1000
    assert searches < 0.5 * 6.0 / TRAVEL  # of 6 cells of flight


def test_what_tilts_is_searched_for_before_joined_facets_miss_it():
    """A block tips over the edge of a table: facets are joined while both lie on each other.

    They are where normals differ by .01 at a search, until they do by .015. Without that bound they
    differ by .03.
    """
    bodies = {
        "table": {"rigid": {"velocity": [0.0] * 3}, "region": TABLE},
        "block": box([2.1, 2.0, 1.2], [8.4, 4.0, 3.9]) | EXACT,
    }
    sim = start(
        scene(3, bodies, cells=[12, 8, 6], step={"courant": 0.3}, end=4.0,
              gravity=[0.0, -2.0, 0.0], contact=[{"bodies": "all", "friction": 0.5}])
    )  # fmt: skip
    greatest, joined = 0.0, 0
    while not sim.finished:
        sim.advance()
        contact = sim.rank.contact
        every, turned = contact.proximity.candidates, contact._table.every.turned
        wide = (every["facet"] >= len(contact._table.wide)) & (every["gap"] < 0.3)
        some = every[wide & (every["other"] >= 0)]
        same = -(turned[some["facet"]] * turned[some["other"]]).sum(axis=1)
        joined += len(some)
        greatest = max(greatest, np.arccos(same.clip(-1.0, 1.0)).max(initial=0.0))
    assert joined > 100
    assert greatest < 0.025
