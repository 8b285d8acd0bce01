"""Selections that last for several steps: no bit of the results depends on how long they do."""

import numpy as np
import pytest
from scenes import SOFT, scene, start
from tiers import wide

from pgimp.kernels.contact.lagrangian.travel import greatest_travel
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.solver.contact.lagrangian.broad_phase import BroadPhase
from pgimp.solver.contact.lagrangian.lagrangian import LagrangianContact
from pgimp.solver.contact.lagrangian.selection import Selector


def meeting(shape="gimp"):
    """Bodies meet each other, a rigid ball that comes in, and a wall."""
    flies = {"material": "soft", "configuration": "initial", "surface": "whole"}
    bodies = {
        "a": flies | {"velocity": [4.0, -1.0],
                      "region": {"ball": {"centre": [3.1, 2.4], "radius": 2.0}}},
        "b": flies | {"velocity": [-3.0, 0.5],
                      "region": {"box": {"min": [6.0, 0.0], "max": [9.0, 3.0]}}},
        "ball": {"rigid": {"velocity": [0.5, -3.0]},
                 "region": {"ball": {"centre": [5.5, 6.4], "radius": 1.5}}},
    }  # fmt: skip
    case = scene(2, bodies, cells=[12, 9], end=3.0, step={"courant": 0.3},
                 materials={"soft": SOFT | {"young": 1000.0}}, gravity=[0.0, -1.0],
                 boundaries={"y-min": {"separating": {"friction": 0.2}}},
                 contact=[{"bodies": "all", "friction": 0.3}])  # fmt: skip
    case["method"]["shape"] = shape
    return start(case)


@pytest.mark.parametrize("shape", ["gimp", wide("cpdi")])
def test_bits_are_those_of_selections_in_every_step(shape, monkeypatch):
    """Of all vertices that groups share, however little of them they fill."""
    selections = []
    select = Selector.select

    def count(self, *args):
        selections.append(0)
        return select(self, *args)

    monkeypatch.setattr(Selector, "select", count)
    kept = meeting(shape)
    for _ in range(100):
        kept.advance()
    kept_selections = len(selections)
    monkeypatch.setattr(Selector, "lasts", lambda *_: False)
    monkeypatch.setattr(BroadPhase, "_lasts", lambda *_: False)
    monkeypatch.setattr(
        Selector, "_possible", lambda self, t, m, patches, *_: np.argsort(patches.keys)
    )
    anew = meeting(shape)
    for _ in range(100):
        anew.advance()
    assert kept_selections < (len(selections) - kept_selections) / 3
    for name in ("x", "v", "F", "sigma"):
        one, other = (getattr(sim.particles, name)[sim.live()] for sim in (kept, anew))
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(kept.rank.ledger.contact, anew.rank.ledger.contact)


def test_sums_are_those_of_all_particles_of_a_group(monkeypatch):
    """Of all near particles, by loops over them; so nothing within reach is left out."""
    find, kept = LagrangianContact._find, []

    def look(self, near, t):
        found = find(self, near, t)
        kept[:] = [near, found]
        return found

    monkeypatch.setattr(LagrangianContact, "_find", look)
    sim = meeting()
    while not kept or len(kept[1][0].ends) < 5:
        sim.advance()
    near, _ = kept
    selection, contact_vertices = near.selection, near.selection.contact_vertices
    table, motion, now = selection.table, near.motion, near.now
    S = np.einsum("ia,ib->iab", now.w[:, 0, :3], now.w[:, 1, :3])
    low, extent = contact_vertices.low, contact_vertices.extent
    for n, key in enumerate(contact_vertices.keys.tolist()):
        vertex, group = divmod(key, contact_vertices.groups)
        number = np.array(np.unravel_index(vertex, extent)) + low
        at = number[:2] - now.first[:, :2]
        mine = (table["group"] == group) & ((at >= 0) & (at < 3)).all(axis=1)
        weight = S[mine, at[mine, 0], at[mine, 1]]
        sums = contact_vertices.sums[n]
        assert sums["mass"] == pytest.approx((table["mass"][mine] * weight).sum(), abs=1e-14)
        offset = motion["position"][mine, :2] - (number[:2] - sim.scene.domain.frame.ghost)
        moment = ((table["mass"][mine] * weight)[:, None] * offset).sum(axis=0)
        assert sums["mass_offset"][:2] == pytest.approx(moment, abs=1e-13)


def test_travel_is_the_greatest_displacement_of_the_vertices():
    sim = meeting()
    while sim.rank.contact._selection is None:
        sim.advance()
    selector, grid = sim.rank.contact._selector, sim.rank.grid
    tracked, values = selector._tracked, grid.kept.values
    for n in range(len(tracked.records)):
        at = tracked.records[n] + DISPLACEMENT
        tracked.before[n] = values[at : at + 3]
    assert len(np.unique(tracked.records)) == len(tracked.records) > 50
    assert greatest_travel(sim.scene.domain.frame, grid.field, tracked) == 0.0
    values[tracked.records[7] + DISPLACEMENT + 1] -= 0.25
    assert greatest_travel(sim.scene.domain.frame, grid.field, tracked) == pytest.approx(0.25)
    assert selector.lasts(grid, 0.0) == (selector._slack >= 0.25)
