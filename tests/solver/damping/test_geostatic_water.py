"""Ground in water that starts with the stress of the weight above."""

import numpy as np
import pytest
from level_ground import HIGH, K0, LAWS, depth, fastest, ground
from scenes import box, start
from tiers import wide

from pgimp.case.schema import Case

pytestmark = pytest.mark.slow(40)

WATER = {"level": 3.0, "density": 0.4}


def in_water(y, dry=2.0, surcharge=2.0):
    """Effective stress at a depth: under a surcharge, and in water below a dry part."""
    return surcharge + y - 0.4 * np.maximum(y - dry, 0.0)


@pytest.mark.parametrize("law", ["hooke", *map(wide, list(LAWS)[1:])])
def test_ground_in_water_under_a_surcharge_stays_at_rest(law):
    load = {"fill": {"body": "body", "face": "y-max", "pressure": 2.0}}
    case = ground(law, water=WATER, tractions=load)
    case["start"]["stress"]["surcharge"] = ["fill"]
    most, sim = fastest(case)
    assert most < 1e-12
    sigma, y = sim.particles.sigma[sim.live()], depth(sim, 1)
    np.testing.assert_allclose(sigma[:, 1], -in_water(y), rtol=1e-12)
    np.testing.assert_allclose(sigma[:, 0], -K0 * in_water(y), rtol=1e-12)
    assert not sim.warnings


TOP = {"box": {"min": [-1.0, 4.5], "max": [4.0, 6.0]}}


LAKE = {"region": TOP, "hydrostatic": {"level": 7.0, "density": 1.0}}


@pytest.mark.parametrize(
    ("law", "dimension", "load", "parts"),
    [
        ("hooke", 1, {"face": "x-max", "traction": [-2.0]}, {}),
        wide("hooke", 3, {"face": "z-max", "traction": [0.0, 0.0, -2.0]}, {}),
        ("hooke", 2, {"face": "y-max", "pressure": 2.0}, {"geometry": "axisymmetric"}),
        ("neo-hookean", 2, {"region": TOP, "pressure": 2.0}, {}),
        wide("hooke", 2, {"region": TOP, "traction": [0.0, -2.0], "follower": False}, {}),
        ("hooke", 2, LAKE, {}),
        wide("hooke", 2, {"region": TOP, "pressure": 2.0}, {"geometry": "axisymmetric"}),
        wide("hooke", 2, LAKE, {"geometry": "axisymmetric"}),
        ("hooke", 2, {"face": "y-max", "pressure": 2.0}, {"formulation": "total-lagrangian"}),
    ],
)
def test_surcharges_of_all_kinds_leave_ground_at_rest(law, dimension, load, parts):
    parts = dict(parts)
    configuration = parts.pop("formulation", "updated-lagrangian")
    load = {"fill": load | {"body": "body"}}
    case = ground(law, dimension, water=WATER, tractions=load, **parts)
    case["start"]["stress"]["surcharge"] = ["fill"]
    case["bodies"]["body"]["formulation"] = configuration
    if parts:
        del case["boundaries"]["x-min"]
    most, sim = fastest(case, 300)
    assert most < 1e-12
    sigma, y = sim.particles.sigma[sim.live(), dimension - 1], depth(sim, dimension - 1)
    np.testing.assert_allclose(sigma, -in_water(y), rtol=1e-12)


@pytest.mark.parametrize(("level", "dry"), [(9.0, 0.0), (3.1, None), (-1.0, 5.0)])
def test_water_may_stand_above_ground_within_a_particle_or_below_all(level, dry):
    """Above ground it presses on no grains: effective stresses are those of a level there."""
    most, sim = fastest(ground("hooke", water=WATER | {"level": level}), 300)
    assert most < 1e-12
    if dry is not None:
        y = depth(sim, 1)
        sigma = sim.particles.sigma[sim.live(), 1]
        np.testing.assert_allclose(sigma, -in_water(y, dry, 0.0), rtol=1e-12)


def test_only_the_bodies_that_water_fills_are_lighter():
    case = ground("hooke", water=WATER | {"bodies": ["low"]})
    case["bodies"] = {"low": box([0.0, 0.0], [3.0, 2.0]), "high": box([0.0, 2.0], [3.0, 5.0])}
    most, sim = fastest(case, 300)
    assert most < 1e-12
    sigma, y = sim.particles.sigma[sim.live(), 1], depth(sim, 1)
    np.testing.assert_allclose(sigma, -in_water(y, 3.0, 0.0), rtol=1e-12)


@pytest.mark.parametrize("density", [1.0, {"table": [[0.0, 2.0], [6.0, 1.0]], "over": "y"}])
def test_what_falls_in_water_has_its_weight_in_water(density):
    case = ground("hooke", water=WATER | {"level": 9.0}) | {"start": {}, "boundaries": {}}
    case["materials"]["soft"]["density"] = density
    case["bodies"]["body"]["region"] = {"box": {"min": [0.0, 4.0], "max": [3.0, 6.0]}}
    sim = start(case)
    p, rows = sim.particles, sim.live()
    before, weight = p.x[rows, 1].copy(), p.m[rows] - 0.4 * p.V0[rows]
    for _ in range(20):
        sim.advance()
    line = sim.diagnostics()
    assert line["momentum-y"] == pytest.approx(-weight.sum() * sim.time, rel=1e-12)
    work = weight @ (before - p.x[rows, 1])
    assert line["external-work"] == pytest.approx(work, rel=1e-12)


def test_ground_that_is_drained_settles_under_its_whole_weight():
    case = ground("hooke", water=WATER | {"level": 5.0})
    case["time"]["end"] = 1e-3
    rest = {"name": "drained", "equilibrate": {"tolerance": 1e-6}, "water": None}
    case["time"]["stages"] = [rest]
    sim = start(case)
    while not sim.finished:
        if sim.stage_done:
            sim.next_stage()
        sim.advance()
    sigma, y = sim.particles.sigma[sim.live()], depth(sim, 1)
    for cell in range(HIGH):  # the strain is that of a cell: so is what is added
        mean = sigma[np.floor(y) == cell].mean(axis=0)
        assert mean[1] == pytest.approx(-(cell + 0.5), rel=5e-3)
        assert mean[0] == pytest.approx(-(K0 * 0.6 + 0.4 * 0.3 / 0.7) * (cell + 0.5), rel=5e-3)


def test_a_stage_that_turns_the_vertical_says_what_its_water_is():
    case = ground("hooke", water=WATER)
    turned = {"name": "turned", "end": 9e9, "gravity": [1.0, 0.0]}
    for stage in (turned, turned | {"gravity": [0.0, 1.0]}):
        case["time"]["stages"] = [stage]
        with pytest.raises(ValueError, match=r"stages\.0\.gravity\s+turns the vertical"):
            Case.model_validate(case)
        for water in (None, WATER | {"level": 1.0}):
            case["time"]["stages"] = [stage | {"water": water}]
            Case.model_validate(case)
