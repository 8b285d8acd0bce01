"""Stages that come to rest: time stands still, displacements and books go on."""

import re

import numpy as np
import pytest
from scenes import SOFT, box, finish, scene, start
from tiers import wide

import pgimp
from pgimp.case.staging.arrange import steps_in
from pgimp.cli import main
from pgimp.errors import CaseError, NoRestError
from pgimp.kernels.data.ledger import DAMPED_ENERGY, DAMPED_MOMENTUM

pytestmark = pytest.mark.slow(40)

#: One-dimensional stiffness of the soft solid.
STIFF = 134.6
STEPS = ({"courant": 0.3}, {"courant": "auto"}, 0.02)
REST = {"name": "dig", "remove": ["top"], "equilibrate": {}}


def column(*stages, configuration="current", step=STEPS[0], **parts):
    """A column of weight 6 on the floor at rest, of which stages take the upper third away."""
    bodies = {
        "low": box([0.0, 0.0], [1.0, 4.0]) | {"formulation": configuration},
        "top": box([0.0, 4.0], [1.0, 6.0]) | {"formulation": configuration},
    }
    walls = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}
    parts = {"start": {"equilibrate": {}}, "gravity": [0.0, -1.0]} | parts
    case = scene(2, bodies, cells=[1, 7], boundaries=walls, end=0.3, step=step, **parts)
    case["time"]["stages"] = [*stages]
    return case


def reached(case, stage):
    """A simulation at the end of a stage."""
    sim = start(case)
    while not (sim.stage == stage and sim.stage_done):
        sim.advance()
    return sim


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_what_is_dug_out_leaves_the_rest_at_rest(configuration, step):
    """The rest rises by the elastic strain under the weight that has gone."""
    case = column(REST, {"name": "on", "end": 0.5}, configuration=configuration, step=step,
                  output={"every": 1.0, "fields": ["displacement"]})  # fmt: skip
    sim = reached(case, 0)
    before, steps = sim.diagnostics(), sim.step
    sim = reached(case, 1)
    line = sim.diagnostics()
    assert line["time"] == before["time"] == 0.3 and line["step"] > steps
    assert line["stages.settling-time"] == pytest.approx((sim.step - steps) * sim.dt, rel=0.2)
    assert line["kinetic-energy"] == 0.0
    assert line["reaction.y-min-y"] == pytest.approx(4.0, rel=3e-3)
    rise = line["body.low.centre-y"] - before["body.low.centre-y"]
    assert rise == pytest.approx(2.0 * 2.0 / STIFF, rel=0.1)
    rows = sim.live()
    moved = (sim.particles.x - sim.particles.origin)[rows, 1].mean()
    if configuration == "current":  # displacements count from time 0
        assert moved == pytest.approx(rise, abs=1e-5)
    steps = sim.step
    finish(sim)
    assert sim.time == 0.5
    line = sim.diagnostics()
    assert line["reaction.y-min-y"] == pytest.approx(4.0, rel=3e-3)
    assert line["kinetic-energy"] < 1e-6 * line["strain-energy"]
    if step == 0.02:
        assert sim.step - steps == 10


@pytest.mark.parametrize(
    "damping", [{"kinetic": True}, *map(wide, ({"mass": 2.0}, {"local": 0.3}))]
)
def test_books_balance_over_a_stage_that_settles(damping):
    """Momentum to rounding: weight and floor over the time of the steps, less what damping took."""
    sim = reached(column(REST, damping=damping), 0)
    sim.next_stage()
    sim.diagnostics()  # the energy at the start

    def books():
        own, line = sim.rank.booked(), sim.diagnostics()
        y = DAMPED_MOMENTUM + 1
        return np.array(
            [
                line["momentum-y"],
                own.impulse[:, 2, 1].sum(),
                line["stages.settling-time"],
                own.damping[:, y].sum(),
            ]
        )

    before = books()
    line = sim.diagnostics()
    while sim.settling:
        sim.advance()
    p, impulse, time, taken = books() - before
    assert p == pytest.approx(impulse - 4.0 * time - taken, abs=1e-11)
    end = sim.diagnostics()
    took = sim.rank.booked().damping[:, DAMPED_ENERGY].sum()
    assert end["damped-energy"] == pytest.approx(took, rel=1e-12) and took > 0.01
    lost = end["dissipated-energy"] - line["dissipated-energy"]
    assert lost == pytest.approx(end["damped-energy"] - line["damped-energy"], abs=0.015)


def test_stages_that_settle_may_follow_each_other_and_end_the_run():
    case = column(REST, {"name": "more", "gravity": [0.0, -2.0], "equilibrate": {}}, step=0.02)
    first, second, third = pgimp.load(case).stages
    assert (second.time.end, third.time.end, third.time.last) == (0.3, 0.3, 0.3)
    assert steps_in(second) == steps_in(third) == 0
    assert not first.rests and second.rests and third.staged.settled and third.staged.damped
    sim = finish(start(case))
    assert sim.time == 0.3 and sim.stage == 2
    assert sim.diagnostics()["reaction.y-min-y"] == pytest.approx(8.0, rel=3e-3)


