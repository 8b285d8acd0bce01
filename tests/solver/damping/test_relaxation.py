"""Dynamic relaxation: rest in few steps, without overshoot, and what is told without rest."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from scenes import box, finish, scene, start
from tiers import wide

import pgimp
from pgimp.errors import NoRestError
from pgimp.solver.damping import relaxation

pytestmark = pytest.mark.slow(40)

#: Height of the bar, and the part of the stable step that settling takes.
HEIGHT, PART = 16.0, 0.9


def bar(configuration="initial", step=0.5, tolerance=1e-4, **parts):
    """A bar of weight 16, held below; waves cross 10 cells in a unit of time."""
    body = box([0.0], [HEIGHT]) | {"formulation": configuration}
    step = step if isinstance(step, float) and step < 0.1 else {"courant": step}
    parts = {"start": {"equilibrate": {"tolerance": tolerance}}, "end": 0.19} | parts
    case = scene(1, body, cells=[20], step=step, gravity=[-1e-2], boundaries={"x-min": "fixed"},
                 **parts)  # fmt: skip
    case["materials"]["soft"]["young"] = 1e2
    return case


def settled(sim):
    """Let a simulation settle; the longest step, and the greatest compression on the way."""
    dt, most = 0.0, 0.0
    while sim.settling:
        sim.advance()
        dt, most = max(dt, sim.dt), max(most, -float(sim.particles.sigma[sim.live(), 0].min()))
    return dt or 1.0, most


def errors(sim):
    """Errors of the stress, by cell, of a bar at rest."""
    rows = sim.live()
    x, sigma = sim.particles.x[rows, 0], sim.particles.sigma[rows, 0]
    return (sigma + 1e-2 * (HEIGHT - x)).reshape(-1, 2).mean(axis=1)


@pytest.mark.parametrize("step", [0.3, 0.7, "auto"])
@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_bar_settles_under_its_weight_with_any_courant_number(configuration, step):
    """Stress to the tolerance; steps in terms of the highest frequency over the lowest."""
    sim = start(bar(configuration, step))
    longest, most = settled(sim)
    assert np.abs(errors(sim)).max() < 2e-3 * 1e-2 * HEIGHT  # strains are of 1e-3
    assert most < 1.05 * 1e-2 * HEIGHT  # no overshoot, which would make metals yield
    frequency = 0.5 * pi / HEIGHT * 10.0
    ratio = 2.0 * PART / longest / frequency
    assert sim.step < 7.0 * ratio


def bent(push):
    """Deflection of the tip of a column, ten times as high as thick, by a small load across it."""
    face = {"body": "body"}
    body = box([1.0, 0.0], [2.0, 10.0]) | {"formulation": "initial"}
    case = scene(2, body, cells=[8, 24], cell=0.5, step={"courant": 0.3},
                 boundaries={"y-min": "fixed"}, start={"equilibrate": {}},
                 tractions={"end": face | {"face": "y-max", "traction": [0.0, -push]},
                            "side": face | {"face": "x-min", "traction": [0.05, 0.0]}})  # fmt: skip
    case["materials"]["soft"] |= {"young": 1e5, "poisson": 0.0}
    sim = start(case)
    while sim.settling:
        sim.advance()
    p, rows = sim.particles, sim.live()
    top = rows[p.origin[rows, 1] > 9.75]
    return float((p.x[top, 0] - p.origin[top, 0]).mean())


def test_a_soft_mode_comes_to_rest_beside_a_great_load():
    """A beam-column: the load across is 5e-3 of that along, and the sum of forces hardly sees it.

    The amplification is the exact one of a cantilever under both, with the rigidity that the
    deflection without load along has. Shear and shortening are of 1e-2 and 1e-3.
    """
    push, q, length = 100.0, 0.05, 10.0  # Euler's load is about 200
    without = bent(0.0)
    rigidity = q * length**4 / (8.0 * without)
    k = sqrt(push / rigidity)
    u = k * length
    a = (1.0 / k**2 - length / k * sin(u)) / cos(u)
    exact = q / push * (1.0 / k**2 - a - 0.5 * length**2)
    assert bent(push) == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("step", [0.4, 0.7])
def test_kinetic_damping_is_stable_at_steps_that_are_stable_without(step):
    """From rest a whole kick in place of half of one makes short waves grow, beyond 0.4."""
    case = bar(step=step, end=20.0, damping={"kinetic": True})
    del case["start"]
    sim = start(case)
    while sim.time < 15.0:
        sim.advance()
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert np.abs(errors(sim)).max() < 0.01 * 1e-2 * HEIGHT
    assert line["kinetic-energy"] < 1e-4 * line["strain-energy"]
    assert line["reaction.x-min-x"] == pytest.approx(0.16, rel=0.02)


def test_a_step_that_is_too_long_is_shortened_while_the_run_settles():
    sim = start(bar("current", step=0.084, end=0.168))
    said = []
    while sim.settling:
        said += sim.watch.said
        sim.watch.said = []
        sim.advance()
    assert any("has come from nothing" in each for each in said)
    assert np.abs(errors(sim)).max() < 2e-3 * 1e-2 * HEIGHT


def test_what_no_longer_falls_ends_the_run_and_is_named(monkeypatch):
    """Rounding is the least that is reached; the last state is a frame."""
    monkeypatch.setattr(relaxation, "PATIENCE", 300)
    monkeypatch.setattr(relaxation, "RESTARTS", 5)
    sim = start(bar(tolerance=1e-30))
    with pytest.raises(NoRestError) as raised:
        settled(sim)
    text = str(raised.value)
    assert "it has not fallen in the last" in text and "what still moves is 'body'" in text
    assert "more steps" not in text


def test_a_body_that_nothing_holds_is_named_and_there_is_a_frame(tmp_path):
    case = bar(start={"equilibrate": {"steps": 40}}, output={"every": 1.0, "fields": ["velocity"]})
    case["boundaries"] = {}
    case["bodies"]["body"]["region"]["box"] = {"min": [2.0], "max": [6.0]}
    case["gravity"] = [1e-2]
    with pytest.raises(NoRestError, match=r"'body', with 100 % .*as a whole along \+x: hold it"):
        pgimp.run(case, output=tmp_path / "run", quiet=True)
    assert len(list((tmp_path / "run" / "frames").glob("particles-*.h5"))) == 1


def slender(dimension, tolerance):
    """A beam of twenty cells, two cells high; in 3D a slice of one cell between smooth walls."""
    wide = [[0.0, 1.0]] * (dimension - 2)
    low, high = zip([0.0, 20.0], *wide, [4.0, 6.0], strict=True)
    load = {"body": "body", "face": f"{'xyz'[dimension - 1]}-max", "pressure": 1e-4}
    faces = {"x-min": "fixed"} | dict.fromkeys(["y-min", "y-max"] * len(wide), "slip")
    cells = [24, *([1] * len(wide)), 10]
    body = box([*low], [*high]) | {"formulation": "total-lagrangian"}
    sim = start(scene(dimension, body, cells=cells, step={"courant": 0.5}, end=0.1,
                      tractions={"p": load}, boundaries=faces,
                      start={"equilibrate": {"tolerance": tolerance}}))  # fmt: skip
    settled(sim)
    return sim.particles.x[sim.live()][:, -1].min()


@pytest.mark.parametrize("dimension", [2, wide(3)])
def test_what_walls_bear_does_not_end_the_settling_too_early(dimension):
    """The way is right to the tenth of a per cent with bending, and in a slice as in the plane."""
    rest = slender(2, 1e-6)
    assert slender(dimension, 1e-4) == pytest.approx(rest, abs=5e-4 * (4.25 - rest))


def cantilever(**parts):
    """A beam of ten times its height, four cells high, with a pressure on its upper face."""
    body = box([0.0, 4.0], [40.0, 8.0]) | {"formulation": "total-lagrangian"}
    load = {"body": "body", "face": "y-max", "pressure": 1e-4}
    return scene(2, body, cells=[48, 12], step={"courant": 0.5}, end=0.1, tractions={"p": load},
                 boundaries={"x-min": "fixed"}, **parts)  # fmt: skip


def test_a_cantilever_under_a_pressure_rests_as_beams_do():
    """The wave through its height does not stop the bending; deflection by Timoshenko's theory."""
    sim = start(cantilever(start={"equilibrate": {}}, output={"fields": ["displacement"]}))
    longest, _ = settled(sim)
    modulus, shear, length, height = 100.0 / 0.91, 100.0 / 2.6, 40.0, 4.0
    inertia = height**3 / 12.0
    frequency = 3.516 / length**2 * (modulus * inertia / height) ** 0.5
    assert sim.step < 3.5 * 2.0 * PART / longest / frequency
    x = sim.particles.x[sim.live()]
    x, y = x[np.argsort(-x[:, 0])[:8]].mean(axis=0)
    bent = x**2 * (6.0 * length**2 - 4.0 * length * x + x**2) / (24.0 * modulus * inertia)
    sheared = (length * x - 0.5 * x**2) / (shear * height / 1.2)
    assert 6.0 - y == pytest.approx(1e-4 * (bent + sheared), rel=0.02)
