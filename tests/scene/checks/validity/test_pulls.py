"""How far grips stretch a body: tables, ramps, stages, functions; and which bodies tear then."""

import pytest
from checked import facts
from mentioned import mentions

import pgimp
from pgimp.case.reader import read_case
from pgimp.scene.checks.validity.tearing import stretches, tearing_stretch, warnings

BAR = """
format: 1
dimensions: 2
grid: {{size: [4.6, 1.0], cell: [0.1, 0.1]}}
method: {{shape: {shape}, particles-per-cell: [{n}, 2]}}
time: {{end: 2.2, step: {{courant: 0.3}}{stages}}}
materials: {{m: {{model: {law}, young: 1.0e+6, poisson: 0.3, density: 1000.0}}}}
bodies:
  bar:
    material: m
    region: {{box: {{min: [0.0, 0.3], max: [2.0, 0.7]}}}}
    configuration: {configuration}
constraints:
  grip: {{body: bar, region: {{box: {{min: [1.9, 0.0], max: [2.1, 1.0]}}}}, velocity: {velocity}}}
{more}
boundaries: {{x-min: {wall}}}
"""
PULL = "[{table: [[0.0, 0.0], [0.2, 1.0], [2.0, 1.0], [2.2, 0.0]]}, null]"
SOIL = "mohr-coulomb, cohesion: 1.0, friction-angle: 30.0"


def bar(velocity=PULL, shape="gimp", n=2, law="neo-hookean", stages="", more="", wall="slip",
        configuration="current"):  # fmt: skip
    text = BAR.format(velocity=velocity, shape=shape, n=n, law=law, stages=stages, more=more,
                      wall=wall, configuration=configuration)  # fmt: skip
    return read_case(text, "bar.yaml")


def pulled(**parts):
    case = bar(**parts)
    (body,) = facts(case.stages[0])
    return stretches(case.stages, body), list(warnings(case.stages, body))


def test_a_bar_that_is_pulled_to_twice_its_length():
    ((one,), (text,)) = pulled()
    assert one.way == pytest.approx(2.0) and one.length == pytest.approx(1.9)
    assert one.strain == pytest.approx(2.0 / 1.9)
    assert (one.time, one.axis, one.between) == (2.2, 0, ("constraint grip", "x-min"))
    mentions(
        text, "constraints.grip", "'bar'", "x-min", "2.05 times", "formulation: total-lagrangian"
    )
    mentions(text, "gimp and 2 particles", "1.6 times", "cpdi", "more particles")


@pytest.mark.parametrize(
    ("velocity", "way"),
    [
        ("[{ramp: {to: 1.0, duration: 2.0}}, 0.0]", 1.2),
        ("[{sine: {amplitude: 1.0, frequency: 0.5}}, null]", 0.63662),
        ("[1.0, null]", 2.2),
        ("[-0.5, null]", -1.1),
        ("[null, 1.0]", None),
    ],
)
def test_the_way_is_the_integral(velocity, way):
    found = pulled(velocity=velocity)[0]
    assert [one.way for one in found] == ([] if way is None else [pytest.approx(way, rel=1e-3)])


def test_functions_of_time_and_of_place():
    def widen(t, rate):
        return rate * t

    def carry(x, t):
        return (0.5 * x[0], 0.0)

    pgimp.coefficient(widen)
    pgimp.velocity(carry)
    (one,) = pulled(velocity="[{function: widen, parameters: {rate: 1.0}}, null]")[0]
    assert one.way == pytest.approx(0.5 * 2.2**2)
    (one,) = pulled(velocity="{function: carry}")[0]
    assert one.way == pytest.approx(0.5 * 1.95 * 2.2)  # of the middle of the grip


def test_stages_add_up_and_return():
    stages = (
        ", stages: [{name: on, end: 4.4}, {name: back, end: 6.6, constraints: {grip: {body: bar"
    )
    stages += ", region: {box: {min: [1.9, 0.0], max: [2.1, 1.0]}}, velocity: [-1.0, null]}}}]"
    (one,) = pulled(velocity="[0.5, null]", stages=stages)[0]
    assert (one.way, one.time) == (pytest.approx(2.2), pytest.approx(4.4))


def test_two_grips_pull_between_them():
    more = "  left: {body: bar, region: {box: {min: [0.0, 0.0], max: [0.2, 1.0]}}, "
    (one,) = pulled(more=more + "velocity: [-0.1, 0.0]}", wall="{unilateral: {}}")[0]
    assert one.way == pytest.approx(2.0 + 0.22, rel=1e-6) and one.length == pytest.approx(1.7)
    assert one.between == ("constraint grip", "constraint left")


@pytest.mark.parametrize(
    "parts",
    [
        {"configuration": "initial"},
        {"shape": "cpdi"},
        {"shape": "bspline-cubic", "n": 3, "velocity": "[0.4, null]"},
        {"velocity": "[0.4, null]"},  # to 1.46 of its length
        {"law": SOIL},
        {"wall": "unilateral"},  # it lets go
    ],
)
def test_what_does_not_tear(parts):
    assert pulled(**parts)[1] == []


def test_fewer_particles_tear_sooner():
    limits = [tearing_stretch(bar(n=n), "bar")[0] for n in (1, 2)]
    assert limits[0] < limits[1] < tearing_stretch(bar(shape="bspline-cubic"), "bar")[0]
    assert tearing_stretch(bar(shape="cpdi"), "bar")[0] > 2.5
