"""The case file: what is accepted, defaults, overrides, writing and reading back, the schema."""

import json
import re
from typing import Literal

import numpy as np
import pytest
from bad_cases import GOOD
from case_strategies import cases, rows
from hypothesis import given, settings
from hypothesis import strategies as st

from pgimp.case.reader import dump_case, read_case
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.physics.materials import MATERIALS
from pgimp.schema.tables import Table
from pgimp.utilities.reference.jsonschema import json_schema

SMALL = """
format: 1
dimensions: 1
grid: {size: [54], cell: [1]}
method: {shape: gimp, particles-per-cell: [2]}
time: {end: 2.0, step: 1e-4}
materials: {bar: {model: linear-1d, young: 1e6, density: 1}}
bodies: {bar: {material: bar, region: {box: {min: [0], max: [50]}}}}
"""


def test_defaults_are_explicit():
    case = read_case(SMALL)
    assert case.title == ""
    assert case.units == "none"
    assert case.grid.origin == (0.0,)
    assert case.grid.cells == (54,)
    assert case.grid.corner == (54.0,)
    assert case.time.steps == 20_000
    assert case.method.volume == "tracked"
    assert case.bodies["bar"].velocity == (0.0,)
    assert case.gravity is None
    assert case.boundaries == {}
    assert case.output.every is None
    assert case.output.at == ()
    assert case.output.fields == ("velocity", "stress")
    assert case.history.every.steps == 100
    text = dump_case(case)
    for key in ("title", "units", "origin", "velocity", "gravity", "boundaries", "at", "steps"):
        assert re.search(rf"\b{key}: ", text)


@pytest.mark.parametrize("number", ["1000000", "1e6", "1.0e6", "+1E+6", "1.e6", "1000000.0"])
def test_numbers_are_the_same_however_they_are_written(number):
    assert read_case(SMALL.replace("1e6", number)) == read_case(SMALL)


@pytest.mark.parametrize("count", ["2", "2.0", "0.2e1", "+2"])
def test_whole_numbers_are_the_same_however_they_are_written(count):
    case = read_case(SMALL, overrides=[f"method.particles-per-cell=[{count}]"])
    assert case.method.particles_per_cell == (2,)
    assert type(case.method.particles_per_cell[0]) is int


def test_a_file_from_any_editor_is_read():
    text = GOOD.replace("Two bodies", "Höhe")
    for content in (text.encode(), b"\xef\xbb\xbf" + text.encode(), text.replace("\n", "\r\n")):
        assert read_case(content) == read_case(text)


def test_rounding_does_not_make_sizes_and_times_odd():
    case = read_case(SMALL, overrides=["grid.cell=[0.1]", "grid.size=[50.1]", "time.end=0.3"])
    assert case.grid.cells == (501,)
    assert case.time.steps == 3000
    with pytest.raises(CaseError, match=r"time\.end"):
        read_case(SMALL, overrides=["time.end=0.300000001"])


def test_a_courant_step_has_no_number_of_steps():
    case = read_case(SMALL, overrides=["time.step={courant: 0.3}", "time.end=0.12345"])
    assert case.time.steps is None
    assert case.time.step.courant == 0.3


def test_overrides_change_make_and_replace():
    overrides = [
        "time.end=3",
        "time.end=2",
        "title=Länger = besser",
        "bodies.left.velocity.0=4",
        "gravity.table.1.1=[0, -5]",
        "history.every.steps=5",
        "output={every: {steps: 7}}",
        "boundaries.x-max=slip",
        "materials.rubber={model: neo-hookean, young: 1, poisson: 0.4, density: 2}",
        "bodies.left.material=rubber",
    ]
    case, before = read_case(GOOD, overrides=overrides), read_case(GOOD)
    assert case.time.end == 2.0
    assert case.title == "Länger = besser"
    assert case.bodies["left"].velocity == (4.0, 0.0)
    assert case.gravity.table == ((0.0, (0.0, 0.0)), (1.0, (0.0, -5.0)))
    assert case.history.every.steps == 5
    assert case.output.every.steps == 7
    assert case.output.fields == ("velocity", "stress")
    assert list(case.boundaries) == ["x-min", "y-min", "x-max"]
    assert case.bodies["left"].material == "rubber"
    assert case.bodies["right"] == before.bodies["right"]
    made = read_case(SMALL, overrides=["output.every=0.5", "boundaries.x-min=fixed"])
    assert made.output.every == 0.5
    assert isinstance(made.boundaries["x-min"], type(before.boundaries["x-min"]))


