"""``pgimp check`` points at mistakes of units, of the step and of the duration."""

import re
from itertools import product

import pytest
from checked import PLATE, facts, plate, said
from mentioned import mentions

from pgimp.case.load import load
from pgimp.case.reader import read_case
from pgimp.commands import check
from pgimp.commands.init import packaged
from pgimp.running import forecast
from pgimp.running.schedule import Schedule
from pgimp.scene.checks.sanity import small_step_warning, strains
from pgimp.scene.checks.units import in_si
from pgimp.scene.scene import Scene
from pgimp.utilities.check.steps import report_stages
from pgimp.utilities.model.costs import Costs

# A steel block of 0.1 m on a floor, in each of two consistent sets of units, and mixed up.
SI = {"units": "m, kg, s", "young": 2.1e11, "density": 7850.0, "side": 0.1, "gravity": 9.81}


MM = {"units": "mm, t, s", "young": 2.1e5, "density": 7.85e-9, "side": 100.0, "gravity": 9810.0}


BLOCK = """
format: 1
units: {units}
dimensions: 1
grid: {{size: [{twice}], cell: [{cell}]}}
method: {{shape: gimp, particles_per_cell: [2]}}
time: {{end: {end}, step: {{courant: 0.3}}}}
materials: {{steel: {{model: linear-1d, young: {young}, density: {density}}}}}
bodies: {{block: {{material: steel, region: {{box: {{min: [0.0], max: [{side}]}}}}}}}}
gravity: [-{gravity}]
boundaries: {{x-min: fixed}}
"""


def block(end=1.0e-3, **of):
    text = BLOCK.format(**of, end=end, twice=2.0 * of["side"], cell=0.1 * of["side"])
    return read_case(text, "block.yaml")


@pytest.mark.parametrize("units", [SI, MM])
def test_consistent_units_are_not_doubted(units):
    assert said(block(**units)) == []
    (body,) = facts(block(**units))
    strain = units["density"] * units["gravity"] * units["side"] / units["young"]
    assert strains(block(**units), body)["by its own weight"] == pytest.approx(strain)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        # MPa with kg/m^3: soft as a cloud, and as heavy as nothing that there is.
        (MM | {"density": 7850.0}, ["loads of the order", "steel.density: 7850 would be 7.85e+15"]),
        # Pa with tonnes and mm: waves a thousand times too fast.
        (
            MM | {"young": 2.1e11},
            ["young: 2.1e+11 would be 2.1e+17 Pa", "5.172e+09 would be 5.17e+06 m/s"],
        ),
        # GPa in metres.
        (SI | {"young": 210.0}, ["loads of the order"]),
        # g/cm^3 in metres.
        (SI | {"density": 7.85e-3}, ["steel.density: 0.00785 would be 0.00785 kg/m^3"]),
        (SI | {"units": "SI"}, []),
        # Nothing is known of other units.
        (SI | {"density": 7.85e-3, "units": "none"}, []),
    ],
)
def test_units_mixed_up(change, expected):
    texts = said(block(**change))
    assert all(any(words in text for text in texts) for words in expected), texts
    assert bool(texts) == bool(expected)


def test_loads_of_every_kind():
    """Of a bar with wave speed 1000 and modulus 1e6."""
    case = read_case(
        """
format: 1
dimensions: 1
grid: {size: [20.0], cell: [1.0]}
method: {shape: gimp, particles_per_cell: [2]}
time: {end: 0.1, step: {courant: 0.3}}
materials: {bar: {model: linear-1d, young: 1.0e6, density: 1.0}}
bodies:
  bar: {material: bar, velocity: [-30.0], region: {box: {min: [5.0], max: [15.0]}}}
  free: {material: bar, region: {box: {min: [16.0], max: [18.0]}}}
gravity: {table: [[0.0, [0.0]], [1.0, [-4000.0]], [2.0, [10.0]]]}
boundaries: {x-min: {velocity: [{table: [[0.0, 0.0], [1.0, -50.0]]}]}}
tractions: {pull: {body: bar, face: x-max, pressure: {table: [[0.0, 1.0e5], [1.0, -2.0e5]]}}}
constraints: {grip: {body: bar, region: {box: {min: [5.0], max: [6.0]}}, velocity: [-70.0]}}
"""
    )
    bar, free = (strains(case, body) for body in facts(case))
    assert bar == pytest.approx(
        {
            "by its own weight": 0.04,
            "by stopping its velocity": 0.03,
            "by its tractions": 0.2,
            "by waves of prescribed velocities": 0.07,
        }
    )
    assert free["by waves of prescribed velocities"] == pytest.approx(0.05)
    assert "by its tractions" not in free


