"""Sums of what fills space, and its volume on the grid, against NumPy."""

import numpy as np
import pytest
from tank import tank

from pgimp.kernels.data.record import RECORD
from pgimp.kernels.flows.filling import EXCESS, FIELD
from pgimp.solver.flows import EVERY
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.time.clock import Step


def filling(sim):
    """EXCESS and FIELD of the vertices of the domain's grid, in the order of y, x."""
    rank = sim.rank
    order = groups_of(rank)[0].order
    found = rank.flows.find(rank, order, Step(EVERY, 0.0, 0.01, 0.01))
    (i, j, _), extent = rank.grid.window.lower, rank.grid.window.extent
    G = found.G.reshape(rank.grid.planes, extent[1], RECORD)
    ghost = rank.scene.domain.frame.ghost
    return {
        (x + i - ghost, y + j - ghost): (G[x, y, EXCESS], G[x, y, FIELD])
        for x in range(rank.grid.planes)
        for y in range(extent[1])
        if rank.grid.field.active[x] or found.G[x]
    }


def tents(x, vertex, half=0.25):
    """Mean of a vertex's tent over a particle's box, by its integral."""

    def whole(s):
        s = np.clip(s, -1.0, 1.0)
        return s - 0.5 * s * abs(s)

    return (whole(x + half - vertex) - whole(x - half - vertex)) / (2.0 * half)


def test_what_is_too_much_is_that_of_plain_sums():
    """Of particles at random places: volumes by tents, over the part within the walls."""
    sim = tank()
    rank, rows = sim.rank, sim.rank.live()
    p, rng = rank.up_to_date(), np.random.default_rng(3)
    sim.advance()
    p.x[rows] += rng.uniform(-0.2, 0.2, p.x[rows].shape) * (np.abs(p.x[rows] - 4.0) < 3.0)
    found = filling(sim)
    x, V = p.x[rows], p.V0[rows] * p.F[rows, 0] ** 2
    for i, j in ((0, 0), (0, 3), (3, 0), (2, 2), (4, 5), (8, 4), (5, 7), (4, 8)):
        total = (V * tents(x[:, 0], i) * tents(x[:, 1], j)).sum()
        part = (0.5 if i in (0, 8) else 1.0) * (0.5 if j == 0 else 1.0)
        # Particles beside a wall do not reach beyond it here.
        assert found[i, j][0] == pytest.approx(max(total / part - 1.0, 0.0), abs=1e-12)


def test_a_linear_pressure_is_left_as_it_is():
    """J that is linear in space is that of the vertices, at the walls and at the surface, too."""
    sim = tank()
    rank, rows = sim.rank, sim.rank.live()
    p = rank.up_to_date()
    sim.advance()  # the window is that of a step
    p.slope[rows] = 1e-4, 3e-4
    x = p.x[rows]
    p.F[rows, 0] = p.F[rows, 3] = np.sqrt(0.99 + 1e-4 * x[:, 0] + 3e-4 * x[:, 1])
    for (i, j), (_, field) in filling(sim).items():
        if 0 <= i <= 8 and 0 <= j <= 8:
            assert field == pytest.approx(0.99 + 1e-4 * i + 3e-4 * j, abs=1e-12)


def test_the_volume_on_the_grid_is_what_vertices_have_room_for():
    """Of crowded particles: the sum over the vertices, by tents; the warning names the liquid."""
    sim = tank(gravity=[0.0, 0.0])
    p, rows, rng = sim.rank.up_to_date(), sim.rank.live(), np.random.default_rng(5)
    p.x[rows, 1] = 4.0 + 0.9 * (p.x[rows, 1] - 4.0)
    p.x[rows] += rng.uniform(-0.2, 0.2, p.x[rows].shape) * (np.abs(p.x[rows] - 4.0) < 3.0)
    x, room = p.x[rows].copy(), 0.0
    for i in range(9):
        for j in range(9):
            part = (0.5 if i in (0, 8) else 1.0) * (0.5 if j == 0 else 1.0)
            volume = 0.25 * (tents(x[:, 0], i) * tents(x[:, 1], j)).sum()
            room += min(volume, part)
    assert np.isnan(sim.diagnostics()["volume.water"])
    for _ in range(EVERY):  # at rest without stress, until they are shifted
        sim.advance()
    line = sim.diagnostics()
    assert line["volume.water.particles"] == pytest.approx(64.0, rel=1e-13)
    assert line["volume.water"] == pytest.approx(room, rel=1e-12)
    assert any("'water', which flows, fills" in said for said in sim.diagnostic_sums.said)
