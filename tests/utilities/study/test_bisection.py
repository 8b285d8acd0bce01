"""Studies that bisect: the last value of a key with which a case comes to rest."""

import csv
import json
import shutil
from math import inf

import numpy as np
import pytest
from pages import block_of
from scenes import box, scene

import pgimp
from pgimp import load
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.io.rundir.ownfiles import RUN
from pgimp.utilities.study import brackets, sliding
from pgimp.utilities.study.bisect_entry import Bisection
from pgimp.utilities.study.bisection import Bracket, bisect, result
from pgimp.utilities.study.plan import Bisected, read_plan
from pgimp.utilities.study.runs import DONE, FAILED, Outcome

CLAY = {
    "model": "mohr-coulomb", "young": 1000.0, "poisson": 0.3, "density": 1.0, "cohesion": 1.0,
    "friction-angle": 0.0,
}  # fmt: skip


def block(**parts):
    """A block of clay that stands on a smooth floor, beside a smooth wall."""
    walls = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}
    case = scene(2, box([0.0, 0.0], [2.0, 2.0], material="clay"), cells=[8, 3], end=0.1,
                 step={"courant": 0.3}, gravity=[0.0, -0.5], materials={"clay": CLAY},
                 boundaries=walls, start={"equilibrate": {"tolerance": 1e-3}})  # fmt: skip
    case["time"]["stages"] = [
        {"name": "weak", "strength": {"factor": 1.0},
         "equilibrate": {"tolerance": 1e-3, "steps": 1000}}
    ]  # fmt: skip
    return case | parts


def written(folder, case=None, **entries):
    """A study file."""
    (folder / "case.yaml").write_text(json.dumps(case or block()))
    entry = {
        "key": "time.stages.0.strength-reduction.factor",
        "between": [1.0, 3.0],
        "tolerance": 0.3,
    }
    study = {"format": 1, "case": "case.yaml", "bisect": entry} | entries
    path = folder / "safety.yaml"
    path.write_text(json.dumps(study))
    return path


@pytest.mark.parametrize(("first", "last"), [(1.0, 2.0), (5.0, -3.0)])
def test_the_bracket_halves_until_it_is_close(first, last):
    entry = Bisection(key="gravity", between=(first, last), tolerance=0.01, reference=1.3)
    tried = []

    def run(value):
        tried.append(value)
        return Outcome(None, DONE, value=float((value < 1.31) == (first < last)))

    bracket = Bracket(Bisected("", None, 0.0, None))
    assert len(list(bisect(bracket, entry, run))) == len(tried)
    assert tried[:2] == [first, last] and bracket.ended
    low, high = sorted((bracket.rests, bracket.moves))
    assert low < 1.31 <= high and high - low <= 0.01
    assert bracket.error(entry) == pytest.approx(abs(bracket.middle / 1.3 - 1.0))
    assert "gravity is 1.3" in result(bracket, entry)


@pytest.mark.parametrize(
    ("limit", "text"),
    [(inf, "with the second value, k = 2, the case comes to rest"),
     (0.0, "with the first value, k = 1, the case does not come to rest")],
)  # fmt: skip
def test_values_on_one_side_give_no_result(limit, text):
    entry = Bisection(key="k", between=(1.0, 2.0))
    bracket = Bracket(Bisected("", None, 0.0, None))
    runs = [*bisect(bracket, entry, lambda v: Outcome(None, DONE, value=float(v < limit)))]
    assert len(runs) == (2 if limit else 1) and not bracket.ended
    assert text in result(bracket, entry)


def test_a_run_that_fails_otherwise_ends_the_bisection():
    entry, bracket = Bisection(key="k", between=(1.0, 2.0)), Bracket(Bisected("", None, 0.0, None))
    runs = [*bisect(bracket, entry, lambda _: Outcome(None, FAILED, message="it blew up"))]
    assert len(runs) == 1 and not bracket.ended
    assert "ended by the run of 1: it blew up" in result(bracket, entry)


