"""Stages: a run and its resume with changes, bit for bit; what particles and books keep.

All in 1D: a bar whose free end is gripped, and another that waits beside it.
"""

import json
import shutil

import numpy as np
import pytest
from run_files import digests
from scenes import energy, field, finish, start, tracked
from staged_bar import DIG, HOLD, LENGTH, PULLED, SPEED, STEP, E, bar, entered

import pgimp
from pgimp.errors import RunError, UsageError
from pgimp.mpi.comm import Serial

pytestmark = pytest.mark.slow(20)


def test_a_stage_is_the_resume_of_the_run_before_with_its_changes(tmp_path):
    """Also in what the history has, though columns have come in later."""
    options = {"comm": Serial(), "quiet": True}
    together = pgimp.run(bar(DIG, HOLD), output=tmp_path / "together", **options)
    folder = tmp_path / "one-by-one"
    pgimp.run(bar(), output=folder, **options)
    narrow = (folder / "history.csv").read_text().splitlines()[0]
    for stages in ((DIG,), (DIG, HOLD)):
        pgimp.run(bar(*stages), output=folder, resume=True, **options)
    assert digests(folder) == digests(together.path)
    wide = (folder / "history.csv").read_text().splitlines()[0]
    assert "removed.mass" in wide and "removed.mass" not in narrow
    case = (folder / "case.yaml").read_text()
    assert case == (together.path / "case.yaml").read_text()
    assert [frame.time for frame in together if frame.time in (1.0, 1.5, 2.1)] == [1.0, 1.5, 2.1]
    assert "stage 3 of 3, 'hold': from t = 1.5" in (folder / "log.txt").read_text()


def test_a_stage_that_changes_nothing_leaves_the_bits_of_a_longer_run():
    one = finish(start(bar(end=1.5)))
    other = finish(start(bar({"end": 1.3}, {"end": 1.5})))
    for name in ("x", "v", "sigma", "F"):
        assert np.array_equal(field(one, name), field(other, name)), name
    line, again = one.diagnostics(), other.diagnostics()
    assert again.pop("stages.strain-energy") == 0.0
    assert line.keys() == again.keys() and line["external-work"] == again["external-work"]


@pytest.mark.parametrize("step", [STEP, {"courant": 0.2}])
def test_nobody_goes_on_from_where_a_stage_is_not_done_or_is_the_last(step):
    """Else it would go on with the wrong case, or with none."""
    sim = start(bar({"end": 1.2}, end=1.0, step=step))
    sim.advance()
    with pytest.raises(RunError, match="is not the end of the first stage, which is at t = 1;"):
        sim.next_stage()
    while not sim.finished:
        sim.advance()
    steps, v = sim.step, field(sim, "v")
    for go_on in (sim.advance, sim.next_stage):
        with pytest.raises(RunError, match=rf"the case ends at t = 1\.2, after {steps} steps"):
            go_on()
    assert (sim.stage, sim.step, sim.time) == (1, steps, 1.2)
    assert np.array_equal(field(sim, "v"), v)


def test_what_is_removed_is_in_the_books():
    sim, before = entered(bar(DIG | {"materials": {}}))
    after = sim.diagnostics()
    assert (field(sim, "body") == 0).all() and len(field(sim, "id")) == 2 * LENGTH
    assert after["mass"] == after["body.bar.mass"] == LENGTH and after["removed.mass"] == 2.0
    assert after["removed.momentum-x"] == pytest.approx(1.0, rel=1e-12)
    assert after["removed.kinetic-energy"] == pytest.approx(0.25, rel=1e-12)
    assert np.isnan(after["body.waits.centre-x"])
    for name in ("dissipated-energy", "external-work", "time", "reaction.x-min-x"):
        assert after[name] == pytest.approx(before[name], rel=1e-12, abs=1e-14), name


def test_other_parameters_bring_energy_that_the_history_tells():
    """Half of Young's modulus leaves half of the energy of a strain."""
    sim, before = entered(bar(DIG | {"remove": []}))
    after = sim.diagnostics()
    assert before["strain-energy"] > 1e-3
    assert after["strain-energy"] == pytest.approx(0.5 * before["strain-energy"], rel=1e-12)
    assert after["stages.strain-energy"] == pytest.approx(-0.5 * before["strain-energy"], rel=1e-12)
    assert after["dissipated-energy"] == pytest.approx(before["dissipated-energy"], abs=1e-14)


def test_work_done_before_a_stage_is_not_that_of_its_parameters():
    """Of a bar that has yielded, whose yield stress falls to a quarter of what it was."""
    metal = {"soft": {"model": "von-mises", "young": E, "poisson": 0.0, "density": 1.0}}
    metal["soft"]["yield-stress"] = 0.4
    weaker = {"end": 1.5, "materials": {"soft": {"yield-stress": 0.1}}}
    sim, before = entered(bar(weaker, materials=metal))
    after = sim.diagnostics()
    assert before["plastic-work"] > 1e-3
    assert after["plastic-work"] == pytest.approx(before["plastic-work"], rel=1e-12)
    finish(sim)
    end = sim.diagnostics()
    assert before["plastic-work"] < end["plastic-work"] <= end["dissipated-energy"]


