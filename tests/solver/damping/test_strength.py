"""Factors of safety by strength reduction, against exact results of the infinite slope."""

from math import asin, cos, radians, sin, tan

import pytest
from scenes import box, scene, start

from pgimp.errors import NoRestError

pytestmark = pytest.mark.slow(30)

SLOPE, FRICTION, WEIGHT = radians(20.0), 30.0, 10.0


def infinite(factor, dilation, model):
    """Soil of depth 1 on a rough plane, by tilted gravity between periodic ends."""
    soil = {
        "model": model, "density": 1.0, "young": 1e5, "poisson": 0.3, "cohesion": 0.0,
        "friction-angle": FRICTION, "dilation-angle": dilation,
    }  # fmt: skip
    if model == "drucker-prager":
        soil["match"] = "plane-strain-flow"
    rest = {"tolerance": 1e-4}
    case = scene(
        2, box([0.0, 0.0], [1.0, 1.0], material="soil"), cells=[4, 6], cell=0.25, end=2e-3,
        step={"courant": 0.4}, materials={"soil": soil}, start={"equilibrate": rest},
        gravity=[WEIGHT * sin(SLOPE), -WEIGHT * cos(SLOPE)],
        boundaries={"x-min": "periodic", "x-max": "periodic", "y-min": "fixed"},
    )  # fmt: skip
    case["method"]["volumetric"] = "b-bar"
    weak = {"name": "weak", "strength": {"factor": factor}, "equilibrate": rest | {"steps": 2000}}
    case["time"]["stages"] = [weak]
    return case


def stands(case):
    sim = start(case)
    try:
        while not sim.finished:
            sim.advance()
    except NoRestError:
        assert sim.stage == 1
        return False
    return True


@pytest.mark.parametrize("model", ["mohr-coulomb", "drucker-prager"])
@pytest.mark.parametrize("dilation", [FRICTION, 0.0])
def test_an_infinite_slope_stands_up_to_its_factor_of_safety(model, dilation):
    """Sliding without strain along the plane: tau/sigma is tan(phi), or sin(phi) undilated."""
    limit = tan(SLOPE) if dilation else tan(asin(tan(SLOPE)))
    F = tan(radians(FRICTION)) / limit
    assert F == pytest.approx(1.58626 if dilation else 1.47746, abs=1e-5)
    assert stands(infinite(0.993 * F, dilation, model))
    assert not stands(infinite(1.007 * F, dilation, model))


def test_a_stage_does_not_rest_before_its_strength_has_acted():
    """Forces of its first step are those of the stage before, also where that one is compared."""
    case = infinite(2.0, 0.0, "mohr-coulomb")
    case["time"] |= {"step": 2e-4, "end": 9 * 2e-4}
    case["time"]["stages"][0]["equilibrate"]["steps"] = 100
    sim = start(case)
    while sim.preparing:
        sim.advance()
    assert sim.step % 10 == 0 and sim.unbalanced < 1e-4
    assert not stands(case)
