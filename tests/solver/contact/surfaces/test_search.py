"""The search for surfaces that may meet: its state is the run's, whatever ranks do meanwhile."""

import numpy as np
import pytest
from scenes import box, field, scene, start

from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.motion import move_facets

pytestmark = pytest.mark.slow(20)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}


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


def test_nothing_depends_on_when_ranks_change():
    """Vertices change ranks, or a checkpoint is read, in any step: the same bits."""
    whole, moved, other = corners(), corners(), corners()
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
    assert np.abs(field(whole, "v")[:, 1] - 1.5).max() > 1.0  # they have met
    for sim in (moved, other):
        for name in ("x", "v", "sigma"):
            assert np.array_equal(field(sim, name), field(whole, name))


def test_patches_without_gaps_are_too_far_to_act():
    """What is not looked at has no gap at which its law acts; the others have the same ones."""
    sim = corners()
    contact, frame, acting, left = sim.rank.contact, sim.scene.domain.frame, 0, 0
    while not sim.finished:
        sim.advance()
        proximity, table = contact.proximity, contact.known(sim.rank)
        share, surface, call = proximity.share, table.surface, contact.call
        if proximity.near is None or not len(proximity.candidates):
            continue
        u = np.zeros((len(share.keys), 4))
        u[share.place] = sim.rank.grid.kept.values.reshape(-1, 8)[share.records, 1:5]
        call(move_facets, frame, contact.rigid_bodies, surface, share.cells, u, share.moving,
             proximity.scratch)  # fmt: skip
        gaps, travels = [], contact._travels(1.0, sim.now.dt)
        for ways in (np.full(len(travels), -1.0), travels):
            every = proximity.candidates.copy()
            call(find_gaps, frame, contact.laws, contact._walls, surface, (share.cells, u),
                 proximity.scratch, (proximity.far, False, ways), every)  # fmt: skip
            gaps.append(every["gap"].copy())
        patch, near = surface.patch[every["facet"]], 4.0 * travels.max() + 1e-3
        for one in np.unique(patch):
            whole, looked = (gap[patch == one] for gap in gaps)
            if np.isfinite(looked).any():
                assert np.array_equal(whole, looked)
                acting += 1
            else:
                assert whole.min() > near
                left += np.isfinite(whole).any()
    assert acting > 10 and left > 10


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
