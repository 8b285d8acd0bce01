"""What `pgimp check` knows of tools: what their speed sends into a body, and where edges lie."""

from math import cos, radians, sin, sqrt

import pytest
from checked import facts
from mentioned import mentions

from pgimp.case.reader import read_case
from pgimp.scene.checks.sanity import body_warnings
from pgimp.scene.checks.validity import impedance, tool_edges
from pgimp.scene.scene import Scene

FOOTING = """
format: 1
units: m, kg, s
dimensions: 2
grid: {{size: [9.0, 6.0], cell: [0.25, 0.25]}}
method: {{shape: gimp, particles-per-cell: [2, 2], volumetric: b-bar}}
time: {{end: {end}, step: {{courant: 0.3}}, mass-scaling: {scaling}}}
materials:
  soil: {{model: mohr-coulomb, young: 20.0e6, poisson: 0.3, density: {density}, cohesion: 20.0e3,
         friction-angle: {phi}}}
bodies:
  ground: {{material: soil, region: {{box: {{min: [0, 0], max: [9.0, 5.0]}}}}}}
  footing:
    rigid: {{velocity: [0.0, {{ramp: {{to: -{speed}, duration: 0.4}}}}]}}
    region: {{box: {{min: [{low}, 5.0], max: [{high}, 5.5]}}}}
gravity: [0.0, {gravity}]
boundaries: {{x-min: {side}, x-max: slip, y-min: fixed}}
contact: [{{bodies: [footing, ground], friction: 0.0}}]
"""
MODULUS = 20.0e6 * (1.0 - 0.3) / ((1.0 + 0.3) * (1.0 - 2.0 * 0.3))


def prepared(speed=0.1, scaling=1.0, end=2.0, phi=0.0, high=1.125, low=-1.125, gravity=0.0,
             side="slip", density=1800.0):  # fmt: skip
    case = read_case(
        FOOTING.format(speed=speed, scaling=scaling, end=end, phi=phi, high=high, low=low,
                       gravity=gravity, side=side, density=density)
    )  # fmt: skip
    return case, Scene(case), facts(case)


def sent(**parts):
    case, scene, bodies = prepared(**parts)
    return impedance.sent(case.stages, scene, bodies)


def test_a_fast_tool_with_mass_scaling():
    """Density times wave speed times velocity of the scaled mass: 348 kPa into 40 kPa."""
    (one,) = sent(scaling=250.0)
    pressure = sqrt(250.0 * 1800.0 * MODULUS) * 0.1
    assert pressure == pytest.approx(348e3, rel=1e-2)
    mentions(one.text, "bodies.footing.rigid", "at 0.1 ", f"{pressure:.3g} Pa", "'ground'")
    mentions(one.text, "4e+04 Pa", "mass-scaling: 250")
    assert one.lasts


def test_what_spreads_is_told_of_scaled_inertia_only():
    (one,) = sent(scaling=16.0, end=6.8, speed=0.025)
    assert not one.lasts
    assert sent(end=6.8) == []
    assert sent(scaling=16.0, end=6.8, speed=0.001) == []


def test_without_scaling_a_tool_may_be_too_fast_as_well():
    (one,) = sent(speed=3.0, end=0.1)
    assert one.lasts and "mass-scaling" not in one.text


def test_strength_is_that_of_compression_under_the_weight_above_the_middle():
    _, scene, bodies = prepared(phi=20.0, gravity=-9.81)
    S, C = sin(radians(20.0)), cos(radians(20.0))
    side = 1800.0 * 9.81 * 2.5
    strength = side * (1.0 + S) / (1.0 - S) + 2.0 * 20.0e3 * C / (1.0 - S) - side
    assert impedance.strength_of(scene.case, bodies[0]) == pytest.approx(strength)


def test_scaled_inertia_is_no_wrong_density():
    for scaling in (1.0, 1.0e4):
        _, scene, bodies = prepared(scaling=scaling)
        assert list(body_warnings(scene.case, bodies[0], 2.0)) == []
    _, scene, bodies = prepared(scaling=100.0, density=1.8e6)  # grams
    (text,) = body_warnings(scene.case, bodies[0], 200.0)
    mentions(text, "materials.soil.density: 1.8e+06 ", "1.8e+06 kg/m^3")


def edges(**parts):
    case, scene, bodies = prepared(**parts)
    return list(tool_edges.notes(scene, bodies, case.time.last))


def test_cells_across_a_tool_on_a_plane_of_symmetry():
    (text,) = edges()
    mentions(text, "bodies.footing.region: 9 cells across along x, edges 0.5 of a cell", "33 %")
    (text,) = edges(high=1.0)
    mentions(text, "8 cells across", "edges 0 of a cell", "on a line")
    # Without a plane of symmetry it is as wide as it is, with one edge.
    (text,) = edges(side="fixed")
    mentions(text, "9 cells across", "17 %")
    (text,) = edges(low=3.1, high=5.2)
    mentions(text, "8.4 cells across", "0.4 and 0.2 of a cell", "36 %")


def test_a_plate_that_covers_the_ground_has_no_edges():
    assert edges(high=9.5) == []
    assert edges(speed=0.0) == []
