"""Starts with the stress of the weight above: it is in balance, and is what the column says."""

import re

import numpy as np
import pytest
from level_ground import HIGH, K0, LAWS, WIDE, depth, fastest, ground
from scenes import box, start

from pgimp.case.schema import Case
from pgimp.scene.bodies.prestrain import find_deformation, unknowns_along

pytestmark = pytest.mark.slow(40)


@pytest.mark.parametrize("law", LAWS)
def test_level_ground_stays_at_rest(law):
    case = ground(law)
    sim = start(case)
    sigma, y = sim.particles.sigma[sim.live()], depth(sim, 1)
    np.testing.assert_allclose(sigma[:, 1], -y, rtol=1e-12)
    np.testing.assert_allclose(sigma[:, 0], -K0 * y, rtol=1e-12)
    if law != "neo-hookean":  # of which zz follows
        np.testing.assert_allclose(sigma[:, 2], -K0 * y, rtol=1e-12)
    p, rows = sim.particles, sim.live()
    np.testing.assert_allclose(p.V0[rows] * np.linalg.det(p.F[rows].reshape(-1, 2, 2)), 0.25)
    assert p.m[rows].sum() == pytest.approx(WIDE * HIGH)
    most, sim = fastest(case)
    assert most < 1e-12
    assert not sim.warnings


def test_neo_hookean_ground_in_space_has_one_stress_across():
    """Against the law by hand: s = mu/J (b - 1) + lambda ln J/J."""
    sim = start(ground("neo-hookean", 3))
    p, rows = sim.particles, sim.live()
    F = p.F[rows].reshape(-1, 3, 3)
    b, J = np.einsum("nij,nkj->nik", F, F), np.linalg.det(F)
    mu = 1000.0 / 2.6
    lam = 2.0 * mu * 0.3 / 0.4
    sigma = mu / J[:, None] * (np.einsum("nii->ni", b) - 1.0) + (lam * np.log(J) / J)[:, None]
    wanted = -depth(sim, 2)[:, None] * np.array([K0, K0, 1.0])
    np.testing.assert_allclose(sigma, wanted, rtol=1e-10)


@pytest.mark.parametrize("contact", [False, True])
def test_layers_weigh_on_those_below(contact):
    case = ground("hooke")
    case["materials"]["stiff"] = case["materials"]["soft"] | {"young": 3000.0, "density": 2.0}
    case["bodies"] = {"low": box([0.0, 0.0], [3.0, 2.0], None, "stiff"),
                      "high": box([0.0, 2.0], [3.0, 5.0])}  # fmt: skip
    case["start"] = {"stress": {"k0": {"low": 1.0, "high": K0}}}
    if contact:
        case["contact"] = [{"bodies": "all", "friction": 0.5}]
    sim = start(case)
    y, sigma = depth(sim, 1), sim.particles.sigma[sim.live()]
    low = y > 3.0
    vertical = np.where(low, 3.0 + 2.0 * (y - 3.0), y)
    np.testing.assert_allclose(sigma[:, 1], -vertical, rtol=1e-12)
    np.testing.assert_allclose(sigma[:, 0], -np.where(low, 1.0, K0) * vertical, rtol=1e-12)
    assert fastest(case, 300)[0] < 1e-12


WATER = {"level": 3.0, "density": 0.4}


def test_a_slope_has_the_weight_of_its_columns_and_settles_sooner():
    """It is not at rest: the largest velocity is told in docs/case-file.md."""
    case = ground("hooke")
    slope = {"half-space": {"point": [1.5, 4.0], "normal": [0.2, 1.0]}}
    case["bodies"]["body"]["region"] = {
        "intersection": [{"box": {"min": [0.0, 0.0], "max": [3.0, 7.0]}}, slope]
    }
    sim = start(case)
    x = sim.particles.x[sim.live()]
    above = 4.3 - 0.2 * x[:, 0] - x[:, 1]
    deep = above > 0.6
    np.testing.assert_allclose(sim.particles.sigma[sim.live(), 1][deep], -above[deep], atol=0.02)
    assert 1e-6 < fastest(case, 300)[0] < 2e-3

    def steps(start_entry):
        sim = start(case | {"start": start_entry})
        while sim.settling:
            sim.advance()
        return sim.step

    settle = {"equilibrate": {"tolerance": 1e-3}}
    assert steps(case["start"] | settle) < steps(settle)