@pytest.mark.slow(60)
def test_a_study_finds_its_result_and_repeats_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    case = block()
    # A vertical cut on a smooth floor: its foot yields at c = rho g H/2, a wedge slides at a half.
    entry = {
        "key": "time.stages.0.strength-reduction.factor",
        "between": [1.0, 9.0],
        "tolerance": 0.3,
    }
    path = written(tmp_path, case, bisect=entry | {"reference": 4.0})
    assert main(["study", str(path)]) == 0
    said = capsys.readouterr().out
    assert "1 of 1 bisections have a result" in said and "(from before)" not in said
    folder = tmp_path / "safety.study.out"
    rows = [*csv.DictReader((folder / "study.csv").open())]
    values = {float(row["time.stages.0.strength-reduction.factor"]): row["state"] for row in rows}
    assert values[1.0] == "at rest" and values[9.0] == "no rest"
    assert set(values.values()) <= {"at rest", "no rest", "slid"}
    rests = max(value for value, state in values.items() if state == "at rest")
    moves = min(value for value, state in values.items() if state != "at rest")
    assert rests < moves <= rests + 0.3 and 2.0 < 0.5 * (rests + moves) < 5.0
    assert all(float(row["wall"]) > 0.0 for row in rows)
    # One run is lost, another was ended on the way, as by a kill: these are run again.
    names = [row["run"] for row in rows]
    shutil.rmtree(folder / "runs" / names[0])
    info = folder / "runs" / names[2] / RUN
    info.write_text(info.read_text().replace('"state": "done"', '"state": "running"'))
    info.write_text(info.read_text().replace('"state": "failed"', '"state": "running"'))
    assert main(["study", str(path)]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "steps in" in line]
    assert [("from before" in line) for line in lines].count(False) == 2
    assert main(["study", str(path), "--list"]) == 0
    assert capsys.readouterr().out.count("factor=") == 2


@pytest.mark.slow(15)
def test_what_slides_and_rests_as_a_heap_is_not_at_rest(tmp_path, monkeypatch, capsys):
    """The cut of half its height c = rho g H/2 slides on its smooth floor until it is low."""
    monkeypatch.chdir(tmp_path)
    case = block()
    case["time"]["stages"][0]["equilibrate"]["steps"] = 3000
    key = "time.stages.0.strength-reduction.factor"
    entry = {"key": key, "between": [4.0, 5.0], "tolerance": 1.0}
    path = written(tmp_path, case, bisect=entry)
    assert main(["study", str(path)]) == 0
    said = capsys.readouterr().out
    assert "factor-4.0: at rest after" in said and "factor-5.0: slid after" in said
    assert "over 0.1" in said and f"{key} is 4.5" in said and "note:" not in said
    folder = tmp_path / "safety.study.out"
    rows = {row["run"]: row for row in csv.DictReader((folder / "study.csv").open())}
    ways = [float(rows[f"factor-{value}"]["moved"]) for value in (4.0, 5.0)]
    assert ways[0] < 0.1 < ways[1] and rows["factor-5.0"]["state"] == "slid"
    assert f"| factor-5.0 | slid | {ways[1]:.3g} |" in (folder / "study.md").read_text()
    # The runs tell where their stages begin, and so how far their particles moved in between.
    run = pgimp.open(folder / "runs" / "factor-5.0")
    assert run.info["stages"] == [run.frame(-2).step] and run.info["steps"] == run.frame(-1).step
    way = run.frame(-1)["position"] - run.frame(-2)["position"]
    assert ways[1] == np.sqrt(np.square(way).sum(axis=1).max())
    # With any displacement, or a longer one, the heap is at rest: the same runs tell.
    for slide in (None, 1.0):
        written(tmp_path, case, bisect=entry | {"slide": slide})
        assert main(["study", str(path)]) == 1
        said = capsys.readouterr().out
        assert "factor-5.0: at rest after" in said and said.count("(from before)") == 2
        assert "with the second value" in said and "comes to rest" in said
    # A shorter one is below what the first moves.
    written(tmp_path, case, bisect=entry | {"slide": 1e-3})
    assert main(["study", str(path)]) == 1
    said = capsys.readouterr().out
    assert "slides before it rests" in said and "longer bisect.failure-displacement" in said


