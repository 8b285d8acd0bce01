"""Probes: against exact solutions and the frames. On any ranks: test_balance.py, test_ranks.py."""

from pathlib import Path

import numpy as np
import pytest
from probed import run
from rank_scenes import PROBES, plane_leaves
from scenes import box, finish, scene, start

import pgimp
from pgimp.solver.state.probes import nearest

CASES = Path(__file__).parents[2] / "cases"


FIELDS = ["velocity", "stress", "displacement", "strain", "pressure", "von-mises", "density"]


def test_the_tip_of_the_bar(tmp_path):
    """The probe swings as the exact solution says; see the comments in the case."""
    probe = "probes={tip: {body: bar, at: [1.0], every: {steps: 5}}}"
    result = pgimp.run(
        CASES / "bar-vibration.yaml", output=tmp_path, quiet=True, overrides=[probe, "time.end=0.6"]
    )
    tip = result.probes["tip"]
    assert tip["step"].tolist() == list(range(0, 3001, 5))
    assert tip["position-x"][0] == 0.995  # the lowest particle
    phase, g, T = np.mod(tip["time"], 0.2), 9.81, 0.2
    sag = g / 400.0
    exact = np.where(phase < T / 4, g * phase**2 / 2, sag - g * (phase - T / 2) ** 2 / 2)
    exact = np.where(phase > 3 * T / 4, g * (T - phase) ** 2 / 2, exact)
    assert np.abs(tip["displacement-x"] - exact).max() < 0.21e-3
    assert np.ptp(exact) > 0.024
    np.testing.assert_allclose(tip["displacement-x"], tip["position-x"] - 0.995, rtol=0, atol=1e-15)
    # And it is the particle of that id in the frames.
    frames = result.follow(99)
    rows = np.searchsorted(tip["step"], frames["step"])
    for name in ("displacement", "velocity"):
        assert np.array_equal(tip[f"{name}-x"][rows], frames[name][:, 0])
    assert np.array_equal(tip["stress-xx"][rows], frames["stress"][:, 0])


@pytest.fixture(scope="module")
def leaves(tmp_path_factory):
    """A run on one rank, in which two of the bodies leave the domain, with frames at all lines."""
    folder = tmp_path_factory.mktemp("probes")
    case = plane_leaves() | {"probes": PROBES}
    case["output"] = {"every": {"steps": 1}, "fields": FIELDS}
    return run(folder, case)


def columns(frame, row):
    """What a frame holds of a particle, by the names that a probe has for it in 2D."""
    names = {}
    for field, parts in (("position", "x y"), ("displacement", "x y"), ("velocity", "x y"),
                         ("stress", "xx yy zz xy"), ("strain", "xx yy . xy")):  # fmt: skip
        for i, part in enumerate(parts.split()):
            names[f"{field}-{part}"] = frame[field][row, i]
    names.pop("strain-.")
    return names | {
        name: frame[name][row] for name in ("pressure", "von-mises", "density", "volume")
    }


@pytest.mark.parametrize("name", ["corner", "down"])
def test_a_point_is_a_particle_of_the_frames_until_it_leaves(leaves, name):
    first, probe = leaves.frame(0), leaves.probes[name]
    mine = np.flatnonzero(first["body"] == first.bodies.index(PROBES[name]["body"]))
    away = ((first["position"][mine, :2] - PROBES[name]["at"]) ** 2).sum(axis=1)
    number = mine[np.flatnonzero(away == away.min())[0]]
    frames = {frame.step: frame for frame in leaves}
    assert (away == away.min()).sum() == {"corner": 4, "down": 1}[name]
    seen = 0
    for line in probe:
        frame = frames[int(line["step"])]
        rows = np.flatnonzero(frame["id"] == number)
        if len(rows):
            seen += 1
            wanted = columns(frame, rows[0])
            assert set(wanted) | {"time", "step"} == set(probe.dtype.names)
            assert all(line[key] == value for key, value in wanted.items())
        else:
            assert np.isnan([line[key] for key in probe.dtype.names[2:]]).all()
    assert 2 < seen < len(probe)  # and then it left; "down" is on the edge at the fourth line
    if name == "down":
        times = 0.08 * np.arange(16)
        step = leaves.history["dt"].max()
        assert ((probe["time"] >= times - 1e-9) & (probe["time"] <= times + step)).all()
    else:
        assert np.array_equal(probe["step"], leaves.history["step"])


