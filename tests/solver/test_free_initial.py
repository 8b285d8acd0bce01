"""Rigid bodies that move freely, and bodies in the initial configuration that they meet."""

from math import cos, exp, radians, sin

import numpy as np
import pytest
from free_rigid import free, momenta, struck
from scenes import box, energy, finish, scene, start


def begun(case):
    """The case with all bodies of a material in the initial configuration."""
    case["bodies"] = {
        name: body if "rigid" in body else body | {"configuration": "initial"}
        for name, body in case["bodies"].items()
    }
    return case


@pytest.mark.parametrize("law", [{"friction": 0.3}, {"law": "tied"}])
@pytest.mark.parametrize("density", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("D", [1, 2, 3])
def test_momentum_at_any_ratio_of_masses(D, density, law):
    """What the body loses the block gets, and no energy comes from nothing."""
    sim = start(begun(struck(D, law, density)))
    lines = [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        lines.append(sim.diagnostics())
    total = np.array([momenta(line)[:3] + momenta(line, "ball")[:3] for line in lines])
    assert total == pytest.approx(np.tile(total[0], (len(total), 1)), abs=2e-10 * max(1.0, density))
    every = np.array([energy(line) + line["tool.ball.kinetic-energy"] for line in lines])
    assert (every < every[0] * (1.0 + 1e-3)).all()
    assert momenta(lines[-1])[0] > 0.5 * momenta(lines[0], "ball")[0] / (1.0 + density)
    body, state = sim.rank.free.now[0]
    booked = sim.rank.ledger.tools[:, 0, :6].sum(axis=0)
    gained = np.array([*state.momentum, *state.spin])
    gained -= [*body.first.momentum, *body.first.spin]
    assert gained == pytest.approx(booked, abs=1e-12 * max(1.0, density))


def test_a_body_stops_on_a_bar_as_waves_say():
    """v = v0 exp(-rho c A t/M) until waves return: three per cent of v0, then two."""
    for cells, off in ((2, 0.03), (4, 0.015)):
        h = 1.0 / cells
        bodies = {"bar": box([4.0], [24.0]), "mass": free([1.0], [4.0], 10.0 / 3.0, [0.5])}
        case = scene(1, bodies, cells=[30 * cells], cell=h, end=2.0, step=0.02 * h,
                     contact=[{"bodies": "all"}])  # fmt: skip
        line = finish(start(begun(case))).diagnostics()
        assert line["tool.mass.velocity-x"] == pytest.approx(0.5 * exp(-2.0), abs=0.5 * off)


def test_a_heavy_body_is_a_tool():
    """What it meets is deformed as by one that moves as prescribed."""
    lines = []
    for rigid in ({"density": 1e7}, {"velocity": [1.0, 0.3]}):
        case = struck(2, {"friction": 0.3}, 1.0)
        case["bodies"]["ball"]["rigid"] = rigid
        if "density" not in rigid:
            del case["bodies"]["ball"]["velocity"]
        lines.append(finish(start(begun(case))).diagnostics())
    for name in ("momentum-x", "tool.ball.work"):
        assert lines[0][name] == pytest.approx(lines[1][name], rel=0.08)


@pytest.mark.parametrize(
    ("law", "two"), [({}, False), ({"friction": 0.4}, False), ({"law": "tied"}, False),
                     ({}, True), ({"friction": 0.4}, True)],
)  # fmt: skip
@pytest.mark.parametrize("density", [0.05, 20.0])
@pytest.mark.parametrize("configurations", ["initial", "both"])
def test_the_energy_of_the_whole_is_the_sum_of_its_columns(density, law, two, configurations):
    """Whatever a body loses at once as it hits is in impact-loss, and in what is dissipated.

    In 2D its moment of inertia is constant, and the sum is exact: to rounding.
    """
    bodies = {"block": box([1.0, 1.0], [4.0, 4.0]), "next": box([4.0, 1.0], [7.0, 4.0]),
              "ball": {"rigid": {"density": density}, "velocity": [1.0, -2.0],
                       "region": {"ball": {"centre": [3.0, 5.6], "radius": 1.5}}}}  # fmt: skip
    if two:
        bodies["other"] = {"rigid": {"density": 3.0, "fixed": ["x", "rotation"]},
                           "velocity": [0.0, -1.0],
                           "region": {"box": {"min": [5.0, 4.1], "max": [6.8, 6.0]}}}  # fmt: skip
    case = begun(scene(2, bodies, cells=[10, 9], end=0.6, step={"courant": 0.3},
                       contact=[{"bodies": list(bodies), **law}]))  # fmt: skip
    if configurations == "both":
        del case["bodies"]["next"]["configuration"]
    sim, tools = start(case), [name for name in ("ball", "other") if name in bodies]
    sums, works = [], []
    while not sim.finished:
        line = sim.diagnostics()
        kinetic = sum(line[f"tool.{name}.kinetic-energy"] for name in tools)
        sums.append(energy(line) + line["dissipated-energy"] + kinetic)
        works.append(sum(line[f"tool.{name}.work"] for name in tools))
        assert line["external-work"] == pytest.approx(works[-1], abs=1e-12 * sums[0])
        sim.advance()
    assert works[-1] > 0.05 * sums[0]
    assert np.abs(np.array(sums) / sums[0] - 1.0).max() < 1e-12
    assert line["contact." + "+".join(bodies) + ".impact-loss"] > 0.0
    assert line["dissipated-energy"] > 0.0


def test_a_rigid_cylinder_rolls_down():
    """On a bed that is hardly deformed it gains 2/3 g sin, and spins as it rolls."""
    slope, g, R = radians(20.0), 0.2, 8.0
    bodies = {
        "bed": box([0.0, 0.0], [44.0, 3.0]),
        "roll": {"rigid": {"density": 1.0},
                 "region": {"ball": {"centre": [8.0, 3.0 + R], "radius": R}}},
    }  # fmt: skip
    weight = {"table": [[0.0, [0.0, 0.0]], [4.0, [g * sin(slope), -g * cos(slope)]]]}
    case = scene(2, bodies, cells=[44, 20], end=14.0, step={"courant": 0.4}, gravity=weight,
                 contact=[{"bodies": "all", "friction": 0.5}],
                 boundaries={"y-min": "fixed", "x-min": "slip", "x-max": "slip"})  # fmt: skip
    case["materials"]["soft"] = {**case["materials"]["soft"], "young": 1000.0}
    case["method"]["affine"] = True
    sim = start(begun(case))
    lines = []
    for time in (4.0, 14.0):
        while sim.time < time and not sim.finished:
            sim.advance()
        lines.append(sim.diagnostics())
    gained = (lines[1]["tool.roll.velocity-x"] - lines[0]["tool.roll.velocity-x"]) / 10.0
    spun = (lines[1]["tool.roll.angular-velocity-z"] - lines[0]["tool.roll.angular-velocity-z"])
    print(gained / (2.0 / 3.0 * g * sin(slope)), -R * spun / 10.0 / gained)
    assert gained == pytest.approx(2.0 / 3.0 * g * sin(slope), rel=0.02)
    assert -R * spun / 10.0 == pytest.approx(gained, rel=0.03)
