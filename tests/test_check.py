"""``pgimp check`` points at mistakes of units, of the step and of the duration."""

import pytest

from pgimp.case.reader import read_case
from pgimp.commands import check
from pgimp.commands.init import packaged
from pgimp.parallel.comm import Serial
from pgimp.scene.doubts import doubts, idle_step, strains
from pgimp.scene.scene import Scene, count_particles

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


def facts(case):
    scene = Scene(case)
    lattice, counts, _ = count_particles(scene, Serial())
    return [check._facts(scene, lattice, counts, body) for body in range(len(case.bodies))]


def said(case):
    return [text for body in facts(case) for text in doubts(case, body, case.time.end)]


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
        (MM | {"density": 7850.0}, ["loads of the order", "density 7850 would be 7.85e+15"]),
        # Pa with tonnes and mm: waves a thousand times too fast.
        (MM | {"young": 2.1e11}, ["wave speed 5.172e+09 would be 5.17e+06 m/s"]),
        # GPa in metres.
        (SI | {"young": 210.0}, ["loads of the order"]),
        # g/cm^3 in metres.
        (SI | {"density": 7.85e-3}, ["density 0.00785 would be 0.00785 kg/m^3"]),
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
            "by prescribed velocities": 0.07,
        }
    )
    assert free["by prescribed velocities"] == pytest.approx(0.05)
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
    text = idle_step(dt, 1.0)
    assert (fewer in text) and bool(text) == bool(fewer)


def test_the_report_has_the_warnings(capsys, monkeypatch):
    """A step of a tenth of a thousandth of what is stable, in a block with mixed units."""
    monkeypatch.setattr(check, "_report_cost", lambda *scene: None)  # it compiles and measures
    case = block(**(MM | {"density": 7850.0}), end=1.0)
    case = case.model_copy(update={"time": case.time.model_copy(update={"step": 1.0e-4})})
    check.report(case)
    warnings = [line for line in capsys.readouterr().out.splitlines() if "warning: " in line]
    about = ["time.step", "bodies.block", "materials of block: density", "materials", "time.end"]
    assert all(f"warning: {words}" in line for words, line in zip(about, warnings, strict=True))
    assert warnings[0].startswith("warning: time.step: 0.0001 is a Courant number of 5.17e-05")


def test_packaged_cases_are_not_doubted():
    for name, text in packaged().items():
        if "/" not in name:
            assert said(read_case(text, name)) == [], name