def test_softer_ground_sinks_and_comes_to_rest():
    soft = {"materials": {"soft": {"young": 0.8 * SOFT["young"]}}}
    case = column({"name": "soft", "equilibrate": {"tolerance": 1e-5}, **soft})
    sim = reached(case, 0)
    before = sim.diagnostics()["body.low.centre-y"]
    after = finish(sim).diagnostics()["body.low.centre-y"]
    # By its own weight and that above.
    pressed = (2.0 * 2.0 + 4.0 * 4.0 / 3.0) / STIFF
    assert before - after == pytest.approx(pressed * (1.0 / 0.8 - 1.0), rel=0.1)


@pytest.mark.wide
def test_an_absorbing_face_finds_its_force_anew():
    """It bears what lies on it after the stage; with the force of before, the rest would fly."""
    case = column(REST, {"name": "on", "end": 3.0})
    case["boundaries"]["y-min"] = "absorbing"
    sim = reached(case, 1)
    low = sim.diagnostics()["body.low.centre-y"]
    finish(sim)
    line = sim.diagnostics()
    assert line["body.low.centre-y"] == pytest.approx(low, abs=2e-3)
    assert line["reaction.y-min-y"] == pytest.approx(4.0, rel=3e-3)


def test_no_rest_has_an_exit_status_and_a_frame(tmp_path, capsys):
    case = column({"name": "fall", "equilibrate": {"steps": 30}, "boundaries": {"y-min": None}})
    case["grid"] |= {"origin": [0.0, -20.0], "size": [1.0, 27.0]}
    case["bodies"]["floor"] = box([0.0, -1.0], [1.0, 0.0])
    del case["start"]
    path = tmp_path / "case.yaml"
    path.write_text(repr(case).replace("'", '"').replace("None", "null"))
    folder = tmp_path / "run"
    assert main([str(path), "-o", str(folder)]) == NoRestError.exit_status == 3
    text = " ".join(capsys.readouterr().err.split())
    steps = int(re.search(r"time\.stages\.0\.equilibrate: no rest after (\d+) steps", text)[1])
    assert 30 < steps < 40
    assert f"no rest after {steps} steps (30 at most, looked at every 10): " in text
    run = pgimp.open(folder)
    before, last = [*run][-2:]
    assert before.time == last.time == 0.3 and last.step == before.step + steps
    assert run.info["state"] == "failed"


@pytest.mark.parametrize(
    ("stage", "text"),
    [
        ({"end": 0.5}, r"stages\.0\.end: a stage with `equilibrate` is done when it is at rest"),
        ({"equilibrate": None}, r"stages\.0\.end: missing \(or \{equilibrate: \{\}\}"),
        ({"equilibrate": {"tolerance": 2.0}}, r"stages\.0\.equilibrate\.tolerance: must be below"),
        (
            {"boundaries": {"x-max": {"velocity": [0.1, None]}}},
            r"stages\.0\.boundaries\.x-max: moves at t = 0\.3, and settle looks for rest",
        ),
        (
            {"constraints": {"grip": {"body": "low", "velocity": [None, -1.0],
                                      "region": {"box": {"min": [0.0, 0.0], "max": [1.0, 1.0]}}}}},
            r"stages\.0\.constraints\.grip\.velocity: moves at t = 0\.3",
        ),
    ],
)  # fmt: skip
def test_what_cannot_settle_is_refused_with_its_line(stage, text):
    with pytest.raises(CaseError, match=text):
        pgimp.load(column(REST | stage))


def test_what_holds_a_removed_body_may_move():
    case = column(REST)
    region = {"box": {"min": [0.0, 5.0], "max": [1.0, 6.0]}}
    case["constraints"] = {"grip": {"body": "top", "velocity": [0.0, 0.1], "region": region}}
    del case["start"]
    assert pgimp.load(case).stages[1].rests
    with pytest.raises(CaseError, match=r"constraints\.grip\.velocity: .*moves at t = 0\.3"):
        pgimp.load(column(REST | {"remove": []}) | {
            "constraints": case["constraints"], "start": {}})  # fmt: skip


def test_a_grip_with_a_force_moves_until_the_material_bears_it():
    """As a static plate test wants it: each load is a stage that settles."""
    region = {"box": {"min": [0.0, 5.0], "max": [1.0, 6.0]}}
    case = column(
        {"name": "press", "constraints": {"grip": {"force": [None, -3.0]}}, "equilibrate": {}}
    )
    case["constraints"] = {
        "grip": {"body": "top", "velocity": [0.0, None], "force": [None, 0.0], "region": region}
    }
    sim = reached(case, 0)
    before = sim.diagnostics()
    finish(sim)
    line = sim.diagnostics()
    assert line["time"] == before["time"] == 0.3 and line["kinetic-energy"] == 0.0
    assert line["reaction.y-min-y"] == pytest.approx(6.0 + 3.0, rel=3e-3)
    sunk = before["displacement.grip-y"] - line["displacement.grip-y"]
    # Between the floor and the grip, whose vertices reach up to a cell below its region.
    assert 3.0 * 4.0 / STIFF < sunk < 3.0 * 5.0 / STIFF


def test_rigid_bodies_that_move_freely_are_refused():
    case = column({"name": "rest", "equilibrate": {}})
    del case["start"]
    ball = {"centre": [0.5, 6.5], "radius": 0.3}
    case["bodies"]["ball"] = {"rigid": {"density": 1.0}, "region": {"ball": ball}}
    with pytest.raises(
        CaseError, match=r"stages\.0\.equilibrate: .*'ball' is rigid and moves freely"
    ):
        pgimp.load(case)
