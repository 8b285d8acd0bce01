"""Particles stay out of rigid bodies, however thin what they belong to is."""

from math import cos, radians, sin

import numpy as np
import pytest
from scenes import box, energy, finish, scene, start
from tiers import wide

from pgimp.solver.contact.penetration import QUARTER
from pgimp.solver.start.particle_errors import origin

pytestmark = pytest.mark.slow(30)

SAND = {"model": "drucker-prager", "young": 1.0e5, "poisson": 0.3, "density": 1600.0,
        "friction-angle": 25.0, "cohesion": 0.0}  # fmt: skip


def half(D, place, degrees, motion):
    """A rigid half-space that falls towards larger x, with the normal in the plane of x and y."""
    slope = radians(degrees)
    normal, ends = [sin(slope), cos(slope), 0.0][:D], [[-5.0] * D, [30.0] * D]
    plane = {"half-space": {"point": [*place, 0.0][:D], "normal": normal}}
    whole = {"box": {"min": ends[0], "max": ends[1]}}
    return {"rigid": motion, "region": {"intersection": [plane, whole]}}, np.array(normal)


@pytest.mark.parametrize("speed", [0.0, wide(0.5)])
def test_sand_that_falls_on_a_slope_in_3d(speed):
    """Of a ball of sand that spreads into thin tongues nothing enters, also if the slope rises."""
    h = 0.05
    motion = {"velocity": [0.0, speed, 0.0]} if speed else {}
    slope, normal = half(3, [0.5, 0.3], 33.0, motion)
    bodies = {
        "ball": {"material": "sand", "region": {"ball": {"centre": [0.4, 0.59, 0.35],
                                                         "radius": 0.18}}},
        "slope": slope,
    }  # fmt: skip
    case = scene(3, bodies, cells=[22, 24, 14], cell=h, end=0.35, step={"courant": 0.4},
                 materials={"sand": SAND}, gravity=[0.0, -9.81, 0.0],
                 boundaries=dict.fromkeys(("x-min", "x-max", "y-min", "z-min", "z-max"), "slip"),
                 contact=[{"bodies": ["ball", "slope"], "friction": 0.3}])  # fmt: skip
    sim = finish(start(case))
    place = np.array([0.5, 0.3 + speed * sim.time, 0.0])
    depth = -(sim.particles.x[sim.live()] - place) @ normal / h
    assert sim.particles.m[sim.live()][depth > QUARTER].sum() < 4e-3 * sim.diagnostics()["mass"]
    assert depth.max() < 0.5  # slivers, whose centroids are outside
    line = sim.diagnostics()
    assert line["rigid.slope.penetrating-particles"] == 0
    assert line["rigid.slope.work"] == pytest.approx(
        -speed * line_impulse(sim), rel=1e-9, abs=1e-12
    )


def line_impulse(sim):
    """Impulse along y on the first rigid body since the start."""
    return sim.rank.ledger.rigid_bodies[:, 0, 1].sum()


@pytest.mark.parametrize("degrees", [20.0, 45.0])
def test_a_layer_of_one_particle_slides_as_coulomb_says(degrees):
    """Half a cell thick, it fills next to nothing at most vertices, and stays on the slope."""
    place, (slope, normal) = np.array([6.0, 6.0]), half(2, [6.0, 6.0], degrees, {})
    along = np.array([normal[1], -normal[0]])
    layer = [{"half-space": {"point": (place + 0.52 * normal).tolist(), "normal": normal.tolist()}},
             {"half-space": {"point": (place + 0.02 * normal).tolist(),
                             "normal": (-normal).tolist()}},
             {"box": {"min": [4.0, 1.0], "max": [8.0, 11.0]}}]  # fmt: skip
    bodies = {"layer": {"material": "soft", "region": {"intersection": layer}}, "slope": slope}
    case = scene(2, bodies, cells=[24, 12], end=2.0, step=0.01, gravity=[0.0, -1.0],
                 contact=[{"bodies": ["layer", "slope"], "friction": 0.2}])  # fmt: skip
    sim, found = start(case), []
    while not sim.finished:
        sim.advance()
        rows = sim.live()
        m = sim.particles.m[rows]
        found.append((sim.time, m @ (sim.particles.v[rows] @ along) / m.sum()))
        assert sim.diagnostics()["rigid.slope.penetrating-particles"] == 0
    time, speed = np.array(found)[100:].T
    slides = sin(radians(degrees)) - 0.2 * cos(radians(degrees))
    assert np.polyfit(time, speed, 1)[0] == pytest.approx(slides, rel=0.03)


