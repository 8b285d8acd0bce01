"""Rigid bodies that move freely: momentum, exact solutions, any ratio of masses, restarts."""

from math import cos, exp, pi, radians, sin

import numpy as np
import pytest
from free_rigid import configured, free, momenta, struck
from scenes import box, energy, finish, scene, start

from pgimp.case.schema import Case
from pgimp.errors import CaseError, RunError
from pgimp.scene.rigid.bulk import bulk, everywhere
from pgimp.scene.rigid.free_body import FreeBody, State

pytestmark = pytest.mark.slow(75)


@pytest.mark.parametrize("law", [{"friction": 0.3}, {"law": "tie"}])
@pytest.mark.parametrize("density", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_momentum_at_any_ratio_of_masses(configuration, D, density, law):
    """What the body loses the block gets, and no energy comes from nothing."""
    sim = start(configured(struck(D, law, density), configuration))
    lines = [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        lines.append(sim.diagnostics())
    total = np.array([momenta(line)[:3] + momenta(line, "ball")[:3] for line in lines])
    # What reaches vertices too light to be accelerated is lost, as without rigid bodies.
    assert total == pytest.approx(np.tile(total[0], (len(total), 1)), abs=2e-10 * max(1.0, density))
    every = np.array([energy(line) + line["rigid.ball.kinetic-energy"] for line in lines])
    assert (every < every[0] * (1.0 + 1e-3)).all()
    assert momenta(lines[-1])[0] > 0.5 * momenta(lines[0], "ball")[0] / (1.0 + density)
    body, state = sim.rank.free.now[0]
    booked = sim.rank.ledger.rigid_bodies[:, 0, :6].sum(axis=0)
    gained = np.array([*state.momentum, *state.spin])
    gained -= [*body.first.momentum, *body.first.spin]
    assert gained == pytest.approx(booked, abs=1e-12 * max(1.0, density))


@pytest.mark.parametrize(
    "configuration", ["current", pytest.param("initial", marks=pytest.mark.wide)]
)
def test_a_body_stops_on_a_bar_as_waves_say(configuration):
    """v = v0 exp(-rho c A t/M) until waves return: three per cent of v0, then two."""
    for cells, off in ((2, 0.03), (4, 0.015)):
        h = 1.0 / cells
        bodies = {"bar": box([4.0], [24.0]), "mass": free([1.0], [4.0], 10.0 / 3.0, [0.5])}
        case = scene(1, bodies, cells=[30 * cells], cell=h, end=2.0, step=0.02 * h,
                     contact=[{"bodies": "all"}])  # fmt: skip
        line = finish(start(configured(case, configuration))).diagnostics()
        assert line["rigid.mass.velocity-x"] == pytest.approx(0.5 * exp(-2.0), abs=0.5 * off)


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_stage_goes_on_with_the_motion(configuration):
    """The rehearsal of later stages has the bodies' measures; a stage that changes nothing too."""
    case = configured(struck(2, {"friction": 0.3}, 1.0), configuration)
    whole = finish(start(case)).diagnostics()
    case["time"] |= {"end": 0.5 * case["time"]["end"],
                     "stages": [{"name": "next", "end": case["time"]["end"]}]}  # fmt: skip
    line = finish(start(case)).diagnostics()
    for name in ("rigid.ball.velocity-x", "rigid.ball.velocity-y", "kinetic-energy"):
        assert line[name] == pytest.approx(whole[name], rel=1e-4)  # impulses are known to 1e-5


@pytest.mark.wide
@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_heavy_body_is_a_tool(configuration):
    """What it meets is deformed as by one that moves as prescribed."""
    lines = []
    for rigid in ({"density": 1e7}, {"velocity": [1.0, 0.3]}):
        case = struck(2, {"friction": 0.3}, 1.0)
        case["bodies"]["ball"]["rigid"] = rigid
        if "density" not in rigid:
            del case["bodies"]["ball"]["velocity"]
        lines.append(finish(start(configured(case, configuration))).diagnostics())
    for name in ("momentum-x", "rigid.ball.work"):
        assert lines[0][name] == pytest.approx(lines[1][name], rel=0.08)


def test_a_body_that_meets_nothing():
    """It falls as a particle does, by symplectic Euler's rule, and keeps its spin."""
    bodies = {
        "soft": box([12.0, 9.0], [13.0, 10.0]),
        "ball": free([4.0, 4.0], [6.0, 6.0], 3.0,
                     {"rotation": {"about": [5.0, 5.0], "rate": 0.7}, "translation": [0.2, 0.4]}),
        "held": free([4.0, 1.0], [6.0, 3.0], 3.0, fixed=["x", "rotation"]),
    }  # fmt: skip
    case = scene(2, bodies, cells=[16, 12], gravity=[1.0, -1.0], boundaries={"y-max": "slip"},
                 contact=[{"bodies": "all", "friction": 0.3}])  # fmt: skip
    sim = finish(start(case))
    line, dt = sim.diagnostics(), 0.01
    assert line["rigid.ball.velocity-y"] == pytest.approx(0.4 - 1.0, abs=1e-13)
    assert line["rigid.ball.displacement-y"] == pytest.approx(0.4 - 0.5 * (1.0 + dt), abs=1e-13)
    assert line["rigid.ball.angle-z"] == pytest.approx(0.7, abs=1e-13)
    assert line["rigid.held.displacement-x"] == 0.0
    assert line["rigid.held.displacement-y"] == pytest.approx(-0.5 * (1.0 + dt), abs=1e-13)
    arm, v = (
        (5.0 + line["rigid.ball.displacement-x"], 5.0 + line["rigid.ball.displacement-y"]),
        12.0,
    )
    own = v * 4.0 / 6.0 * 0.7  # M a^2/6
    moment = arm[0] * line["rigid.ball.momentum-y"] - arm[1] * line["rigid.ball.momentum-x"]
    assert line["rigid.ball.angular-momentum-z"] == pytest.approx(own + moment, abs=1e-11)


@pytest.mark.parametrize(("low", "high", "said"), [
    ([2.0, -0.2], [4.0, 2.0], "0.2 cells into the wall y-min"),
    ([-0.5, 2.0], [2.0, 4.0], "0.5 cells into the wall x-min"),
    ([7.3, 5.0], [9.0, 7.0], " cells into the rigid body 'post'"),
    ([5.0, 0.0], [6.8, 2.0], None),  # touches a wall, and the post
    ([5.0, 8.5], [7.0, 10.5], None),  # where the domain is open
])  # fmt: skip
def test_what_begins_in_a_wall_or_a_rigid_body_is_refused(low, high, said):
    """They would not feel each other: where, how deep, and what to do, before the first step."""
    bodies = {
        "stone": free(low, high, 2.0),
        "post": {"rigid": {}, "region": {"box": {"min": [6.8, 0.0], "max": [7.8, 6.0]}}},
        "soft": box([2.0, 5.0], [4.0, 7.0]),
    }
    case = scene(2, bodies, cells=[12, 10], contact=[{"bodies": "all"}],
                 boundaries={"x-min": "slip", "y-min": "unilateral"})  # fmt: skip
    if said is None:
        start(case)
        return
    with pytest.raises(CaseError, match=r"bodies\.stone\.region: reaches") as raised:
        start(case)
    assert said in str(raised.value) and "move it, or cut it" in str(raised.value)


def test_a_top():
    """Torque-free: |L| exact, energy of second order; a symmetric one precesses at L/I."""

    def turn(n):
        entry = Case.model_validate(scene(3, {
            "soft": box([1.0] * 3, [2.0] * 3),
            "top": free([4.0, 4.0, 4.0], [6.0, 6.0, 5.0], 1.0,
                        {"rotation": {"about": [5.0, 5.0, 4.5], "rate": [1.0, 0.0, 3.0]}}),
        })).rigid_bodies["top"]  # fmt: skip
        body = FreeBody("top", entry, bulk(entry.region, 1.0, everywhere(3)), 3)
        state, dt = body.first, 2.0 / n
        for _ in range(n):
            inertia = body.halfway(state, dt)
            state = body.moved(state, (*state.momentum, *state.spin), inertia, dt)
        return body, state

    errors = []
    for n in (200, 400):
        body, state = turn(n)
        L = np.array(body.first.spin)
        assert np.array(state.spin) == pytest.approx(L, abs=1e-14)
        across, along = 4.0 * (4.0 + 1.0) / 12.0, 4.0 * 8.0 / 12.0
        assert L == pytest.approx([across, 0.0, 3.0 * along])
        # Its axis turns about L with the angular velocity |L|/I.
        n_L, rate = L / np.linalg.norm(L), np.linalg.norm(L) / across
        a0, angle = np.array([0.0, 0.0, 1.0]), 2.0 * rate
        axis = (a0 * cos(angle) + np.cross(n_L, a0) * sin(angle)
                + n_L * (n_L @ a0) * (1.0 - cos(angle)))  # fmt: skip
        now = np.array(body.pose(state).turn).reshape(3, 3) @ a0
        errors.append(np.abs(now - axis).max())
        assert body.energy(state) == pytest.approx(body.energy(body.first), rel=0.02 / n**2)
    assert errors[0] < 7e-5
    assert errors[1] == pytest.approx(errors[0] / 4.0, rel=0.1)


@pytest.mark.parametrize("D", [2, 3])
def test_mass_and_inertia(D):
    """Of a box exact, of a ball to 2e-6; turned boxes as well."""
    half, centre = [1.0, 1.5, 0.5], [5.0, 4.0, 3.0]
    low = [c - a for c, a in zip(centre[:D], half, strict=False)]
    high = [c + a for c, a in zip(centre[:D], half, strict=False)]
    ball = {"ball": {"centre": centre[:D], "radius": 1.3}}
    for region, (tolerance, mass, square) in (
        ({"box": {"min": low, "max": high}}, (1e-13, 12.0, (1.0 + 1.5**2) / 3.0)),
        (ball, (2e-6, 2.0 * pi * 1.3**2 * (4.0 / 3.0 * 1.3 if D == 3 else 1.0),
                (0.4 if D == 3 else 0.5) * 1.3**2)),
    ):  # fmt: skip
        bodies = {"soft": box([1.0] * D, [2.0] * D),
                  "rigid": {"rigid": {"density": 2.0}, "region": region}}  # fmt: skip
        region = Case.model_validate(scene(D, bodies)).rigid_bodies["rigid"].region
        found = bulk(region, 2.0, everywhere(D))
        assert found.mass == pytest.approx(mass, rel=tolerance)
        assert found.inertia[8] == pytest.approx(mass * square, rel=tolerance)
        assert found.centre[:D] == pytest.approx(centre[:D], rel=1e-9)


@pytest.mark.wide
@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_rigid_cylinder_rolls_down(configuration):
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
    sim = start(configured(case, configuration))
    rows = []
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        if line["time"] > 4.0:
            names = "time", "rigid.roll.velocity-x", "rigid.roll.angular-velocity-z"
            rows.append([line[name] for name in names])
    time, velocity, spin = np.transpose(rows)  # it bounces, too: by a fit
    gained, spun = (np.polyfit(time, each, 1)[0] for each in (velocity, spin))
    assert gained == pytest.approx(2.0 / 3.0 * g * sin(slope), rel=0.02)
    assert -R * spun == pytest.approx(gained, rel=0.03)


def test_states_are_numbers():
    state = State.of([float(i) for i in range(16)])
    assert state.turn == (3.0, 4.0, 5.0, 6.0)
    assert State.of(state.numbers) == state


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rigid": {"density": -1.0}}, "density"),
        ({"rigid": {"density": 1.0, "velocity": [1.0, 0.0]}}, "velocity"),
        ({"rigid": {"density": 1.0, "fixed": ["z"]}}, "bodies.ball.rigid.fixed.0"),
        ({"rigid": {"density": 1.0, "fixed": ["x"]}}, "`fixed` excludes"),
        ({"rigid": {}}, "moves as `rigid` says"),
        ({"velocity": [1.0]}, "bodies.ball.velocity"),
        ({"velocity": {"rotation": {"about": [1.0, 1.0], "rate": [1.0, 0.0, 0.0]}}}, "in 2D"),
        ({"velocity": [200.0, 0.0]}, "moves by 2 cells in a step"),
        ({"rigid": {"density": 1e-12}}, "rounding decides"),
    ],
)
def test_what_cannot_be_is_refused(change, said):
    case = struck(2, {"friction": 0.1}, 1.0)
    case["bodies"]["ball"] = case["bodies"]["ball"] | change
    with pytest.raises((CaseError, ValueError, RunError)) as raised:
        finish(start(case))
    assert said in str(raised.value)
