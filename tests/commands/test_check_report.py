"""What the report of a check has: warnings, what is foreseen, stages."""

import re
from itertools import product

import pytest
from checked import MM, PLATE, SI, block, facts, plate
from mentioned import mentions
from scenes import box, scene

from pgimp.case.load import load
from pgimp.case.reader import read_case
from pgimp.case.schema import Case
from pgimp.commands import check
from pgimp.commands.init import packaged
from pgimp.errors import CaseError
from pgimp.running import forecast
from pgimp.scene.scene import Scene
from pgimp.utilities.check.steps import report_stages
from pgimp.utilities.model.costs import Costs


@pytest.fixture
def unmeasured(monkeypatch):
    """A report without what compiles and measures."""
    monkeypatch.setattr(check, "measure", lambda *scene: None)
    monkeypatch.setattr(check, "pilot", lambda *case: None)
    monkeypatch.setattr(check, "report_program", lambda *case: None)
    monkeypatch.setattr(check, "report_cost", lambda *scene: None)


@pytest.mark.parametrize(("speed", "fewer"), [(0.0, 44), (1.0, 70)])
def test_the_report_says_what_chosen_steps_save(speed, fewer, capsys, unmeasured):
    """0.54 of a cell by waves in place of 0.3; half a cell, where that counts c + |v| = 2 c."""
    case = block(**SI)
    velocity = speed * (SI["young"] / SI["density"]) ** 0.5
    body = case.every_body["block"].model_copy(update={"velocity": (velocity,)})
    case = case.model_copy(update={"every_body": {"block": body}})
    check.report(case)
    assert f": {fewer} % fewer steps" in capsys.readouterr().out
    step = case.time.step.model_copy(update={"courant": "auto"})
    check.report(case.model_copy(update={"time": case.time.model_copy(update={"step": step})}))
    said = capsys.readouterr().out
    assert "chosen by pgimp" in said and "fewer steps" not in said
    assert "warning: time.step" not in said


def test_the_report_says_which_vertices_move_by_themselves(capsys, unmeasured):
    """Of a plate a quarter of a cell thick; long steps are refused."""
    region = {"box": {"min": [1.3, 2.97], "max": [6.4, 3.25]}}
    body = {"material": "soft", "region": region, "formulation": "total-lagrangian"}
    check.report(Case.model_validate(scene(2, body, step=0.005, end=0.2)))
    assert "cell near them to move with: 15;" in capsys.readouterr().out
    with pytest.raises(CaseError, match="stable up to the Courant number"):
        check.report(Case.model_validate(scene(2, body, step={"courant": 0.7}, end=2.0)))


def test_the_report_says_where_cut_cells_are_those_of_boxes(capsys, unmeasured):
    """In shapes wider than cells, and if others are whole beside the current configuration."""
    body = box([1.3, 2.0], [4.0, 4.0]) | {"formulation": "total-lagrangian"}
    both = {"a": body, "b": box([5.0, 2.0], [7.0, 4.0])}
    whole = both | {"c": box([2.0, 5.0], [4.0, 7.0]) | {"formulation": "total-lagrangian",
                                                       "surface": "whole-particles"}}  # fmt: skip
    for case, why in (
        (scene(2, body, shape="bspline-quadratic"), "bspline-quadratic is wider than cells"),
        (scene(2, both), ""),
        (scene(2, whole), "'b' is in the current one, and another body is whole"),
        (scene(2, body), ""),
        (scene(2, body | {"region": both["b"]["region"]}, shape="bspline-quadratic"), ""),
    ):
        check.report(Case.model_validate(case))
        said = capsys.readouterr().out
        assert ("have weights of whole ones" in said) == bool(why)
        assert why in said


def test_the_report_has_the_warnings(capsys, unmeasured):
    """A step of a tenth of a thousandth of what is stable, in a block with mixed units."""
    case = block(**(MM | {"density": 7850.0}), end=1.0)
    case = case.model_copy(update={"time": case.time.model_copy(update={"step": 1.0e-4})})
    check.report(case)
    warnings = [line for line in capsys.readouterr().out.splitlines() if "warning: " in line]
    about = ["time.step", "bodies.block", "materials.steel.density", "materials.steel", "time.end"]
    assert all(f"warning: {words}" in line for words, line in zip(about, warnings, strict=True))
    mentions(warnings[0], "0.0001", "Courant number", "5.17e-05")
    check.report(case, verbose=True)
    named = [line for line in capsys.readouterr().out.splitlines() if "warning: " in line]
    ids = [line.partition("[")[2].partition("]")[0] for line in named]
    assert ids == ["short-step", "load-strain", "units", "units", "short-run"]
    assert [re.sub(r"\[.*?\] ", "", line, count=1) for line in named] == warnings


