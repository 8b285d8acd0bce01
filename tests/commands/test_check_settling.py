"""``pgimp check`` on steps to rest: an estimate against measured numbers, and their output."""

import re
from pathlib import Path

import pytest
from checked import PLATE, facts
from mentioned import mentions
from scenes import BAR, box, scene
from studies.quiet import settle

import pgimp
from pgimp.case.reader import read_case
from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.running import forecast
from pgimp.solver.simulation import Simulation
from pgimp.utilities.check.settling import settling_steps

PAGE = Path(__file__).parents[2] / "docs" / "case-file.md"


def measured():
    """Scene, dimensions, configuration, Courant number and steps of the page's table."""
    for name, (_, kinds, configurations) in settle.SCENES.items():
        if name.startswith("ground"):  # it settles in a stage
            continue
        for kind in kinds:
            row = next(
                r for r in PAGE.read_text().splitlines() if r.startswith(f"| {name} | {kind} |")
            )
            own, short, long = (cell.split("(")[0] for cell in row.split("|")[4:7])
            yield name, kind, "current", 0.3, int(short)
            yield name, kind, "current", 0.6, int(long)
            if "initial" in configurations:
                yield name, kind, "initial", 0.3, int(own)


@pytest.mark.parametrize(("name", "kind", "configuration", "courant", "steps"), [*measured()])
def test_steps_to_rest_are_within_their_estimate(name, kind, configuration, courant, steps):
    """Compact bodies, slender ones that bend, a plate, and water that sloshes."""
    case, _, tolerance, _ = settle.SCENES[name][0](kind, configuration)
    case["time"]["step"]["courant"] = courant
    case = Case.model_validate(case | {"start": {"equilibrate": {"tolerance": tolerance}}})
    low, high = settling_steps(case, facts(case))
    assert low < steps < high
    # A slender body may bend, which takes longest, or be pressed along, like the strut.
    assert low > 0.03 * steps and high < 40.0 * steps


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_bodies_that_touch_rest_together(tolerance):
    """A tower of six is as slow as one body of its height; and what is asked for takes longer."""
    bodies = {f"b{n}": box([4.0 * n], [4.0 * n + 4.0]) | {"formulation": "total-lagrangian"}
              for n in range(6)}  # fmt: skip
    case = Case.model_validate(
        scene(1, bodies, cells=[28], step={"courant": 0.3}, gravity=[-1e-4],
              materials={"soft": BAR}, boundaries={"x-min": "fixed"},
              contact=[{"bodies": "all"}], start={"equilibrate": {"tolerance": tolerance}})
    )  # fmt: skip
    sim = Simulation(case, Serial())
    while sim.settling:
        sim.advance()
    low, high = settling_steps(case, facts(case))
    assert low < sim.step < high < 6.0 * sim.step


def test_no_more_than_are_allowed_and_none_without():
    case = read_case(PLATE + "gravity: [0.0, -1.0]\nboundaries: {x-min: fixed}\n", "x")
    assert settling_steps(case, facts(case)) == (0.0, 0.0)
    case = read_case(
        PLATE
        + "gravity: [0.0, -1.0]\nboundaries: {x-min: fixed}\nstart: {equilibrate: {steps: 9}}\n",
        "x",
    )
    assert settling_steps(case, facts(case)) == (9.0, 9.0)


def test_frames_while_a_stage_settles_are_counted(tmp_path):
    """As many as a run writes; of the steps before time 0 there are none."""
    body = box([0.0], [16.0]) | {"formulation": "total-lagrangian"}
    rest = {"equilibrate": {"tolerance": 1e-3}}
    case = scene(1, body, cells=[20], step=0.05, gravity=[-1e-2], boundaries={"x-min": "fixed"},
                 end=0.2, start=rest, output={"every": {"steps": 3}})  # fmt: skip
    case["materials"]["soft"]["young"] = 1e2
    case["time"]["stages"] = [{"name": "more", "gravity": [-2e-2], **rest}]
    checked = Case.model_validate(case)
    run = pgimp.run(case, output=tmp_path / "run", quiet=True)
    log = (tmp_path / "run" / "log.txt").read_text()
    steps = [float(number) for number in re.findall(r"settled in (\d+) steps", log)]
    assert len(steps) == 2 and min(steps) > 20
    # Frames of stages begin at a whole number of steps.
    assert forecast.frames(checked, 4.0, steps) == pytest.approx(len(run.frames), abs=1)
    assert forecast.frames(checked, 4.0) < len(run.frames) - 5


def test_output_by_steps_is_not_doubted_where_a_stage_settles():
    every = "every: {steps: 3000}"
    text = PLATE.replace(
        "{courant: 0.3}}", "{courant: 0.3}, stages: [{name: on, equilibrate: {}}]}"
    )
    assert "stages" in text
    for key in ("output", "history"):
        assert not list(forecast.warnings(read_case(text + f"{key}: {{{every}}}", "x"), 2000.0))


def test_check_says_the_estimate_and_what_it_does_not_count(capsys, monkeypatch):
    from pgimp.commands import check

    monkeypatch.setattr(check, "measure", lambda *scene: None)
    text = PLATE.replace(
        "{courant: 0.3}}", "{courant: 0.3}, stages: [{name: on, equilibrate: {steps: 600}}]}"
    ) + "gravity: [0.0, -1.0]\nboundaries: {x-min: fixed}\nstart: {equilibrate: {}}\n" \
        "output: {every: {steps: 20}}\n"  # fmt: skip
    check.report(read_case(text, "x"))
    lines = capsys.readouterr().out.splitlines()
    (first,) = (line for line in lines if line.startswith("settling"))
    mentions(first, "by estimate in", "at most 100,000", "not among those above", "checkpoints")
    (stage,) = (line for line in lines if line.startswith("stage 2"))
    mentions(stage, "settles at t = 1", "by estimate in", "at most 600")
    (memory,) = (line for line in lines if line.startswith("memory"))
    low, high = re.search(r"up to .*, in (\d+) to (\d+) frames", memory).groups()
    assert int(low) < int(high)