def test_displacements_are_those_of_the_particles_of_both_frames():
    plain = scene(2, box([0.0, 0.0], [2.0, 2.0], material="clay"), cells=[8, 3], end=0.1,
                  materials={"clay": CLAY})  # fmt: skip
    ends = {"x-min": "periodic", "x-max": "periodic"}
    a = {"id": np.array([0, 1, 3]), "position": np.array([[0.5, 1.0], [7.9, 1.0], [1.0, 1.0]])}
    b = {"id": np.array([1, 3, 4]), "position": np.array([[0.2, 1.4], [1.1, 1.0], [9.0, 9.0]])}
    for parts, way in (({}, 7.7), ({"boundaries": ends}, 0.3)):
        found = sliding.greatest(a, b, load(plain | parts))
        assert found == pytest.approx(np.hypot(way, 0.4))
    for one in (a, b):  # that of a body that has come counts from there
        one["displacement"] = np.zeros((3, 2))
    b["displacement"][2] = 0.6, 0.8
    assert sliding.greatest(a, b, load(plain)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("key", "stages"),
    [("gravity", [1, 3]), ("time.stages.0.strength-reduction.factor", [1, 3]),
     ("time.stages.1.end", [3]), ("time.stages.2.strength-reduction.factor", [3])],
)  # fmt: skip
def test_stages_that_the_key_changes_count(key, stages):
    case = block()
    case["time"]["stages"] += [{"name": "wait", "end": 0.2}, {"name": "rest", "equilibrate": {}}]
    entry = Bisection(key=key, between=(1.0, 2.0))
    assert sliding.watched(entry, load(case)) == stages
    assert sliding.unwatched(entry, load(case)) == (key == "gravity")
    assert sliding.known(entry, load(case), {"state": "done", "stages": [8, 9, 10]})
    assert not sliding.known(entry, load(case), {"state": "done"})
    assert sliding.known(entry, load(case), {"state": "failed"})


def test_a_case_at_rest_before_time_zero_only_may_slide_unseen(tmp_path):
    case = block()
    del case["time"]["stages"]
    entry = {"key": "materials.clay.cohesion", "between": [1.0, 2.0]}
    for slide, unseen in (("auto", True), (None, False)):
        plan = read_plan(written(tmp_path, case, bisect=entry | {"slide": slide}))
        assert plan.bisected[0].unseen == unseen
        bracket = Bracket(plan.bisected[0])
        text = brackets.as_markdown(plan, [bracket], plan.study.bisect)
        assert ("not before time 0" in text) == unseen
    with pytest.raises(CaseError, match=r"bisect\.slide: is for a stage with `equilibrate`"):
        read_plan(written(tmp_path, case, bisect=entry | {"slide": 0.1}))


@pytest.mark.parametrize(
    ("entries", "text"),
    [
        ({"error": "kinetic-energy"}, "error: is none of a bisection"),
        ({"bisect": None}, "sweep: missing"),
        ({"bisect": {"key": "gravity..x", "between": [0, 1]}}, "expected keys joined by dots"),
        ({"bisect": {"key": "gravity", "between": [1, 1]}}, "expected two different numbers"),
        (
            {"bisect": {"key": "time.stages.3.strength-reduction.factor", "between": [1.0, 2.0]}},
            "stages",
        ),
        ({"bisect": {"key": "gravity", "between": [0, 1], "slide": 0.0}}, "slide: must be above 0"),
        ({"bisect": {"key": "gravity", "between": [0, 1], "slide": "no"}}, "slide"),
        (
            {"bisect": {"key": "time.stages.0.strength-reduction.factor", "between": [-1.0, 2.0]}},
            "strength.factor: must be above 0",
        ),
    ],
)
def test_wrong_bisections_are_refused(tmp_path, entries, text):
    with pytest.raises(CaseError) as error:
        read_plan(written(tmp_path, **entries))
    assert text in str(error.value)


def test_a_study_may_set_what_the_key_is_in(tmp_path):
    """Each run has its own copy of it."""
    stages = [{"name": "weak", "strength": {"factor": 1.0}, "equilibrate": {}}]
    plan = read_plan(written(tmp_path, set={"time.stages": stages}))
    for value in (1.5, 2.0):
        run = plan.bisected[0].planned(value)
        assert "factor: 1.0" in run.options[0] and f"factor={value}" in run.options[1]
        assert f"factor: {value}" in run.resolved


def test_the_study_of_the_page_is_one(tmp_path):
    (tmp_path / "slope.yaml").write_text(json.dumps(block()))
    path = tmp_path / "safety.yaml"
    path.write_text(block_of("# safety.yaml\n"))
    plan = read_plan(path)
    assert [one.x for one in plan.bisected] == [1.0, 0.5]
    assert plan.bisected[0].planned(1.5).name.endswith("factor-1.5")


def test_a_case_without_rest_is_refused(tmp_path):
    case = block()
    del case["start"]
    case["time"]["stages"][0].pop("equilibrate")
    case["time"]["stages"][0]["end"] = 0.2
    with pytest.raises(CaseError, match="nothing that comes to rest"):
        read_plan(written(tmp_path, case))
