"""Mass scaling: static answers stay what they are, in longer steps; it is refused where it lies."""

import re

import numpy as np
import pytest
from scenes import box, scene, start
from tiers import wide

import pgimp
from pgimp.errors import CaseError
from pgimp.running.accuracy.books import momentum_books

pytestmark = pytest.mark.slow(60)


def column(factor, **parts):
    """A damped column under its weight on a floor; time goes with the root of the factor."""
    root = factor**0.5
    parts = {"gravity": [0.0, -2.0], "damping": {"mass": 0.6 / root}, "end": 40.0 * root} | parts
    case = scene(2, box([0.0, 0.0], [2.0, 6.0]), cells=[2, 8], step={"courant": 0.4},
                 boundaries=dict.fromkeys(("x-min", "x-max", "y-min"), "slip"),
                 **parts)  # fmt: skip
    if factor != 1.0:
        case["time"]["mass-scaling"] = factor
    return case


def run(case):
    """The simulation at its end, its steps, and the lines of its history at start and end."""
    sim = start(case)
    first, steps = sim.diagnostics(), 0
    while not sim.finished:
        sim.advance()
        steps += 1
    return sim, steps, first, sim.diagnostics()


def by_id(sim, name):
    """A column of the particles by their number."""
    p, rows = sim.particles, sim.live()
    return getattr(p, name)[rows][np.argsort(p.id[rows])]


@pytest.mark.parametrize("gravity", ["constant", wide("table")])
def test_a_column_settles_as_without_in_as_many_steps_of_ten_times_the_length(gravity):
    found = []
    for factor in (1.0, 100.0):
        case = column(factor)
        if gravity == "table":
            rows = [[0.0, [0.0, 0.0]], [5.0 * factor**0.5, [0.0, -2.0]]]
            case["gravity"] = {"table": rows}
        found.append(run(case))
    (plain, steps, _, line), (sim, as_many, first, last) = found
    assert as_many == steps
    assert sim.dt == pytest.approx(10.0 * plain.dt)
    for name, slack in (("sigma", 1e-9), ("x", 1e-12)):
        np.testing.assert_allclose(by_id(sim, name), by_id(plain, name), rtol=slack, atol=slack)
    assert (last["mass-scaling"], last["mass"]) == (100.0, 100.0 * line["mass"])
    assert "mass-scaling" not in line
    for name in ("external-work", "strain-energy", "damped-energy", "dissipated-energy"):
        assert last[name] == pytest.approx(line[name], rel=1e-9)
    # What is lost besides is of the order of a step.
    rest = last["dissipated-energy"] - last["damped-energy"]
    assert abs(rest) < 0.02 * last["external-work"]
    assert first["external-work"] == 0.0
    (text,) = sim.notes
    assert text.startswith("time.mass-scaling: inertia times 100, steps longer by 10;")


def test_a_bar_that_is_pulled_slowly_has_its_static_stress_in_fewer_steps():
    """To a strain of a thousandth in 40 transits, eased in; the stress is E times the strain."""
    stresses, steps = [], []
    for factor in (1.0, 100.0):
        held = {"body": "body", "region": {"box": {"min": [7.0], "max": [9.0]}}}
        case = scene(1, box([0.0], [8.0]), cells=[10], step={"courant": 0.4}, end=60.0,
                     boundaries={"x-min": "fixed"}, damping={"mass": 0.5},
                     constraints={"grip": held | {"velocity": [{"table": [
                         [0.0, 0.0], [10.0, 4e-4], [20.0, 4e-4], [30.0, 0.0]]}]}})  # fmt: skip
        if factor != 1.0:
            case["time"]["mass-scaling"] = factor
        sim, count, *_ = run(case)
        stresses.append(by_id(sim, "sigma")[:10, 0])
        steps.append(count)
    wanted = 100.0 * 0.008 / 7.0
    np.testing.assert_allclose(stresses[0], wanted, rtol=0.001)
    np.testing.assert_allclose(stresses[1], wanted, rtol=0.01)
    assert steps[1] < 0.11 * steps[0]


@pytest.mark.wide
def test_ground_in_water_and_under_a_lake_weighs_what_it_did():
    case = column(100.0, damping=None, water={"level": 3.0, "density": 0.4}, end=1e6)
    case["start"] = {"stress": {"k0": 0.6, "surcharge": ["lake"]}}
    top = {"box": {"min": [-1.0, 5.5], "max": [4.0, 8.0]}}
    lake = {"body": "body", "region": top, "hydrostatic": {"level": 8.0, "density": 0.4}}
    case["tractions"] = {"lake": lake}
    case["gravity"] = [0.0, -0.2]
    sim = start(case)
    y = 6.0 - sim.particles.x[sim.live(), 1]
    wanted = 0.2 * (0.8 + y - 0.4 * np.maximum(y - 3.0, 0.0))
    np.testing.assert_allclose(sim.particles.sigma[sim.live(), 1], -wanted, rtol=1e-9)
    for _ in range(200):
        sim.advance()
    assert np.abs(sim.particles.v[sim.live()]).max() < 1e-13


def test_the_books_of_momentum_close(tmp_path):
    case = column(25.0, end=5.0, history={"every": {"steps": 1}})
    run_ = pgimp.run(case, output=tmp_path / "run")
    (x, y), why = momentum_books(run_.case, run_.history)
    assert not why
    assert abs(y.rest) < 1e-9 * y.scale
    assert abs(x.rest) < 1e-9 * y.scale
    assert "time.mass-scaling: inertia times 25" in (tmp_path / "run" / "log.txt").read_text()


WATER = {"model": "newtonian", "density": 1.0, "bulk": 100.0, "shear-viscosity": 0.1}
BALL = {"rigid": {"density": 3.0}, "region": {"ball": {"center": [1.0, 7.0], "radius": 0.5}}}


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"time": {"mass-scaling": 0.5}}, "mass-scaling.*greater than or equal to 1|at least 1"),
        ({"materials": {"soft": WATER}}, "the density of 'soft' \\(newtonian\\) is more than"),
        ({"boundaries": {"y-min": "absorbing"}}, "waves that y-min absorbs"),
        ({"bodies": {"ball": BALL}}, "'ball' moves freely"),
        ({"bodies": {"body": box([0.0, 0.0], [2.0, 6.0], [0.0, 1.0])}}, "begins with a velocity"),
        ({"inflow": {"body": {"velocity": [0.0, 1.0]}}}, "inflow would not be"),
    ],
)
def test_what_inertia_matters_to_is_refused(change, text):
    case = column(4.0)
    if "damping" in case and "bodies" in change:
        case["damping"] = None
    for key, value in change.items():
        case[key] = {**case.get(key, {}), **value}
    with pytest.raises(CaseError, match=re.compile(text, re.DOTALL)):
        pgimp.load(case)