def test_the_report_has_what_is_foreseen(capsys, unmeasured):
    """A grip pulls a bar to twice its length; a tool is fast, with mass scaling and units."""
    pulled = plate("constraints:", "  grip:", "    body: beam", "    velocity: [8.0, 0.0]",
                   "    region: {box: {min: [7.0, 1.0], max: [8.0, 2.0]}}",
                   "boundaries: {x-min: slip}")  # fmt: skip
    check.report(pulled)
    said = capsys.readouterr().out
    mentions(said, "by the way of constraint grip 1.1", "warning: constraints.grip: it pulls")
    text = """
units: m, kg, s
materials:
  m: {model: von-mises, young: 1.0e+8, poisson: 0.3, density: 1800.0, yield-stress: 4.0e+4}
bodies:
  beam: {material: m, region: {box: {min: [0.0, 0.0], max: [10.0, 2.0]}}}
  tool:
    rigid: {velocity: [0.0, -1.0]}
    region: {box: {min: [4.25, 2.0], max: [5.75, 4.5]}}
contact: [{bodies: all}]
"""
    scaled = PLATE.replace("step: {courant", "mass-scaling: 400.0, step: {courant")
    kept = [line for line in scaled.splitlines() if not line.startswith(("materials", "bodies"))]
    check.report(read_case("\n".join(kept) + text))
    said = capsys.readouterr().out
    mentions(said, "warning: bodies.tool.rigid: at 1 it sends", "note: bodies.tool.region: 3 cells")
    assert "density: " not in said.partition("mass-scaling")[2]


def test_bodies_of_one_material_are_warned_of_once(capsys, unmeasured):
    """And a stage whose step is far too short, which the first one's is not."""
    data = block(**(SI | {"density": 7.85e-3})).model_dump(by_alias=True)
    region = {"box": {"min": [0.15], "max": [0.2]}}
    data["bodies"]["other"] = {"material": "steel", "region": region}
    data["time"]["stages"] = [{"name": "slow", "end": 2.0e-3, "step": 1.0e-12}]
    check.report(load(data))
    said = capsys.readouterr().out
    assert said.count("materials.steel.density: 0.00785 would be") == 1
    mentions(said, "time.stages.0.step: 1e-12 is a Courant number of", "times fewer steps")


def test_transits_are_those_of_all_stages(capsys, unmeasured):
    """5172 m/s over 0.1 m: 51.7 in the first millisecond, and twice that in the second stage."""
    data = block(**SI).model_dump(by_alias=True)
    data["time"]["stages"] = [{"name": "on", "end": 3.0e-3}]
    check.report(load(data))
    assert "; the run lasts 155 travel times" in capsys.readouterr().out


def test_stages_are_listed_with_their_steps_and_changes(capsys):
    case = block(**SI)
    first = case.stages[0]
    data = case.model_dump(by_alias=True)
    data["time"]["stages"] = [
        {"name": "hot", "end": 2.0e-3, "materials": {"steel": {"young": 8.4e11}}},
        {"name": "loose", "end": 2.5e-3, "step": 1.0e-7, "boundaries": {"x-min": None}},
        {"name": "same", "end": 3.0e-3, "output": {"every": 1.0e-4}},
    ]
    staged = type(case).model_validate(data)
    (body,) = facts(first)
    steps = report_stages(staged, [Scene(each) for each in staged.stages], 1.0, {}, [])
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    # Twice the wave speed takes twice the steps: 0.3 cells each.
    hot = 2.0 * body.wave_speed * 1.0e-3 / (0.3 * 0.01)
    assert steps == pytest.approx(hot + 5000 + 5000, abs=1.0)
    first, second, third = lines
    mentions(first, "stage 2", "hot", "0.002", "about", "steps", "materials.steel.young")
    mentions(second, "stage 3", "loose", "0.0025", "5,000 steps", "boundaries.x-min")
    mentions(third, "stage 4", "same", "0.003", "5,000 steps", "output.every")
    assert "young" not in second and "boundaries" not in third
    # At the start, at the end of each stage, and four times in the last one.
    assert forecast.frames(staged, 15_000.0) == 5 + 4


@pytest.mark.parametrize(
    ("name", "pays_off"),
    [
        *((name, False) for name in ("bar-vibration", "compaction", "incline")),
        *product(("block3d", "dam-break", "disks", "gate", "hertz"), (False, True)),
    ],
)
def test_a_small_healthy_case_has_ten_lines(name, pays_off, capsys, monkeypatch):
    """With all that is measured, whether one rank is enough or many pay off."""
    costs = Costs(1e-7 if pays_off else 1.0, ((200.0, 1e-6), (1e6, 1e-6)), 1e-9)
    monkeypatch.setattr(check, "measure", lambda *scene: costs)
    monkeypatch.setattr(check, "pilot", lambda *case: None)
    monkeypatch.setattr(check, "report_program", lambda *case: None)
    case = read_case(packaged()[name], name)
    check.report(case)
    short = capsys.readouterr().out.splitlines()
    more = sum(line.startswith(("accuracy", "walls")) for line in short)  # where there is a reason
    assert len(short) <= 10 + more, "\n".join(short)
    text = "\n".join(short)
    assert ("pay off" in text) and ("\nranks " in text) == pays_off
    for words in (
        "valid",
        " particles in ",
        "travel times",
        "Courant",
        "memory ",
        "output ",
        "time ",
    ):
        assert words in text
    check.report(case, verbose=True)
    long = capsys.readouterr().out
    assert len(long.splitlines()) > len(short) + 3 and "strain by" in long