@pytest.mark.parametrize("name", ["gate", "floor"])
def test_a_place_is_the_mean_of_what_is_there(leaves, name):
    """The sums once more, in plain NumPy over all particles of the frame."""
    probe, frames = leaves.probes[name], {frame.step: frame for frame in leaves}
    filled = 0
    for line in probe:
        frame = frames[int(line["step"])]
        away = np.abs(frame["position"][:, :2] - PROBES[name]["place"])
        volume = np.maximum(0.0, 1.0 - away).prod(axis=1) * frame["volume"]
        mass = volume * frame["density"]
        assert line["volume-fraction"] == pytest.approx(volume.sum(), rel=1e-12, abs=1e-15)
        values = [line[key] for key in probe.dtype.names[3:]]
        if volume.sum() < 0.25:
            assert np.isnan(values).all()
            continue
        filled += 1
        velocity = mass @ frame["velocity"] / mass.sum()
        stress = volume @ frame["stress"] / volume.sum()
        xx, yy, zz, xy = stress[:4]
        mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)
        wanted = [mass.sum() / volume.sum(), *velocity[:2], *stress[:4], -(xx + yy + zz) / 3, mises]
        np.testing.assert_allclose(values, wanted, rtol=1e-9, atol=1e-9)
    assert 5 < filled < len(probe)


def test_of_equally_close_particles_the_lowest_id():
    sim = start(scene(2, box([1.0, 1.0], [3.0, 3.0])))
    assert nearest(sim, 0, [1.5, 1.5]).number == 0
    p, rows = sim.particles, sim.live()
    ids = p.id[rows[np.abs(p.x[rows] - 2.0).max(axis=1) < 0.3]]
    assert len(ids) == 4 and nearest(sim, 0, [2.0, 2.0]).number == ids.min()


# Reactions


def test_the_floor_bears_the_weight_of_a_block():
    """At rest, up to what the relaxation has left of the oscillation."""
    case = scene(
        2,
        box([1.0, 0.0], [3.0, 2.0]),
        cells=[4, 4],
        end=20.0,
        step=0.02,
        gravity=[0.0, -0.5],
        boundaries={"y-min": "slip"},
    )
    case["method"]["pic-damping"] = 4.0
    sim = start(case)
    sim.diagnostics()
    while sim.time < 19.0:
        sim.advance()
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert line["reaction.y-min-y"] == pytest.approx(0.5 * line["mass"], rel=2e-5)
    assert line["reaction.y-min-x"] == pytest.approx(0.0, abs=1e-9)
    assert line["kinetic-energy"] < 1e-9


def test_a_constraint_bears_the_weight_that_hangs_from_it():
    """A block held at its top: the constraint's force is the weight, and it does no work."""
    held = {"box": {"min": [1.0, 2.0], "max": [3.0, 3.0]}}
    case = scene(
        2,
        box([1.0, 1.0], [3.0, 3.0]),
        cells=[4, 4],
        end=20.0,
        step=0.02,
        gravity=[0.0, -0.5],
        constraints={"top": {"body": "body", "region": held, "velocity": [0.0, 0.0]}},
    )
    case["method"]["pic-damping"] = 4.0
    sim = start(case)
    sim.diagnostics()
    while sim.time < 19.0:
        sim.advance()
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert line["constraint.top-y"] == pytest.approx(0.5 * line["mass"], rel=1e-6)
    assert line["constraint.top-x"] == pytest.approx(0.0, abs=1e-9)


def test_the_bodies_add_up_to_the_whole(leaves):
    """Mass and momentum of each body; once one has left there is none of it."""
    lines, names = leaves.history, leaves.frame(0).bodies
    for column in ("mass", "momentum-x", "momentum-y", "kinetic-energy", "strain-energy"):
        parts = np.sum([lines[f"body.{name}.{column}"] for name in names], axis=0)
        np.testing.assert_allclose(parts, lines[column], rtol=1e-12, atol=1e-12)
    assert lines["body.corner.mass"][0] == pytest.approx(4.0, rel=1e-14)
    assert lines["body.corner.momentum-x"][0] == pytest.approx(20.0, rel=1e-12)
    assert lines["body.corner.mass"][-1] == lines["body.corner.momentum-x"][-1] == 0.0
