"""Advice of ``pgimp check`` on configuration and method: said where it helps, else nothing."""

import pytest
from checked import facts
from mentioned import mentions

from pgimp.case.reader import read_case
from pgimp.scene.checks.advice import advice

BLOCK = """
format: 1
dimensions: 2
grid: {{size: [12.0, 12.0], cell: [1.0, 1.0]}}
method: {{shape: {shape}, affine: {affine}, volumetric: {volumetric}, particles-per-cell: [2, 2]}}
time: {{end: {end}, step: {{courant: 0.1}}}}
materials: {{jelly: {{model: {model}, density: 1.0{law}}}}}
bodies:
  block:
    material: jelly
    configuration: {configuration}
    velocity: {velocity}
    region: {{box: {{min: [4.0, 4.0], max: [8.0, 8.0]}}}}
{more}
"""
SPIN = "{rotation: {about: [6.0, 6.0], rate: 0.025}}"
ELASTIC = ("neo-hookean", ", young: 1.0, poisson: 0.3")
SOIL = ("drucker-prager", ", young: 1.0, poisson: 0.3, cohesion: 1.0, friction_angle: 30.0")


def told(
    shape="gimp", affine=False, end=100.0, law=ELASTIC, configuration="current",
    velocity="[0.0, 0.0]", volumetric="pointwise", more="",
):  # fmt: skip
    text = BLOCK.format(
        shape=shape, affine=str(affine).lower(), end=end, model=law[0], law=law[1],
        configuration=configuration, velocity=velocity, volumetric=volumetric, more=more,
    )  # fmt: skip
    case = read_case(text, "block.yaml")
    return advice(case, facts(case))


def test_what_rests_is_left_alone():
    assert told() == told("mpm") == told("fuzzy-constant") == []


def test_walls_of_liquids():
    """Told where all is liquid, and a case turns off what a wall could reflect."""
    water = ("newtonian", ", bulk: 100.0")
    walls, ghost = "boundaries: {x-min: slip}", "gimp, wall: ghost"
    (line,) = told(ghost, law=water, more=walls)
    mentions(line, "method.wall: ghost", "wall: auto")
    assert told(law=water, more=walls) == told(ghost, law=water) == []
    assert told(ghost, law=water, more="boundaries: {x-min: {velocity: [0.0, 0.0]}}") == []
    assert told(ghost, law=SOIL, more=walls) == []
    floor = "gravity: [0.0, -1.0]\nboundaries: {y-min: unilateral}"
    (line,) = told(law=water, more=floor)
    mentions(line, "boundaries.y-min: unilateral", "slip")
    assert told(law=SOIL, more=floor) == []


def test_gas_that_does_not_rest():
    """Told with volumes by particle, or beside a wall that does not reflect."""
    gas, walls = ("ideal-gas", ", gamma: 1.4, energy: 1.0"), "boundaries: {x-min: slip}"
    (line,) = told(law=gas, more=walls)
    mentions(line, "block is pointwise", "wall: mirror")
    assert told(law=gas, volumetric="b-bar", more=walls) == []
    assert told(law=gas, volumetric="b-bar", more="boundaries: {x-min: absorbing}") == []
    for more in ("x-min: {velocity: [0.0, null]}", "x-min: {unilateral: {friction: 0.2}}"):
        (line,) = told(law=gas, volumetric="b-bar", more=f"boundaries: {{{more}}}")
        mentions(line, "x-min does not reflect")


def test_points_that_cross_cells():
    """Told for what moves half a cell in the current configuration, whatever it is made of."""
    fast, slow = "[0.05, 0.0]", "[0.004, 0.0]"
    (line,) = told("mpm", law=SOIL, velocity=fast)
    mentions(line, "method.shape: mpm", "'block'", "gimp", "affine: true")
    assert told("mpm", law=SOIL, velocity=slow) == []
    assert told("gimp", law=SOIL, velocity=fast) == []
    assert told("mpm", configuration="initial", velocity=fast) == []
    # With affine it is a warning.
    assert told("mpm", True, law=SOIL, velocity=fast) == []


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_bodies_that_turn(configuration):
    """Told for a radian or more, without `affine`; in the initial configuration spin lasts."""
    lines = told(configuration=configuration, velocity=SPIN)
    brief = told(end=30.0, configuration=configuration, velocity=SPIN)
    if configuration == "initial":
        assert not [line for line in (*lines, *brief) if "spin" in line]
        return
    mentions(lines[-1], "method.affine", "'block'", "spin")
    assert len(lines) == 2  # the other is on the configuration
    turned = told(affine=True, configuration=configuration, velocity=SPIN)
    assert not [line for line in (*turned, *brief) if "affine" in line]


@pytest.mark.parametrize("shape", ["gimp", "bspline-quadratic"])
def test_boxes_that_keep_their_size(shape):
    """Told for strong compression of elastic bodies, where the other is not told of.

    That is where something may leave the domain.
    """
    heavy = "gravity: [0.0, -0.08]\nboundaries: {y-min: unilateral}\noutflow: {x-max: remove}"
    (line,) = told(shape, volumetric="b-bar", more=heavy)
    mentions(line, "method.shape", f"boxes of {shape}", "finite-gimp")
    assert told("finite-gimp", volumetric="b-bar", more=heavy) == []
    assert told(shape, volumetric="b-bar", more=heavy.replace("0.08", "0.01")) == []
    assert told(shape, law=SOIL, more=heavy) == []


def test_the_initial_configuration():
    """Told for what moves, is held or meets something; not for what would stick to it."""
    fast = "[0.0, -0.05]"
    (line,) = told(velocity=fast, end=20.0)
    mentions(line, "formulation: total-lagrangian", "'block'", "it moves")
    assert told(configuration="initial", velocity=fast, end=20.0) == []
    assert told(velocity=fast, end=20.0, more="boundaries: {x-min: unilateral}") == [line]
    (hit,) = told(velocity=fast, end=60.0, more="boundaries: {y-min: unilateral}")
    assert hit == line + "; a step takes longer while they are in touch"
    assert told(velocity=fast, end=100.0, more="boundaries: {y-min: fixed}") == []


@pytest.mark.parametrize("shape", ["fuzzy-constant", "bspline-cubic"])
def test_wide_shapes(shape):
    """Told for elastic bodies that move, unless volume is locked."""
    falls = {"velocity": "[0.0, -0.05]", "more": "boundaries: {y-min: unilateral}"}
    configuration, line = told(shape, **falls)
    mentions(configuration, "formulation: total-lagrangian", "in touch")
    mentions(line, f"method.shape: {shape}", "'block'", "gimp")
    stiff = (ELASTIC[0], ", young: 1.0, poisson: 0.49")
    assert told(shape, law=stiff, **falls) == [configuration]
    assert told(shape, law=SOIL, **falls) == []