@pytest.mark.parametrize(
    ("end", "expected"),
    [
        (1.0e-6, ["time.end: until then a wave crosses only 0.052 of block"]),  # 0.1 m at 5172 m/s
        (100.0, ["time.end: waves cross block 5.17e+06 times until then"]),
    ],
)
def test_durations(end, expected):
    texts = said(block(end=end, **SI))
    assert len(texts) == 1
    assert texts[0].startswith(expected[0])


@pytest.mark.parametrize(("dt", "fewer"), [(1.0e-3, "300 times fewer"), (0.02, "")])
def test_step_that_is_far_too_short(dt, fewer):
    texts = small_step_warning(dt, 1.0)
    assert len(texts) == bool(fewer) and all(fewer in text for text in texts)


@pytest.fixture
def unmeasured(monkeypatch):
    """A report without what compiles and measures."""
    monkeypatch.setattr(check, "measure", lambda *scene: None)
    monkeypatch.setattr(check, "pilot", lambda *case: None)
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
    assert ids == ["short-step", "load-strain", "units", "units", "few-transits"]
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


def test_packaged_cases_are_not_doubted():
    for name, text in packaged().items():
        if "/" not in name:
            assert said(read_case(text, name)) == [], name


@pytest.mark.parametrize(
    ("output", "expected"),
    [
        ("", None),
        ("output: {every: 0.5}", None),
        ("output: {every: 1.0}", None),
        ("output: {every: 5.0}", "output.every: 5 is beyond the end at 1; there are frames only"),
        ("output: {every: {steps: 3000}}", "output.every: 3,000 steps are more than the run takes"),
        ("output: {every: 1.0e-5}", None),
        ("history: {every: 2.0}", "history.every: 2 is beyond the end at 1; there are lines only"),
        ("checkpoint: {every: 2.0}", "checkpoint.every: 2 is beyond the end at 1; there are no"),
        ("checkpoint: {every: {wall: 9.0}}", None),
        ("probes: {p: {place: [1, 1], every: 3}}", "probes.p.every: 3 is beyond the end at 1"),
    ],
)
def test_output_that_never_falls_due(output, expected):
    found = list(forecast.warnings(plate(output), 2000.0))
    assert [text[: len(expected)] for text in found] == [expected] if expected else not found


def test_steps_to_rest_have_checkpoints():
    """Nobody knows how many there are; of frames there is none before time 0."""
    every = "{every: {steps: 3000}}\nstart: {settle: {}}"
    assert not list(forecast.warnings(plate(f"checkpoint: {every}"), 2000.0))
    assert len(list(forecast.warnings(plate(f"output: {every}"), 2000.0))) == 1


@pytest.mark.parametrize(
    ("output", "keys"),
    [
        ("", []),
        ("output: {every: {steps: 1}}", []),
        ("output: {every: 0.0006}", []),
        ("output: {every: 0.0004}", ["output.every"]),
        ("history: {every: 0.0004}\nprobes: {p: {place: [1, 1], every: 0.0001}}",
         ["history.every", "probes.p.every"]),
    ],
)  # fmt: skip
def test_output_between_steps(output, keys):
    """The plate has 2000 steps of 0.0005."""
    found = list(forecast.notes(plate(output), 2000.0))
    assert [text.partition(":")[0] for text in found] == keys


@pytest.mark.parametrize(
    ("output", "number"),
    [
        ("", 2),
        ("output: {every: 0.3}", 5),
        ("output: {every: 0.1, at: [0.05, 1.0]}", 12),
        ("output: {every: {steps: 7}}", 4),
        ("output: {every: 1.0e-9}", 21),
        ("output: {every: 1.0}", 2),
    ],
)
def test_number_of_frames(output, number):
    """By the schedule that a run keeps to, in 20 steps."""
    case = plate(output)
    schedule = Schedule(case.output.every, case.output.at)
    steps = [n for n in range(1, 21) if schedule.due(n / 20, n, 0.05)]
    assert len({0, 20, *steps}) == number == forecast.frames(case, 20.0)


def test_transits_are_those_of_all_stages(capsys, unmeasured):
    """5172 m/s over 0.1 m: 51.7 in the first millisecond, and twice that in the second stage."""
    data = block(**SI).model_dump(by_alias=True)
    data["time"]["stages"] = [{"name": "on", "end": 3.0e-3}]
    check.report(load(data))
    assert "; the run lasts 155 transits" in capsys.readouterr().out


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


def test_numbers_in_si():
    numbers = in_si(block(**MM), "steel")
    assert numbers["young"] == (pytest.approx(2.1e11), "Pa")
    assert numbers["density"] == (pytest.approx(7850.0), "kg/m^3")
    assert in_si(block(**MM | {"units": "none"}), "steel") == {}


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
    for words in ("valid", " particles in ", "transits", "Courant", "memory ", "output ", "time "):
        assert words in text
    check.report(case, verbose=True)
    long = capsys.readouterr().out
    assert len(long.splitlines()) > len(short) + 3 and "strain by" in long
