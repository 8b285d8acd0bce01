"""Absorbing faces: waves leave through them, and what is at rest stays there."""

import numpy as np
import pytest
from scenes import box, finish, scene, start

from pgimp.case.schema import Case
from pgimp.kernels.grid.absorbing import PRESSURE_WAVE, REACTION_MASS, SHEAR_WAVE
from pgimp.scene.checks.at_start import unquiet

pytestmark = pytest.mark.slow(60)

YOUNG, POISSON = 100.0, 0.3
MODULUS = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
SPEED = {"p": MODULUS**0.5, "s": (0.5 * YOUNG / (1.0 + POISSON)) ** 0.5}
PULSE = 20.0


def pulse(cells, wave, configuration, face="absorbing", height=1):
    """A smooth pulse 20 cells long enters a bar at its low end: across it, or along it."""
    length, most = PULSE / SPEED[wave], 1e-4
    times = np.linspace(0.0, length, 41)
    shape = {"table": [[t, most * np.sin(np.pi * t / length) ** 2] for t in times.tolist()]}
    across = wave == "p"
    sides = "slip" if across else {"velocity": [0.0, None]}
    walls = {
        "x-min": {"velocity": [shape, 0.0] if across else [0.0, shape]},
        "y-min": sides,
        "y-max": sides,
    }
    step = 0.3 / SPEED["p"]
    case = scene(2, box([0.0, 0.0], [cells, height]) | {"formulation": configuration},
                 cells=[cells, height], boundaries=walls | ({"x-max": face} if face else {}),
                 end=1000 * step, step=step)  # fmt: skip
    case["materials"]["soft"] = {
        "model": "hooke", "young": YOUNG, "poisson": POISSON, "density": 1.0,
    }  # fmt: skip
    return case


def velocities(case, wave, reach, until):
    """Velocities of the particles from 20 cells to `reach`, step by step, and the simulation."""
    sim, found = start(case), []
    while sim.time < until:
        sim.advance()
        rows = sim.live()
        x = sim.particles.x[rows, 0]
        found.append(sim.particles.v[rows[(x > 20.0) & (x < reach)], int(wave == "s")].copy())
    return np.array(found), sim


@pytest.mark.parametrize("configuration", ["current", "initial"])
@pytest.mark.parametrize("wave", ["p", "s"])
def test_less_than_two_per_cent_of_a_pulse_comes_back(wave, configuration):
    """Against a bar so long that nothing has come back yet."""
    until = 125.0 / SPEED[wave]
    found, sim = velocities(pulse(55, wave, configuration), wave, 50.0, until)
    endless, _ = velocities(pulse(130, wave, configuration), wave, 50.0, until)
    most = np.abs(endless).max()
    assert most == pytest.approx(1e-4, rel=0.02)
    assert np.abs(found - endless).max() < 0.008 * most
    line = sim.diagnostics()
    energy = 2.0 * SPEED[wave] * 0.5 * 1e-8 * 0.375 * PULSE / SPEED[wave]  # of the pulse
    assert line["radiated.x-max"] == pytest.approx(energy, rel=0.05)
    assert line["kinetic-energy"] + line["strain-energy"] < 1e-3 * energy


@pytest.mark.parametrize("way", [0.1, -0.1])
def test_a_column_that_moves_on_is_braked_as_at_first(way):
    """Moved at a constant velocity, it has the stress rho c v behind the front (Lysmer).

    It moves by a part of a cell, so that mass comes beyond the face, or leaves it.
    """
    case = pulse(10, "p", "current")
    v = way / (340 * case["time"]["step"])
    case["boundaries"]["x-min"] = {"velocity": [{"table": [[0.0, v], [1.0, v]]}, 0.0]}
    case["time"]["end"] = 340 * case["time"]["step"]
    sim, stress = start(case), []
    while not sim.finished:
        sim.advance()
        stress.append(sim.particles.sigma[sim.live(), 0].mean())
    assert sim.particles.x[sim.live(), 0].max() == pytest.approx(9.75 + way, abs=0.01)
    np.testing.assert_allclose(stress[170:], -SPEED["p"] * v, rtol=0.015)


def test_ground_that_loses_its_weight_rises_at_a_constant_velocity():
    """The constant force that bore the weight W of a unit of area gives the velocity W/(rho c)."""
    case = pulse(10, "p", "current")
    case["bodies"]["body"] |= box([1.0, 0.0], [10.0, 1.0])
    del case["boundaries"]["x-min"]
    v = 0.3 / (500 * case["time"]["step"])
    pull = v * SPEED["p"] / 9.0
    case["gravity"] = {"table": [[0.0, [pull, 0.0]], [1e-9, [0.0, 0.0]]]}
    case["start"] = {"stress": {"k0": 0.5}}
    case["time"]["end"] = 600 * case["time"]["step"]
    sim, speed = start(case), []
    while not sim.finished:
        sim.advance()
        speed.append(sim.particles.v[sim.live(), 0].mean())
    assert sim.particles.x[sim.live(), 0].max() < 9.75 - 0.25
    np.testing.assert_allclose(speed[200:], -v, rtol=0.01)


