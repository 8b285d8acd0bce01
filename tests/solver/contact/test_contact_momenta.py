"""Momentum and angular momentum of free bodies that meet: what a step may not change, in 3D."""

from unittest import mock

import numpy as np
import pytest
from scenes import box, scene, start

from pgimp.kernels.data.record import FORCE, MASS, MOMENTUM, RECORD, VELOCITY
from pgimp.solver.contact import base


def sums(sim, vectors, active):
    """Sum of vectors at the vertices of all fields, and of their moments about the origin."""
    grid, frame = sim.rank.grid, sim.scene.domain.frame
    window = grid.window
    index = np.stack(np.indices(vectors.shape[:-1]), axis=-1)[..., [0, 2, 3]]
    place = (index + np.array(window.lower) - frame.ghost) * np.array(frame.cell)
    total = vectors[active].reshape(-1, 3).sum(axis=0)
    return total, np.cross(place[active], vectors[active]).reshape(-1, 3).sum(axis=0)


class Momenta:
    """What the momentum update of each step does with momenta, in parts of `scale`."""

    def __init__(self, sim):
        self.sim, self.off = sim, []
        self._update = base.update_momentum

    def update(self, frame, field, faces, forcing, ledger, contact, part):
        grid = self.sim.rank.grid
        fields = 1 + max(grid.fields)
        shape = (grid.planes, fields, *grid.window.extent[1:], RECORD)
        before, active = grid.G.reshape(shape).copy(), grid.active > 0
        self._update(frame, field, faces, forcing, ledger, contact, part)
        after = grid.G.reshape(shape)
        mass = before[..., MASS, None]
        heavy = mass > forcing.mass_cutoff
        given = before[..., MOMENTUM : MOMENTUM + 3]
        given = given + np.where(heavy, forcing.dt * before[..., FORCE : FORCE + 3], 0.0)
        found = np.where(mass > 0.0, mass * after[..., VELOCITY : VELOCITY + 3], 0.0)
        given = np.where(mass > 0.0, given, 0.0)
        pairs = zip(sums(self.sim, found, active), sums(self.sim, given, active), strict=True)
        self.off.append([np.abs(a - b).max() for a, b in pairs])


@pytest.mark.parametrize(
    "law",
    [{"friction": {"static": 0.6, "kinetic": 0.4}}, {"law": "tie"},
     {"friction": 0.3, "adhesion": {"normal": 3.0, "shear": 2.0, "reach": 0.3}}],
)  # fmt: skip
def test_three_bodies_collide_askew(law):
    """Friction, adhesion, ties, two and three bodies at a vertex: both momenta to rounding.

    Of the grid, in each step: what forces do is taken out, and is nothing but rounding itself. What
    particles keep of angular momentum is another thing (docs/contact-validation.md). Their momentum
    is kept.
    """
    turn = {"rotation": {"about": [3.0, 3.0, 3.0], "rate": [0.4, -0.3, 0.5]}}
    bodies = {
        "flies": box([1.5] * 3, [3.5] * 3, turn | {"translation": [2.0, 0.7, -0.3]}),
        "meets": box([4.2, 2.3, 2.3], [6.2, 4.3, 4.3], [-1.0, 0.1, 0.4]),
        "falls": box([2.6, 2.4, 4.4], [5.4, 4.1, 6.0], [0.2, -0.1, -2.0]),
    }
    case = scene(3, bodies, cells=[9, 7, 8], end=0.8, contact=[{"bodies": "all", **law}])
    sim = start(case)
    first, seen = sim.diagnostics(), Momenta(sim)
    with mock.patch.object(base, "update_momentum", seen.update):
        while not sim.finished:
            sim.advance()
    last = sim.diagnostics()
    assert 1 + max(sim.rank.contact.fields) == 3
    assert last["contact.all.tangential-impulse"] > 1.0
    scale = first["mass"]  # times a velocity of 1, at some cells from the origin
    assert np.max(seen.off, axis=0) == pytest.approx([0.0, 0.0], abs=1e-13 * scale)
    for axis in "xyz":
        kept = last[f"momentum-{axis}"] - first[f"momentum-{axis}"]
        assert abs(kept) < 1e-12 * scale
