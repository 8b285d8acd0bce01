"""Surfaces that loads follow where F has drifted from the positions, or stretches are large."""

from types import SimpleNamespace

import numpy as np
import pytest
from scenes import box, field, scene, start
from tiers import wide

from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.mpi.comm import Serial
from pgimp.running.checkpoints import Checkpoints
from pgimp.running.summary import say_done
from pgimp.solver.simulation import Simulation

pytestmark = pytest.mark.slow(60)

EVERYWHERE = {"box": {"min": [-99.0] * 3, "max": [99.0] * 3}}
A = np.array([[1.3, 0.4, -0.2], [-0.3, 0.8, 0.1], [0.2, 0.3, 1.1]])


def loaded(D, region, pressure=1.0, **parts):
    """A body of a region under pressure all around, or in a `load` region."""
    everywhere = {"box": {name: ends[:D] for name, ends in EVERYWHERE["box"].items()}}
    load = {"body": "body", "region": parts.pop("load", everywhere), "pressure": pressure}
    body = {"material": "soft", "region": region, **parts.pop("body", {})}
    parts = {"cells": [7] * D, "end": 0.05, "step": 0.001} | parts
    return scene(D, body, tractions={"load": load}, **parts)


@pytest.mark.parametrize(
    ("D", "parts"),
    [
        (2, {}),
        wide(2, {"shape": "mpm"}),
        wide(2, {"shape": "cpdi"}),
        (2, {"geometry": "plane-stress"}),
        (2, {"geometry": "axisymmetric", "boundaries": {"x-min": "slip"}}),
        wide(3, {}),
    ],
    ids=lambda each: "-".join(map(str, each.values())) if isinstance(each, dict) else str(each),
)
def test_a_linear_displacement_is_found_up_to_free_surfaces(D, parts):
    """Of a ball, whatever F the particles have; that of rings is along the radius and the axis."""
    ring = parts.get("geometry") == "axisymmetric"
    centre = [0.0, 3.4] if ring else [3.3, 3.4, 3.6][:D]
    sim = start(loaded(D, {"ball": {"center": centre, "radius": 2.3}}, **parts))
    p, rank, rows = sim.particles, sim.rank, sim.live()
    exact = np.diag([1.3, 0.8]) if ring else A[:D, :D]
    p.place[rows] = (p.x[rows] - centre) @ np.linalg.inv(exact).T + centre
    for _ in range(60):
        rank.surface_kinematics.begin(rank, rank.population.ordered, 0)
    R = p.surface_F_correction[rows]
    found = R[:, : D * D].reshape(-1, D, D)  # F is 1
    np.testing.assert_allclose(found, np.broadcast_to(exact, found.shape), atol=1e-4)
    if R.shape[1] > D * D:
        np.testing.assert_allclose(R[:, D * D], 1.3 if ring else 1.0, rtol=1e-12)


def test_a_surface_that_falls_back_on_F_is_told(tmp_path):
    """Particles whose neighbours have gone astray; only those at the surface count."""
    ball = {"ball": {"center": [3.3, 3.4], "radius": 2.3}}
    sim = start(loaded(2, ball))
    p, rank, rows = sim.particles, sim.rank, sim.live()
    rank.surface_kinematics.begin(rank, rank.population.ordered, 0)
    assert rank.surface_kinematics.fallbacks == 0
    p.place[rows] = -p.place[rows[::-1]]  # inside out
    for _ in range(3):
        rank.surface_kinematics.begin(rank, rank.population.ordered, 0)
    loaded_ones = (p.surface[rows] != 0.0).any(axis=1).sum()
    assert 0 < rank.surface_kinematics.fallbacks <= 3 * 8 * loaded_ones < 3 * 8 * len(rows)
    while not sim.finished:
        sim.advance()
    said = []
    log = SimpleNamespace(say=said.append, note=said.append)
    recorder = SimpleNamespace(seconds={}, size=0, frames=SimpleNamespace(written=1))
    say_done(sim, 0, recorder, SimpleNamespace(path=tmp_path), log, 1.0)
    assert any("the load followed F of the particle alone" in line for line in said)


def test_how_often_a_surface_falls_back_on_F_is_in_checkpoints(tmp_path):
    """A run that goes on tells the number of the whole run."""
    sim = start(loaded(2, {"ball": {"center": [3.3, 3.4], "radius": 2.3}}))
    sim.advance()
    sim.rank.surface_kinematics.fallbacks = 24
    (tmp_path / "checkpoints").mkdir()
    Checkpoints(tmp_path, sim.case, sim).write(sim, 0, 0)
    (path,) = (tmp_path / "checkpoints").iterdir()
    gone_on = Simulation(sim.case, Serial(), CheckpointFile(path))
    assert gone_on.step == sim.step
    assert gone_on.rank.surface_kinematics.fallbacks == 24


def test_only_loads_that_follow_surfaces_pay_for_it():
    ball = {"ball": {"center": [3.3, 3.4], "radius": 2.3}}
    case = loaded(2, ball)
    case["tractions"]["load"]["follower"] = False
    for each in (case, loaded(2, ball, body={"formulation": "total-lagrangian"})):
        sim = start(each)
        assert sim.rank.surface_kinematics is None
        assert sim.particles.place.size == sim.particles.surface_F_correction.size == 0


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_tube_widens_by_half_as_shooting_says(configuration):
    """A neo-Hookean quarter with 8 cells to the bore; exact values: scripts/studies/loads/tube.py.

    By F of the particles alone the bore would widen by 9 % less.
    """
    whole = {"intersection": [{"ball": {"center": [0.0, 0.0], "radius": 16.0}},
                              box([0.0, 0.0], [28.0, 28.0])["region"]]}  # fmt: skip
    tube = {"difference": [whole, {"ball": {"center": [0.0, 0.0], "radius": 8.0}}]}
    case = loaded(
        2, tube, 15.0, load={"ball": {"center": [0.0, 0.0], "radius": 12.0}}, cells=[28, 28],
        step={"courant": 0.3}, body={"formulation": configuration},
        boundaries={"x-min": "slip", "y-min": "slip"},
        start={"equilibrate": {"tolerance": 1e-3, "steps": 5000}},
    )  # fmt: skip
    sim = start(case)
    X = field(sim, "x")
    while sim.settling:
        sim.advance()
    R, r = np.hypot(*X.T), np.hypot(*field(sim, "x").T)
    near = (R > 8.0) & (R < 9.0)
    exact = np.interp(R, [8.0, 8.5, 9.0], [3.84612, 3.70906, 3.58441])
    assert (r - R)[near].mean() == pytest.approx(exact[near].mean(), rel=0.025)