def test_dashpots_have_the_speeds_of_the_material_there():
    case = pulse(6, "p", "current")
    case["materials"]["stiff"] = case["materials"]["soft"] | {"young": 4.0 * YOUNG, "density": 2.0}
    case["bodies"] = {"low": box([0.0, 0.0], [6.0, 2.0]),
                      "high": box([0.0, 2.0], [6.0, 4.0], None, "stiff")}  # fmt: skip
    case["grid"]["size"] = [6.0, 4.0]
    sim = start(case)
    sim.advance()
    face = sim.rank.absorbing.found["x-max"]
    assert face.extent.tolist() == [1, 5, 1]
    p, s = face.values[:5, PRESSURE_WAVE], face.values[:5, SHEAR_WAVE]
    factor = np.array([1.0, 1.0, (1.0 + 2.0 * 2.0**0.5) / 3.0, 2.0**0.5, 2.0**0.5])  # by mass
    np.testing.assert_allclose(p, SPEED["p"] * factor, rtol=1e-12)
    np.testing.assert_allclose(s, SPEED["s"] * factor, rtol=1e-6)


def test_of_a_body_that_a_stage_removes_the_face_keeps_no_part():
    case = pulse(6, "p", "current")
    case["bodies"] = {"low": box([0.0, 0.0], [6.0, 2.0]), "high": box([0.0, 2.0], [6.0, 4.0])}
    case["grid"]["size"], step = [6.0, 4.0], case["time"]["step"]
    case["time"] |= {"end": step, "stages": [{"name": "dig", "end": 2 * step, "remove": ["high"]}]}
    sim = start(case)
    sim.advance()
    mass = sim.rank.absorbing.found["x-max"].values[:5, REACTION_MASS]
    finish(sim)
    left = sim.rank.absorbing.found["x-max"].values[:5, REACTION_MASS]
    np.testing.assert_allclose(left / mass, [1.0, 1.0, 0.5, 0.0, 0.0], rtol=1e-12)


def block(configuration, **parts):
    """A heavy block between absorbing faces."""
    faces = {
        "x-min": "absorbing", "x-max": "absorbing", "y-min": {"absorbing": {"held": "fixed"}},
    }  # fmt: skip
    body = box([0.0, 0.0], [6.0, 5.0]) | {"formulation": configuration}
    parts = {"start": {"equilibrate": {"tolerance": 1e-6}}, "boundaries": faces, "end": 4.0} | parts
    return scene(2, body, cells=[6, 7], gravity=[0.0, -0.1], step={"courant": 0.3}, **parts)


def rests(sim, speed):
    """Whether a simulation stays at rest to its end, and the floor bears the weight."""
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert np.abs(sim.particles.v[sim.live()]).max() < speed * SPEED["p"]
    assert line["reaction.y-min-y"] == pytest.approx(3.0, rel=1e-4)
    assert line["reaction.x-min-x"] == pytest.approx(-line["reaction.x-max-x"])
    assert line["reaction.x-min-x"] > 0.1
    return line


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_what_has_settled_stays_at_rest(configuration):
    sim = start(block(configuration))
    while sim.settling:
        sim.advance()
        assert not sim.rank.absorbing.found
    line = rests(sim, 1e-8)
    assert 0.0 < line["radiated.y-min"] < 1e-9


def test_a_face_that_begins_to_absorb_in_a_stage_keeps_its_reaction():
    case = block("current", end=0.1)
    later = case["boundaries"]
    case["boundaries"] = {"x-min": "slip", "x-max": "slip", "y-min": "fixed"}
    case["time"]["stages"] = [{"name": "quake", "end": 4.0, "boundaries": later}]
    sim = start(case)
    while sim.stage == 0 or sim.settling:
        sim.advance()
    line = rests(sim, 1e-8)
    assert {"radiated.x-min", "radiated.x-max", "radiated.y-min"} <= line.keys()


def test_a_settled_case_and_one_that_is_not_are_told_apart():
    case = block("current")
    assert [*unquiet(Case.model_validate(case))] == []
    del case["start"]
    texts = [*unquiet(Case.model_validate(case))]
    assert len(texts) == 3 and "start: {equilibrate: {}}" in texts[0]
    del case["gravity"]
    assert [*unquiet(Case.model_validate(case))] == []


def test_waves_along_the_radius_are_refused():
    case = block("current", geometry="axisymmetric", boundaries={"x-max": "absorbing"})
    with pytest.raises(ValueError, match="absorbing is for plane waves"):
        Case.model_validate(case)


def test_what_faces_hold_does_its_work_over_the_way_also_in_steps_from_rest():
    """Kinetic damping halves the first kick: loads do the work of the way that is left."""
    case = block("current", damping={"kinetic": True}, end=2.0)
    del case["start"]
    case["boundaries"] = {"x-min": "slip", "x-max": "slip", "y-min": "absorbing"}
    case["gravity"] = {"table": [[0.0, [0.0, -0.1]], [1e-9, [0.0, 0.0]]]}  # faces push upwards
    sim, rested = start(case), 0
    line = sim.diagnostics()
    while not sim.finished:
        sim.advance()
        last, line = line, sim.diagnostics()
        rested += line["damped-energy"] > last["damped-energy"]
        if sim.step == 1:
            continue
        face = sim.rank.absorbing.found["y-min"]
        grid = sim.rank.grid
        bottom = face.wall - grid.window.lower[1]
        records = grid.by_vertex(grid.G)[: grid.owned, 0, bottom, 0]
        there = records[:, 0] > 0.0
        held = face.values[: there.sum(), :3]
        work = sim.dt * (held * records[there][:, 1:4]).sum()
        done = line["external-work"] - last["external-work"]
        assert done == pytest.approx(work, rel=1e-9, abs=1e-15)
    assert rested
