"""Stages: what of them is noticed, and made ready, before the first step."""

import pytest
from scenes import start, write_case
from staged_bar import DIG, HOLD, PULLED, bar, entered

import pgimp
from pgimp.commands import check
from pgimp.errors import CaseError, RunError
from pgimp.mpi.comm import Serial

WATCHED = """
import sys
from pgimp.jit.compiled.cache import KernelCache
from pgimp.case.load import load
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

needed, look = [], KernelCache.load_overload
def recording(self, *args):
    needed.append(args)
    return look(self, *args)
KernelCache.load_overload = recording
sim = Simulation(load(sys.argv[1]), Serial())
sim.diagnostics()
sim.advance()
print(len(needed), end=" ")
while not sim.finished:
    sim.advance()
sim.diagnostics()
print(len(needed), sim.stage)
"""


def test_kernels_of_all_stages_are_compiled_before_the_first_step(tmp_path, python):
    """Those of walls, constraints, damping and contact that come or go, with a rigid body."""
    punch = {"rigid": {"velocity": [-0.1]}, "region": {"box": {"min": [13.5], "max": [15.0]}}}
    case = bar(
        HOLD | {"end": 1.5, "method": {"relaxation": 2.0}},
        {"end": 1.6, "step": 0.01, "boundaries": {"x-max": "unilateral"}, "remove": ["punch"]},
        constraints={}, boundaries={}, contact=[{"bodies": "all"}],
    )  # fmt: skip
    case["bodies"]["punch"] = punch
    write_case(tmp_path / "case.yaml", case)
    done = python(["-c", WATCHED, tmp_path / "case.yaml"])
    assert done.returncode == 0, done.stderr
    before, after, stage = map(int, done.stdout.split())
    assert before == after > 10 and stage == 2


def test_a_constraint_that_begins_and_holds_nothing_ends_the_run(tmp_path):
    region = {"box": {"min": [14.0], "max": [16.0]}}
    late = {"late": {"body": "bar", "region": region, "velocity": [0.0]}}
    case = bar({"name": "late", "end": 1.5, "constraints": late})
    with pytest.raises(
        RunError, match=r"stage 'late': constraints.late.region contains no particle"
    ):
        pgimp.run(case, Serial(), tmp_path / "run", quiet=True)
    late["late"]["region"] = PULLED["region"] | {"box": {"min": [5.0], "max": [16.0]}}
    run = pgimp.run(case, Serial(), tmp_path / "run", resume=True, quiet=True)
    assert run.info["state"] == "done" and run.info["stages"] == [run.info["resumed_from"]]
    assert "stages" not in run.starts[0]  # a stage that could not begin
    again = pgimp.run(case, Serial(), tmp_path / "run", resume=True, quiet=True)
    assert again.info["stages"] == run.info["stages"]  # also where it is resumed in the stage


def test_a_constraint_that_begins_and_keeps_nothing_ends_the_run():
    """The one after it takes all its particles, as at the start, where that is refused."""
    wide = {"body": "bar", "region": {"box": {"min": [4.0], "max": [6.0]}}, "velocity": [0.0]}
    narrow = wide | {"region": {"box": {"min": [4.5], "max": [5.5]}}}
    entered(bar({"end": 1.5, "constraints": {"one": wide, "two": narrow}}))
    with pytest.raises(RunError, match=r"constraints.one.region contains no particle"):
        entered(bar({"end": 1.5, "constraints": {"one": narrow, "two": wide}}))


def test_a_constraint_that_would_hold_nothing_is_noticed_at_the_start(capsys):
    """By a run and by check, in the same words; what comes there in time is held."""
    hold = {"body": "waits", "region": {"box": {"min": [13.2], "max": [15.0]}}, "velocity": [0.0]}
    case = bar(
        {"end": 1.5, "constraints": {"late": hold, "grip": {"velocity": [0.0]}}},
        {"end": 2.0, "constraints": {"late": hold | {"body": "bar"}, "more": PULLED}},
    )
    sim = start(case)
    found = [text for text in sim.warnings if "contains no particle" in text]
    assert [text.partition(": ")[0] for text in found] == [
        f"time.stages.{number}.constraints.late.region" for number in (0, 1)
    ]
    assert "no particle of 'waits'; if none comes there by t = 1, " in found[0]
    check.report(pgimp.load(case))
    shown = capsys.readouterr().out
    assert all(f"warning: {text}\n" in shown for text in found)
    while not sim.stage_done:
        sim.advance()
    sim.next_stage()  # `waits` has moved by half
    assert not any("contains no particle" in text for text in start(bar(DIG, HOLD)).warnings)


def test_a_step_that_is_too_long_for_a_stage_is_refused_before_the_first():
    with pytest.raises(CaseError, match=r"^stage 'stiff': time\.step: 0\.01 is a Courant"):
        start(bar({"name": "stiff", "end": 2.0, "materials": {"soft": {"young": 4e6}}}))


def test_the_fastest_particle_of_a_material_that_varies_counts_in_all_stages(capsys):
    """Its typical particle would allow the step."""
    coarse = bar({"name": "coarse", "end": 2.0, "step": 0.05})
    coarse["materials"]["soft"]["young"] = {
        "layers": [[0.0, 100.0], [7.0, 4000.0]], "over": "x",
    }  # fmt: skip
    for look in (start, lambda case: check.report(pgimp.load(case))):
        with pytest.raises(CaseError, match=r"^stage 'coarse': time\.stages\.0\.step: 0\.05 is"):
            look(coarse)
    coarse["time"]["stages"][0]["step"] = 0.01
    start(coarse)