def test_a_material_registered_later_is_known_everywhere(monkeypatch):
    class Putty(MATERIALS["hooke"]):
        """A material from outside the package."""

        model: Literal["putty"]
        grip: float

    text = SMALL.replace("linear-1d", "putty").replace("young:", "poisson: 0.1, grip: 2, young:")
    with pytest.raises(CaseError, match="unknown model 'putty'"):
        read_case(text)
    monkeypatch.setitem(MATERIALS, "putty", Putty)
    case = read_case(text)
    assert type(case.materials["bar"]) is Putty
    for value in (".nan", ".inf", '"2"', "true"):
        with pytest.raises(CaseError, match=r"materials\.bar\.grip: expected a"):
            read_case(text, overrides=[f"materials.bar.grip={value}"])
    assert read_case(dump_case(case)) == case
    assert "putty" in json.dumps(json_schema())


# Writing and reading back


def test_the_resolved_case_reads_like_one_written_by_hand():
    assert dump_case(read_case(SMALL)) == (
        "format: 1\n"
        'title: ""\n'
        "units: none\n"
        "dimensions: 1\n"
        "geometry: plane-strain\n"
        "grid: {origin: [0.0], size: [54.0], cell: [1.0]}\n"
        "method:\n"
        "  shape: gimp\n"
        "  particles-per-cell: [2]\n"
        "  pic-damping: auto\n"
        "  affine: false\n"
        "  volumetric: pointwise\n"
        "  stress: last\n"
        "  mass: lumped\n"
        "  volume: tracked\n"
        "  wall: auto\n"
        "time: {end: 2.0, step: 0.0001, mass-scaling: 1.0, stages: []}\n"
        "start: {stress: null, equilibrate: null}\n"
        "materials:\n"
        "  bar: {model: linear-1d, density: 1.0, viscosity: null, young: 1000000.0}\n"
        "bodies:\n"
        "  bar:\n"
        "    material: bar\n"
        "    region: {box: {min: [0.0], max: [50.0]}}\n"
        "    surface: cut-particles\n"
        "    velocity: [0.0]\n"
        "    formulation: updated-lagrangian\n"
        "    mass: null\n"
        "    volumetric: null\n"
        "gravity: null\n"
        "body-force: null\n"
        "water: null\n"
        "damping: null\n"
        "boundaries: {}\n"
        "outflow: {}\n"
        "tractions: {}\n"
        "constraints: {}\n"
        "inflow: {}\n"
        "contact: []\n"
        "exact: null\n"
        "output:\n"
        "  every: null\n"
        "  at: []\n"
        "  fields: [velocity, stress]\n"
        "  grid: []\n"
        "  surface: []\n"
        "  precision: float64\n"
        "  compression: none\n"
        "history: {every: {steps: 100}}\n"
        "probes: {}\n"
        "gauges: {}\n"
        "checkpoint: {every: {wall-time: 900.0}, keep: 2}\n"
        "accuracy: null\n"
    )


@settings(max_examples=200, deadline=None)
@given(cases())
def test_a_case_written_and_read_back_is_the_same_bit_for_bit(data):
    case = Case.model_validate(data)
    text = dump_case(case)
    again = read_case(text)
    assert again == case
    # Unlike ==, the text tells 0.0 from -0.0 and shows every bit of a number.
    assert repr(again) == repr(case)
    assert dump_case(again) == text
    assert again.title == data["title"]


# Tables


@given(st.data())
def test_a_table_is_numpys_interpolation(data):
    table = Table(table=rows(data.draw, st.floats(-1e6, 1e6)))
    times, values = np.array(table.table).T
    instants = [-1e9, *times, *(times[:-1] + 0.3 * np.diff(times)), 1e9]
    for t in instants:
        assert table.value(t) == pytest.approx(np.interp(t, times, values), rel=1e-12, abs=1e-9)
    assert [table.value(t) for t in times] == pytest.approx(values, rel=1e-12, abs=1e-9)
    assert table.value(-1e9) == values[0]
    assert table.value(1e9) == values[-1]


def test_gravity_by_table_is_linear_and_held():
    gravity = read_case(GOOD).gravity
    assert gravity.value(0.5) == (0.0, -4.905)
    assert gravity.value(-1.0) == (0.0, 0.0)
    assert gravity.value(7.0) == (0.0, -9.81)
