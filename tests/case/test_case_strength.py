"""Strength reduction in a stage: which parameters of which materials, and what is refused."""

from math import degrees, radians, tan

import pytest
from scenes import SOFT, box, scene

import pgimp
from pgimp.errors import CaseError

SOIL = {
    "model": "mohr-coulomb", "young": 100.0, "poisson": 0.3, "density": 1.0, "cohesion": 1.3,
    "friction_angle": 20.0, "dilation-angle": 18.0, "tension": 0.65,
}  # fmt: skip
CONE = {**SOIL, "model": "drucker-prager", "friction_angle": 30.0, "dilation-angle": 30.0}
CONE |= {"cohesion": 0.0, "tension": None}


def staged(*stages, materials=("soil", "cone", "soft")):
    every = {"soil": SOIL, "cone": CONE, "soft": SOFT}
    bodies = {
        name: box([float(2 * i), 0.0], [2.0 * i + 2.0, 2.0], material=name)
        for i, name in enumerate(materials)
    }
    case = scene(2, bodies, materials={name: every[name] for name in materials})
    case["time"]["stages"] = [
        {"name": f"s{i}", "end": i + 2.0} | stage for i, stage in enumerate(stages)
    ]
    return case


def test_cohesion_tension_and_tangent_of_friction_are_over_the_factor():
    stages = pgimp.load(staged({"strength": {"factor": 1.3}})).stages
    soil, cone = (stages[1].materials[name] for name in ("soil", "cone"))
    assert soil.cohesion == pytest.approx(1.0, rel=1e-15)
    assert soil.tension == pytest.approx(0.5, rel=1e-15)
    assert tan(radians(soil.friction_angle)) == pytest.approx(tan(radians(20.0)) / 1.3, rel=1e-14)
    assert soil.dilation_angle == soil.friction_angle < 18.0  # no more than friction
    assert cone.cohesion == 0.0 and cone.tension is None
    assert cone.dilation_angle == cone.friction_angle < 30.0
    assert stages[1].materials["soft"] == stages[0].materials["soft"]


def test_a_factor_is_of_the_case_s_strength_not_of_the_stage_before():
    weak = {"strength": {"factor": 1.3, "materials": ["soil"]}}
    more = {"strength": {"factor": 2.0}, "materials": {"soil": {"cohesion": 3.0}}}
    case = pgimp.load(staged(weak, {}, more, {"strength": None}))
    soils = [stage.materials["soil"] for stage in case.stages]
    assert [each.cohesion for each in soils] == pytest.approx([1.3, 1.0, 1.0, 1.5, 3.0])
    assert soils[1] == soils[2] and soils[4].friction_angle == 20.0
    cones = [degrees(radians(stage.materials["cone"].friction_angle)) for stage in case.stages]
    assert cones[0] == cones[1] == cones[2] == pytest.approx(30.0)
    assert tan(radians(cones[3])) == pytest.approx(tan(radians(30.0)) / 2.0)


@pytest.mark.parametrize("factor", [0.5, 1.0])
def test_factors_up_to_one_leave_dilation(factor):
    soil = pgimp.load(staged({"strength": {"factor": factor}})).stages[1].materials["soil"]
    assert soil.dilation_angle == 18.0 and soil.cohesion == 1.3 / factor
    assert (soil.friction_angle == 20.0) == (factor == 1.0)


@pytest.mark.parametrize(
    ("strength", "text"),
    [
        ({"factor": 0.0}, r"stages\.0\.strength\.factor: must be above 0"),
        ({"factor": 1.1, "materials": ["soft"]},
         r"strength\.materials\.0: 'soft' is neo-hookean, which has no cohesion"),
        ({"factor": 1.1, "materials": ["sand"]}, r"strength\.materials\.0: .*sand"),
    ],
)  # fmt: skip
def test_other_materials_are_refused_with_their_reason(strength, text):
    with pytest.raises(CaseError, match=text):
        pgimp.load(staged({"strength": strength}))


def test_without_any_soil_there_is_nothing_to_weaken():
    with pytest.raises(CaseError, match=r"stages\.0\.strength: .*no material has both"):
        pgimp.load(staged({"strength": {"factor": 1.1}}, materials=("soft",)))


def test_soil_that_varies_in_space_is_refused():
    case = staged({"strength": {"factor": 1.1}})
    law = {"random": {"mean": 1.0, "cov": 0.2, "correlation": 1.0}}
    case["materials"]["soil"] = SOIL | {"cohesion": law}
    with pytest.raises(CaseError, match=r"stages\.0\.strength: 'soil' varies in space"):
        pgimp.load(case)