def test_constraints_keep_their_way_and_new_ones_hold_what_is_there_now():
    grip = {"grip": PULLED | {"velocity": [1.0]}}
    catch = {"catch": {"body": "waits", "region": {"box": {"min": [11.9], "max": [14.0]}}}}
    catch["catch"]["velocity"] = [-1.0]
    sim, _ = entered(
        bar(
            {"end": 1.5, "constraints": catch | {"grip": {"velocity": [-1.0]}}},
            constraints=grip,
            history={"every": {"steps": 1}},
        )
    )
    held = field(sim, "constraint")[:, 0]
    x = field(sim, "x")[:, 0]
    assert list(held[x > 11.0]) == [0, 2, 2, 2]  # the first is at 11.25 + 0.5
    assert list(np.flatnonzero(held == 1)) == [15]
    finish(sim)
    line = sim.diagnostics()
    assert line["displacement.grip-x"] == pytest.approx(1.0 - 0.5, abs=1e-12)
    assert line["displacement.catch-x"] == pytest.approx(-0.5, abs=1e-12)
    assert field(sim, "x")[15, 0] == pytest.approx(7.75 + 0.5, abs=0.02)  # first order in the step


def test_a_bar_that_is_released_swings_between_stretch_and_compression():
    """Its free end by as much either way, with the period 4 l/c; nothing takes its energy."""
    slow = {"grip": PULLED | {"velocity": [{"table": [[0.0, 0.01], [8.0, 0.01], [9.0, 0.0]]}]}}
    period = 4.0 * LENGTH / SPEED
    case = bar(
        {"name": "release", "end": 12.0 + period, "constraints": {"grip": None}},
        waits=False, end=12.0, constraints=slow, gravity=[0.0], boundaries={"x-min": "fixed"},
    )  # fmt: skip
    sim, before = entered(case)
    # The grip holds its particle's vertices, 7 and 8: by 0.085 is stretched what is before them.
    assert before["strain-energy"] == pytest.approx(0.5 * E * 0.085**2 / 7.0, rel=1e-3)
    start_at = field(sim, "x")[-1, 0]
    ends = [start_at]
    while not sim.finished:
        sim.advance()
        ends.append(field(sim, "x")[-1, 0])
    way = (np.array(ends) - 7.75) / (start_at - 7.75)
    half = round(0.5 * period / STEP)
    assert way[half] == pytest.approx(-1.0, abs=0.1) and way[-1] == pytest.approx(1.0, abs=0.1)
    after = sim.diagnostics()
    # Of the kink that a release makes, the shortest waves are lost on eight cells.
    assert energy(after) == pytest.approx(energy(before), rel=0.05)
    assert after["external-work"] == before["external-work"]


def test_steps_of_a_stage_end_exactly_with_it():
    """Those of the Courant number are shortened, fixed ones are counted from its beginning."""
    sim = start(bar({"end": 1.37, "step": {"courant": 0.3}}, {"end": 1.44, "step": 0.0175}))
    sim.diagnostics()
    time, step, dt = tracked(sim, "time", "step", "dt")
    assert {1.0, 1.37, 1.44} <= set(time) and time[-1] == 1.44
    assert len(np.unique(step)) == len(step) and (np.diff(time) > 0.0).all()
    assert (dt[time > 1.371] == 0.0175).all()


def test_python_sees_the_stages():
    sim = pgimp.Simulation(bar(DIG, HOLD), Serial())
    sim.advance(1.0)
    assert (sim.stage, sim.time, sim.finished) == (0, 1.0, False)
    sim.step()
    assert (sim.stage, sim.time) == (1, 1.01) and len(sim.particles["id"]) == 16
    assert repr(sim).startswith("<Simulation: t = 1.01 of 2.1")
    sim.advance()
    assert (sim.stage, sim.time, sim.finished) == (2, 2.1, True)
    line = sim.diagnostics()
    assert np.isfinite(line["constraint.base-x"]) and line["removed.mass"] == 2.0


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A run of three stages that has been killed in the last."""
    case = bar(DIG, HOLD, checkpoint={"every": {"steps": 20}})
    folder = tmp_path_factory.mktemp("stages") / "run"
    pgimp.run(case, Serial(), folder, quiet=True)
    (folder / "checkpoints" / "step-000000174.h5").unlink()
    assert (folder / "checkpoints" / "step-000000160.h5").exists()
    info = json.loads((folder / "run.json").read_text())
    info["starts"][-1]["state"] = "running"
    (folder / "run.json").write_text(json.dumps(info))
    return folder


@pytest.fixture
def killed(stopped, tmp_path):
    return shutil.copytree(stopped, tmp_path / "run")


@pytest.mark.parametrize(
    ("stages", "said"),
    [
        ([DIG | {"gravity": [-2.0]}, HOLD], "stage 'dig': gravity is"),
        ([DIG | {"remove": []}, HOLD], "remove: without .*, was without"),
        ([DIG | {"end": 1.4}, HOLD | {"end": 2.0}], "stage 'dig': time.end is 1.4, was 1.5"),
        ([DIG], "the run is in stage 3 already, 'hold', which the case does not have"),
        ([DIG, HOLD | {"boundaries": {"x-max": "fixed"}}], "stage 'hold': boundaries.x-max is"),
    ],
)
def test_stages_that_have_begun_cannot_change(killed, stages, said):
    with pytest.raises(UsageError, match=said):
        pgimp.run(bar(*stages), Serial(), killed, resume=True, quiet=True)


def test_a_run_goes_on_in_a_stage_with_another_end_and_further_stages(killed):
    more = {"name": "more", "end": 2.4, "gravity": None, "constraints": {"grip": None}}
    run = pgimp.run(bar(DIG, HOLD | {"end": 2.2}, more), Serial(), killed, resume=True, quiet=True)
    assert run.history["time"][-1] == 2.4 and {2.2} <= {frame.time for frame in run}
    assert np.isnan(run.history["constraint.grip-x"][-1])
