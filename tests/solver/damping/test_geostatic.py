"""Starts with the stress of the weight above: it is in balance, and is what the column says."""

import re

import numpy as np
import pytest
from scenes import box, scene, start
from tiers import wide

from pgimp.case.schema import Case
from pgimp.scene.bodies.prestrain import find_deformation, unknowns_along

pytestmark = pytest.mark.slow(90)

SOIL = {"young": 1000.0, "poisson": 0.3, "cohesion": 0.5, "friction-angle": 30.0}
CLAY = {"m": 1.0, "lambda": 0.1, "kappa": 0.02, "void-ratio": 1.0, "shear": 400.0}
LAWS = {
    "hooke": {"young": 1000.0, "poisson": 0.3},
    "neo-hookean": {"young": 1000.0, "poisson": 0.3},
    "von-mises": {"young": 1000.0, "poisson": 0.3, "yield-stress": 10.0},
    "mohr-coulomb": SOIL,
    "cam-clay": CLAY | {"preconsolidation": 10.0},
}
K0, WIDE, HIGH = 0.6, 3, 5


def ground(law, dimension=2, k0=K0, **parts):
    """Level ground on the lines of the grid, 5 high, of density 1 under a gravity of 1."""
    size = [float(WIDE)] * (dimension - 1) + [float(HIGH)]
    sides = {
        f"{axis}-{end}": "slip" for axis in "xyz"[: dimension - 1] for end in ("min", "max")
    }  # fmt: skip
    case = scene(dimension, box([0.0] * dimension, size), cells=[WIDE] * (dimension - 1) + [7],
                 gravity=[0.0] * (dimension - 1) + [-1.0], step={"courant": 0.3}, end=1e6,
                 boundaries=sides | {f"{'xyz'[dimension - 1]}-min": "slip"},
                 start={"stress": {"k0": k0}}, **parts)  # fmt: skip
    case["materials"]["soft"] = {"model": law, "density": 1.0} | LAWS[law]
    return case


def fastest(case, steps=1000):
    """Greatest velocity of a particle in some steps, over the wave speed; and the simulation."""
    sim, most = start(case), 0.0
    speed = sim.rate * min(case["grid"]["cell"])
    for _ in range(steps):
        sim.advance()
        most = max(most, np.abs(sim.particles.v[sim.live()]).max())
    return most / speed, sim


def depth(sim, axis, top=float(HIGH)):
    return top - sim.particles.x[sim.live(), axis]


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
        ("hooke", 2, {"face": "y-max", "pressure": 2.0}, {"configuration": "initial"}),
    ],
)
def test_surcharges_of_all_kinds_leave_ground_at_rest(law, dimension, load, parts):
    parts = dict(parts)
    configuration = parts.pop("configuration", "current")
    load = {"fill": load | {"body": "body"}}
    case = ground(law, dimension, water=WATER, tractions=load, **parts)
    case["start"]["stress"]["surcharge"] = ["fill"]
    case["bodies"]["body"]["configuration"] = configuration
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
    rest = {"name": "drained", "settle": {"tolerance": 1e-6}, "water": None}
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

    settle = {"settle": {"tolerance": 1e-3}}
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
        ("neo-hookean", {"configuration": "initial"}, "initial begins undeformed"),
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
        if key == "configuration":
            case["bodies"]["body"][key] = value
        elif key == "stone":
            case["bodies"][key] = value
        else:
            case[key] = value
    with pytest.raises(ValueError, match=text):
        Case.model_validate(case)


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
