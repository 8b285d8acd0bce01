"""``pgimp check`` points at mistakes of units, of the step and of the duration."""

import pytest
from checked import MM, SI, block, facts, plate, said

from pgimp.case.reader import read_case
from pgimp.commands.init import packaged
from pgimp.running import forecast
from pgimp.running.schedule import Schedule
from pgimp.scene.checks.sanity import small_step_warning, strains
from pgimp.scene.checks.units import in_si


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
method: {shape: gimp, particles-per-cell: [2]}
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
        ("checkpoint: {every: {wall-time: 9.0}}", None),
        ("probes: {p: {place: [1, 1], every: 3}}", "probes.p.every: 3 is beyond the end at 1"),
    ],
)
def test_output_that_never_falls_due(output, expected):
    found = list(forecast.warnings(plate(output), 2000.0))
    assert [text[: len(expected)] for text in found] == [expected] if expected else not found


def test_steps_to_rest_have_checkpoints():
    """Nobody knows how many there are; of frames there is none before time 0."""
    every = "{every: {steps: 3000}}\nstart: {equilibrate: {}}"
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


def test_numbers_in_si():
    numbers = in_si(block(**MM), "steel")
    assert numbers["young"] == (pytest.approx(2.1e11), "Pa")
    assert numbers["density"] == (pytest.approx(7850.0), "kg/m^3")
    assert in_si(block(**MM | {"units": "none"}), "steel") == {}
