"""What `pgimp schema` prints: the JSON schema for editors and the reference for people."""

import json
import re
import sys
from pathlib import Path

import pytest
from bad_cases import GOOD
from case_strategies import cases
from hypothesis import given, settings
from processes import run
from schema_checker import Checker

from pgimp.case.reader import read_case
from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.physics.fields import FIELDS
from pgimp.scene.scene import Scene
from pgimp.schema.document import parse
from pgimp.schema.overrides import apply
from pgimp.solver.history.columns import HISTORY
from pgimp.solver.history.diagnostics import column_names
from pgimp.utilities.reference.jsonschema import json_schema

#: What loses energy in all ways.
METAL = {"model": "johnson-cook", "young": 1, "poisson": 0, "density": 1, "a": 1, "b": 1, "n": 1,
         "c": 0, "m": 1, "reference-rate": 1, "specific-heat": 1, "temperature": 1,
         "melting": 2}  # fmt: skip
WATER = {"model": "newtonian", "bulk": 1, "density": 1}

PAGE = Path(__file__).parents[3] / "cases" / "reference.md"


def test_reference_is_current():
    """In a process of its own: what other tests have registered is not in the reference."""
    done = run([sys.executable, "-m", "pgimp", "schema", "--markdown"])
    assert done.stdout == PAGE.read_text(encoding="utf-8"), (
        "run: pgimp schema --markdown > cases/reference.md"
    )


def test_the_reference_covers_what_frames_and_history_hold():
    page = PAGE.read_text(encoding="utf-8")
    columns = [column.name for group in HISTORY for column in group.columns]
    for name in [*FIELDS, *columns]:
        assert f"| `{name}` |" in page


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_every_column_of_the_history_is_written(dimensions):
    def vector(number):
        return [number] * dimensions

    def box(low):
        return {"box": {"min": vector(low), "max": vector(low + 1)}}

    case = Case.model_validate(
        {
            "format": 1,
            "dimensions": dimensions,
            "grid": {"size": vector(4), "cell": vector(1)},
            "method": {"shape": "mpm", "particles-per-cell": vector(1)},
            "time": {
                "end": 1,
                "step": {"courant": 0.3},
                "stages": [{"name": "next", "end": 2, "remove": ["b"], "add": ["ab"]}],
            },
            "materials": {"m": METAL, "w": {**WATER, "shear-viscosity": 1}},
            "bodies": {
                "a": {"material": "m", "region": box(0)},
                "b": {"material": "w", "region": box(1)},
                "ab": {"material": "m", "region": box(0)},
                "aba": {"rigid": {"density": 1}, "region": box(2)},
                "baa": {"rigid": {}, "region": box(3)},
            },
            "boundaries": {"x-min": "unilateral"},
            "outflow": {"x-max": "remove"},
            "constraints": {
                "b": {
                    "body": "b",
                    "region": box(1),
                    "velocity": vector(0),
                    **({"rotation": {"about": vector(1), "rate": 1}} if dimensions > 1 else {}),
                }
            },
            "tractions": {"ab": {"body": "ab", "region": box(0), "pressure": 1}},
            "inflow": {"a": {"velocity": [-1, *vector(0)[1:]]}},
            "contact": [{"bodies": ["a", "b"]}],
            "gauges": {
                "a": {"cut": box(0), "mean": 1},
                "b": {"flux": box(1), "mean": 1},
                "ab": {"wall": "x-min", "mean": 1},
                **({"aba": {"level": vector(1)[1:], "mean": 1}} if dimensions > 1 else {}),
            },
        }
    )
    columns = column_names(Scene(case.stages[-1]))
    assert len(set(columns)) == len(columns)
    names = [
        column.name.replace("AXIS", "[xyz]").replace("NAME", "[ab+]+").replace("FACE", "x-min")
        for group in HISTORY
        for column in group.columns
    ]
    unwritten = [name for name in names if not any(re.fullmatch(name, each) for each in columns)]
    # Errors against an exact solution: tests/physics/exact/test_exact_errors.py. Damping is not
    # for rigid bodies that move freely: tests/solver/damping/test_damping.py. What absorbing faces
    # radiate: tests/solver/damping/test_absorbing.py. Stages that settle: test_settling_stages.py.
    # The factor of mass scaling: test_mass_scaling.py. Places and moments of contact by surfaces:
    # tests/solver/contact/surfaces/test_surface_loads.py.
    moments = ("angular", "angle", "torque", "moment", "height", "top") if dimensions == 1 else ()
    places = "contact.[ab+]+.centre", "contact.[ab+]+.moment"
    others = ("error", "damped", "radiated", "settling", "scaling", *places, *moments)
    assert all(any(part in name for part in others) for name in unwritten)


_NAMED = {"materials": "NAME", "bodies": "NAME", "boundaries": "FACE", "outflow": "NAME"}


def keys(data, path=""):
    """Every key path of plain data, with names for what the case names."""
    for name, value in data.items() if isinstance(data, dict) else ():
        name = _NAMED.get(path, name)
        below = f"{path}.{name}" if path else name
        if below != f"{path}.FACE" or isinstance(value, dict):
            yield below
        yield from keys(value, below)


@settings(max_examples=30, deadline=None)
@given(cases())
def test_the_reference_has_every_key(data):
    page = PAGE.read_text(encoding="utf-8")
    resolved = Case.model_validate(data).model_dump(by_alias=True)
    for key in keys(resolved):
        if not key.endswith((".NAME", ".FACE")):
            assert f"| `{key}` |" in page


def test_every_key_is_described():
    described = 0

    def walk(schema):
        nonlocal described
        for name, value in schema.get("properties", {}).items():
            assert value.get("description"), name
            described += 1
        for value in schema.values():
            for item in value if isinstance(value, list) else [value]:
                if isinstance(item, dict):
                    walk(item)

    walk(json_schema())
    assert described > 50


@settings(max_examples=60, deadline=None)
@given(cases())
def test_editors_accept_what_pgimp_accepts(data):
    check = Checker(json_schema())
    assert check(data)
    assert check(json.loads(json.dumps(Case.model_validate(data).model_dump(by_alias=True))))


@pytest.mark.parametrize(
    ("override", "editors_see"),
    [
        ("time.stepp=1", True),
        ("time.end=-1", True),
        ("time.end=true", True),
        ('time.end="1"', True),
        ("time.step={courant: 2}", True),
        ("dimensions=4", True),
        ("boundaries.left=fixed", True),
        ("boundaries.x-max=fix", True),
        ("materials.steel.model=hook", True),
        ("materials.steel.poisson=0.5", True),
        ("materials.1a={model: hooke, young: 1, poisson: 0, density: 1}", True),
        ("bodies.left.region={box: {min: [0, 0]}}", True),
        ("bodies.left.region={union: [{ball: {centre: [1, 1], radius: 0}}]}", True),
        ("bodies.left.velocity={rotation: {about: [0, 0]}}", True),
        ("output.fields=[heat]", True),
        ("gravity={table: [[0]]}", True),
        # What a schema cannot say.
        ("grid.cell=[0.3, 0.5]", False),
        ("bodies.left.material=stone", False),
    ],
)
def test_editors_see_mistakes(override, editors_see):
    document = parse(GOOD, "case.yaml")
    check = Checker(json_schema())
    assert check(document.data)
    with pytest.raises(CaseError):
        read_case(GOOD, overrides=[override])
    apply(document, [override])
    assert check(document.data) is not editors_see


def test_schema_command_prints_json(capsys):
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out) == json_schema()
