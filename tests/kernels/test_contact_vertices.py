"""Rows that velocity fields use, and the list of contact vertices, against plain loops."""

import numpy as np
import pytest
from scenes import box, scene, start
from tiers import wide

from pgimp.decomposition.grid import Grid
from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.fill import FAR, NEAR, _is_near
from pgimp.kernels.data.record import MASS, RECORD
from pgimp.solver.contact.multifield import MultifieldContact

pytestmark = pytest.mark.slow(80)


def heap(D, law="friction", **parts):
    """Squares or cubes that lie close together, each with a velocity of its own."""
    random, bodies = np.random.default_rng(D), {}
    for n in range(16):
        place = np.array([n % 4, n // 4, n % 2][:D])
        low = 2.6 * place + [0.3 + 0.8 * (n // 4 % 2), *[0.3] * (D - 1)]
        speed = random.uniform(-2.0, 2.0, D).tolist()
        bodies[f"g{n}"] = box(low.tolist(), (low + 2.2).tolist(), speed)
    return scene(
        D, bodies, cells=[13, 12, 7][:D], end=0.5, contact=[{"bodies": "all", "law": law}],
        boundaries={"y-min": "unilateral", "x-min": "slip"}, **parts,
    )  # fmt: skip


def watched(case, monkeypatch, look, steps=12):
    """Run some steps of a case, and call `look` with rank and contact in each of its updates."""
    usual = MultifieldContact.update_momentum

    def update_momentum(contact, rank, update):
        usual(contact, rank, update)
        look(rank, contact)

    monkeypatch.setattr(MultifieldContact, "update_momentum", update_momentum)
    sim = start(case)
    for _ in range(steps):
        sim.advance()


def masses(grid, field, values):
    """Masses, or volumes, of active planes: by plane, field, y and z; 0 elsewhere."""
    found = grid.by_vertex(values)[..., MASS].copy()
    found[field.active == 0] = 0.0
    return found


@pytest.mark.parametrize("D", [2, pytest.param(3, marks=pytest.mark.wide)])
def test_unused_rows_are_zero(monkeypatch, D):
    """Of the grid and of the volumes; they are far fewer than all."""
    parts = []

    def look(rank, contact):
        for grid in (rank.grid, contact._volumes.grid):
            records = grid.by_vertex(grid.G)
            if records.shape[1] == 1:
                continue
            rows, each = records.shape[2], (records.shape[2] + 62) // 63
            bits = np.arange(rows) // each
            used = grid.field.used[:-1, :, None] >> bits & 1 != 0
            assert not records[~used].any()
            assert not grid.scratch.any()
            assert not grid.field.used[-1].any()
            parts.append(used.mean())

    watched(heap(D), monkeypatch, look)
    assert len(parts) >= 20
    assert np.mean(parts) < 0.7


@pytest.mark.parametrize("D", [2, wide(3)])
def test_vertices_of_tied_bodies_are_those_of_a_plain_loop(monkeypatch, D):
    """Each pair of fields with mass acts there, whatever the gap."""
    most = []

    def look(rank, contact):
        grid, listed = rank.grid, contact.data.listed
        mass = masses(grid, grid.field, grid.G) > 0.0
        mass &= masses(grid, grid.field, contact.data.volumes) > 0.0
        mass[contact.data.vertex_counts == 0] = False
        count = mass.sum(axis=1)
        i, j, k = np.nonzero(count > 1)
        found = listed.vertices[: listed.found[0]]
        numbers = np.stack([i, j, k], axis=1) + grid.window.lower
        np.testing.assert_array_equal(found["number"], numbers)
        fields = count[i, j, k]
        np.testing.assert_array_equal(found["fields"], fields)
        np.testing.assert_array_equal(found["pairs"], fields * (fields - 1) // 2)
        np.testing.assert_array_equal(np.diff(listed.start), np.bincount(i, minlength=len(mass)))
        most.append(fields.max(initial=0))
        for row in found:
            offsets = listed.fields["offset"][row["first_field"] :][: row["fields"]]
            place = grid.G[offsets + MASS]
            assert (place > 0.0).all()

    watched(heap(D, "tied"), monkeypatch, look)
    assert max(most) >= 3


@kernel
def near_bodies(frame, lower, rigid_bodies, out):
    """Whether any rigid body may be near each vertex of a window, without any shortcut."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            for k in range(out.shape[2]):
                for t in range(len(rigid_bodies.motion)):
                    number = (i + lower[0], j + lower[1], k + lower[2])
                    if _is_near(rigid_bodies, t, frame, number):
                        out[i, j, k] = True


@pytest.mark.parametrize("D", [2, pytest.param(3, marks=pytest.mark.wide)])
def test_vertices_near_rigid_bodies_are_those_of_a_plain_loop(monkeypatch, D):
    """One turns and is inclined to the grid, the other is small."""
    seen = set()
    case = heap(D)
    turning = {"rotation": {"about": [5.0, -1.0, 0.0][:D], "rate": 0.5}}
    if D == 3:
        turning["rotation"]["axis"] = [0.0, 0.0, 1.0]
    low = [-2.0, -3.0, -1.0][:D]
    case["bodies"] |= {
        "floor": {"rigid": turning, "region": {"box": {"min": low, "max": [16.0, 0.3, 9.0][:D]}}},
        "stone": {"rigid": {}, "region": {"ball": {"centre": [6.0, 11.6, 3.0][:D], "radius": 0.9}}},
    }
    del case["boundaries"]["y-min"]

    def look(rank, contact):
        grid, data = rank.grid, contact.data
        expected = np.zeros(data.near.shape, bool)
        near_bodies(contact.scene.domain.frame, grid.window.lower, contact.rigid_bodies, expected)
        some = (masses(grid, grid.field, grid.G) > 0.0).any(axis=1)
        some &= data.near != 0  # those in no body's range are not looked at
        np.testing.assert_array_equal(data.near[some] == NEAR, expected[some])
        away = (masses(grid, grid.field, grid.G) > 0.0).any(axis=1) & (data.near == 0)
        assert not expected[away].any()
        seen.update(np.unique(data.near[some]))

    watched(case, monkeypatch, look)
    assert seen == {FAR, NEAR}


def test_a_grid_that_is_regrouped_is_zero(monkeypatch):
    """It keeps its arrays, and whatever was used is cleared."""
    usual, kept = Grid.regroup, []

    def regroup(grid, fields):
        room = grid._room["G"]
        usual(grid, fields)
        assert not grid.G.any()
        assert len(grid.G) == grid.planes * grid.window.stride[0]
        assert grid.window.stride[0] == RECORD * np.prod(grid.window.extent[1:]) * (1 + max(fields))
        kept.append(grid._room["G"] is room)

    def search_again(rank, contact):
        contact._margin = 0.0

    monkeypatch.setattr(Grid, "regroup", regroup)
    watched(heap(2), monkeypatch, search_again, 40)
    assert any(kept)