@pytest.mark.parametrize("density", [0.02, 20.0])
def test_momentum_and_energy_with_a_free_body_that_holds_particles(density):
    """What they lose the body gets, whatever the ratio of masses; no energy comes from nothing."""
    flat = {"intersection": [
        {"half-space": {"point": [6.0, 5.0], "normal": [sin(0.4), cos(0.4)]}},
        {"box": {"min": [3.0, 1.5], "max": [9.0, 7.0]}},
    ]}  # fmt: skip
    bodies = {name: box([x, 6.6], [x + 0.5, 7.1], [0.0, -2.0])
              for name, x in (("one", 4.5), ("two", 6.5), ("three", 8.0))}  # fmt: skip
    bodies["wedge"] = {"rigid": {"density": density}, "region": flat}
    case = scene(2, bodies, cells=[12, 12], end=1.5, step=0.01,
                 contact=[{"bodies": [*bodies], "friction": 0.3}])  # fmt: skip
    sim = start(case)
    before, sums = None, []
    while True:
        line = sim.diagnostics()
        total = [line[f"momentum-{a}"] + line[f"rigid.wedge.momentum-{a}"] for a in "xy"]
        before = before or total
        assert total == pytest.approx(before, abs=1e-10 * line["mass"])
        assert line["rigid.wedge.penetrating-particles"] == 0
        sums.append(energy(line) + line["dissipated-energy"] + line["rigid.wedge.kinetic-energy"])
        assert energy(line) + line["rigid.wedge.kinetic-energy"] <= 1.001 * sums[0]
        if sim.finished:
            break
        sim.advance()
    assert np.abs(np.array(sums) / sums[0] - 1.0).max() < 1e-11
    assert line["rigid.wedge.work"] < -1e-3 * sums[0]


def test_what_is_inside_is_counted_and_warned_of_once():
    """The column counts what is deeper than a quarter of a cell; errors say where it was."""
    bodies = {"block": box([2.0, 4.0], [4.0, 6.0]),
              "floor": half(2, [4.0, 3.0], 20.0, {})[0]}  # fmt: skip
    case = scene(2, bodies, contact=[{"bodies": ["block", "floor"]}])
    sim = start(case)
    assert sim.diagnostics()["rigid.floor.penetrating-particles"] == 0
    rows = sim.live()[:3]
    sim.particles.x[rows] = [[4.0, 2.5], [4.0, 2.9], [4.0, 1.0]]
    assert (
        sim.diagnostics()["rigid.floor.penetrating-particles"]
        == sim.diagnostics()["rigid.floor.penetrating-particles"]
        == 2
    )
    said = sim.diagnostic_sums.said
    assert len(said) == 1 and "2 in 'floor' at time 0" in said[0]
    assert origin(sim.rank, rows[0], 0.0) == ", from inside the rigid body 'floor'"
    assert origin(sim.rank, sim.live()[-1], 0.0) == ""


def test_friction_of_what_is_held_leaves_prescribed_velocities():
    """What is drawn over a flat floor, which holds it, keeps its speed to the bit."""
    region = {"box": {"min": [2.0, 4.0], "max": [5.0, 5.0]}}
    bodies = {"layer": {"material": "soft", "region": region, "velocity": [0.5, -0.2]},
              "floor": half(2, [4.0, 3.0], 0.0, {})[0]}  # fmt: skip
    grip = {"body": "layer", "region": region, "velocity": [0.5, None]}
    case = scene(2, bodies, step=0.01, constraints={"grip": grip},
                 contact=[{"bodies": ["layer", "floor"], "friction": 0.3}])  # fmt: skip
    sim = start(case)
    rows = sim.live()[:3]
    sim.particles.x[rows, 1] = 2.99
    sim.advance()
    assert sim.particles.x[rows, 1] == pytest.approx(3.0, abs=1e-12)
    assert sim.particles.v[rows, 1] == pytest.approx(0.0, abs=1e-12)
    assert (sim.particles.v[sim.live(), 0] == 0.5).all()