def test_gravity_may_act_along_any_axis():
    case = ground("hooke")
    case["gravity"] = [2.0, 0.0]
    sigma = start(case).particles.sigma
    sim = start(case)
    weight = 2.0 * sim.particles.x[sim.live(), 0]
    np.testing.assert_allclose(sigma[sim.live(), 0], -weight, rtol=1e-12)
    np.testing.assert_allclose(sigma[sim.live(), 1], -K0 * weight, rtol=1e-12)


def test_jaky_and_overconsolidation():
    sim = start(ground("mohr-coulomb", k0="1-sin-phi"))
    sigma = sim.particles.sigma[sim.live()]
    np.testing.assert_allclose(sigma[:, 0], 0.5 * sigma[:, 1], rtol=1e-12)
    case = ground("cam-clay")
    case["start"]["stress"]["ocr"] = 1.5
    sim = start(case)
    y, pc = depth(sim, 1), sim.particles.state[sim.live(), 0]
    p, q = y * (1.0 + 2.0 * K0) / 3.0, y * (1.0 - K0)
    np.testing.assert_allclose(pc, 1.5 * (p + q * q / p), rtol=1e-12)  # M = 1


def test_strength_that_does_not_bear_the_stress_is_told():
    (text,) = start(ground("mohr-coulomb", k0=0.1)).warnings
    assert re.search(r"start\.stress: the stress of \d+ of 60 particles of 'body' is beyond", text)


STONE = {"rigid": {"density": 3.0}, "region": {"ball": {"center": [1.5, 6.0], "radius": 1.0}}}


@pytest.mark.parametrize(
    ("law", "change", "text"),
    [
        ("hooke", {"gravity": [1.0, -1.0]}, "gravity has to act along one axis"),
        ("hooke", {"gravity": None}, "gravity has to act along one axis"),
        ("hooke", {"start": {"stress": {"k0": {"bod": 0.5}}}}, "did you mean 'body'"),
        ("hooke", {"start": {"stress": {"k0": "1-sin-phi"}}}, "needs the friction-angle"),
        ("hooke", {"start": {"stress": {"k0": 0.5, "ocr": 2.0}}}, "is of cam-clay"),
        ("neo-hookean", {"formulation": "total-lagrangian"}, "total-lagrangian begins undeformed"),
        (
            "hooke",
            {"stone": STONE},
            "'stone' moves freely.*: prescribe its velocity, or make it a body of stiff .* `force`",
        ),
        ("hooke", {"water": WATER, "gravity": None, "start": {}}, r"water\s+needs gravity"),
        ("hooke", {"water": WATER, "gravity": [1.0, 1.0], "start": {}}, r"water\s+needs gravity"),
        ("hooke", {"water": WATER | {"density": 1.0}}, "above that of water, 1: take the sat"),
        ("hooke", {"water": WATER | {"bodies": ["bod"]}}, "did you mean 'body'"),
        ("hooke", {"water": {"level": 3.0}}, "water.density"),
        ("hooke", {"water": WATER | {"bodies": []}}, "names no body"),
        ("hooke", {"start": {"stress": {"k0": 1.0, "surcharge": ["fil"]}}}, "surcharge.*'fil'"),
    ],
)
def test_what_has_no_such_stress_is_refused(law, change, text):
    case = ground(law)
    for key, value in change.items():
        if key == "formulation":
            case["bodies"]["body"][key] = value
        elif key == "stone":
            case["bodies"][key] = value
        else:
            case[key] = value
    with pytest.raises(ValueError, match=text):
        Case.model_validate(case)


def test_a_particle_has_its_deformation_whatever_others_are_with_it():
    sim = start(ground("neo-hookean", k0=0.9))
    p, rows = sim.particles, sim.live()
    wanted, together = p.sigma[rows].copy(), p.F[rows].copy()
    wanted[:, 0], wanted[:, 1] = -0.9 * depth(sim, 1), -depth(sim, 1)
    unknowns = unknowns_along(sim.scene, "body", 1)
    for row, sigma, F in zip(rows.tolist(), wanted, together, strict=True):
        one = p, np.array([row])
        find_deformation(sim.scene, one, "body", sigma[None], unknowns, ("the weight", ""))
        assert np.array_equal(p.F[row], F)
