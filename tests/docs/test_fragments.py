"""Parts of cases in the pages, whether blocks or in a line, are what the case file has."""

import ast
import json
import re

import pytest
from pages import FENCE, LINKED, PAGES, ROOT, TUTORIALS, block_of, blocks
from ruamel.yaml import YAML

from pgimp.case.reader import read_case
from pgimp.utilities.reference.jsonschema import json_schema, study_schema

YAML_SAFE = YAML(typ="safe")


def scene(dimensions, materials=("rubber",), bodies=("block",)):
    """A case of boxes side by side; the first material is that of all."""
    high = [1.0] * (dimensions - 1)
    return {
        "format": 1,
        "dimensions": dimensions,
        "grid": {"size": [30.0, *high], "cell": [0.1] * dimensions},
        "method": {"shape": "gimp", "particles-per-cell": [2] * dimensions},
        "time": {"end": 1.0, "step": {"courant": 0.3}},
        "materials": {
            name: {"model": "hooke", "young": 1.0e6, "poisson": 0.3, "density": 1000.0}
            for name in materials
        },
        "bodies": {
            name: {
                "material": materials[0],
                "region": {"box": {"min": [float(k), *[0.0] * len(high)], "max": [k + 1.0, *high]}},
            }
            for k, name in enumerate(bodies)
        },
    }


def file_of(name):
    """A case that comes with pgimp."""
    return YAML_SAFE.load(ROOT / "cases" / f"{name}.yaml")


def ground():
    """A case of soil and a fill, with room for both."""
    return scene(2, ("soil", "fill")) | {"grid": {"size": [8.0, 6.0], "cell": [0.5, 0.5]}}


def initial():
    """A case in 3D with all bodies in the initial configuration."""
    case = scene(3)
    for body in case["bodies"].values():
        body["formulation"] = "total-lagrangian"
    return case


def anvil():
    """A case in 2D of a rigid ball over a rigid anvil, beside a block exact to its surface."""
    case = scene(2, bodies=("block",))
    case["bodies"]["block"]["formulation"] = "total-lagrangian"
    ball = {"ball": {"centre": [6.0, 4.0], "radius": 1.0}}
    case["bodies"]["ball"] = {"rigid": {"density": 1.0}, "region": ball}
    plate = {"box": {"min": [4.0, 1.0], "max": [8.0, 2.0]}}
    case["bodies"]["anvil"] = {"rigid": {}, "region": plate}
    return case


def plate():
    """A case in 2D of a large plate in the initial configuration."""
    case = scene(2, bodies=("plate",)) | {"grid": {"size": [10.0, 10.0], "cell": [0.5, 0.5]}}
    plate = {
        "formulation": "total-lagrangian",
        "region": {"box": {"min": [0.0, 0.0], "max": [10.0, 10.0]}},
    }
    case["bodies"]["plate"] |= plate
    return case


def followed():
    """A case with a probe."""
    return file_of("bar-vibration") | {"probes": {"tip": {"body": "bar", "at": [1.0]}}}


def windy():
    """A case for which the functions of docs/own-functions.md are registered."""
    exec(compile(block_of("from math import exp, sin\n"), "wind.py", "exec"), {"__name__": "wind"})
    return scene(2)


#: Beginnings of blocks, a case that each belongs to, and the keys below which it stands there.
FRAGMENTS = (
    (
        "bodies:\n  block:\n    material: steel\n    region: {box: {min: [0.37",
        lambda: scene(2, ("steel",)) | {"grid": {"size": [5.0, 5.0], "cell": [0.5, 0.5]}},
        (),
    ),
    ("time:\n  end: 0.6  ", lambda: file_of("excavation"), ()),
    ("stages:\n  - {name: dig", lambda: file_of("excavation"), ("time",)),
    ("time:\n  end: 0.01 ", lambda: file_of("excavation"), ()),
    ("contact:\n  - {bodies: [block, plate]", lambda: scene(2, bodies=("block", "plate")), ()),
    ("dimensions: 2\ngeometry: axisymmetric", lambda: scene(2), ()),
    ("dimensions: 2\ngeometry: plane-stress", lambda: scene(2, ("sheet",)), ()),
    ("bodies:\n  bar:", lambda: scene(2), ()),
    ("bodies:\n  pile:", lambda: scene(1, ("concrete",)), ()),
    ("bodies:\n  ground:\n    material: steel", lambda: scene(3, ("steel",)), ()),
    ("bodies:\n  column:\n    material: clay", lambda: scene(2, ("clay",)), ()),
    ("bodies:\n  part:", lambda: scene(3, ("steel",)), ()),
    ("bodies:\n  core:", lambda: scene(3, ("steel", "rubber")), ()),
    ("region:\n", lambda: scene(2), ("bodies", "block")),
    ("materials:\n  steel:", lambda: scene(2, ("steel",)), ()),
    ("probes:\n  tip:", lambda: file_of("bar-vibration"), ()),
    ("probes:\n  edge:", plate, ()),
    ("accuracy: {of: probe.tip", followed, ()),
    ("gauges:\n  waist:", lambda: scene(2), ()),
    ("materials:\n  clay:", lambda: scene(2, ("clay",)), ()),
    ("young:\n", lambda: scene(2), ("materials", "rubber")),
    ("boundaries:\n  x-min: periodic", lambda: scene(2), ()),
    ("output:\n  fields: [unwrapped", lambda: file_of("plane-waves"), ()),
    ("output:\n  every: 0.1\n  surface:", lambda: file_of("brake-pad"), ()),
    ("gravity: [{sine", lambda: scene(2), ()),
    ("boundaries: {y-min: {unilateral: {friction: 0.3, rest", anvil, ()),
    ("boundaries:\n  y-min:\n    velocity:", lambda: scene(2), ()),
    ("bodies:                               # of a dam", ground, ()),
    ("constraints:\n  press:", lambda: scene(2), ()),
    ("constraints:\n  chuck:", lambda: scene(3, bodies=("shaft", *"abc")), ()),
    ("tractions:\n  bore:", lambda: scene(2), ()),
    ("tractions:\n  wheel:", lambda: scene(2), ()),
    ("inflow:\n  jet:", lambda: scene(2, ("water",)), ()),
    ("outflow:\n  x-max:", lambda: scene(2), ()),
    ("bodies:                               # by functions", windy, ()),
    ("method: {shape: gimp, particles-per-cell: [2, 2, 2], mass:", initial, ()),
    ("method: {shape: gimp, particles-per-cell: [2, 2], stress:", lambda: scene(2), ()),
)
#: Whole cases and studies are read elsewhere (test_readme.py), and this is a remark.
OTHERS = (
    "format: 1\n",
    "format: 2\n",
    "# safety.yaml\n",
    "# yaml-language-server: $schema=pgimp-schema.json\n",
)


def merged(beginning, case, keys):
    """The case with what the block says in place of what it has."""
    there = case
    for key in keys:
        there = there[key]
    there.update(YAML_SAFE.load(block_of(beginning)))
    return case


def read(case):
    """Read a case given by its content."""
    return read_case(json.dumps(case), "the case of a page")


def test_every_block_is_read():
    starts = (*OTHERS, *(beginning for beginning, *_ in FRAGMENTS))
    for text in blocks("yaml"):
        assert text.startswith(starts), text
    assert all(kind != "yaml" for kind, _ in FENCE.findall(LINKED["cases/README.md"]))


@pytest.mark.parametrize(("beginning", "base", "keys"), FRAGMENTS, ids=lambda v: str(v)[:20])
def test_blocks_are_parts_of_cases(beginning, base, keys, tmp_path, monkeypatch):
    """So is the case without it; a key of the block that is written otherwise is refused."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "quake.csv").write_text("time, ax\n0.0, 0.0\n0.1, 0.2\n0.2, -0.2\n")
    read(base())
    case = merged(beginning, base(), keys)
    read(case)


def names(schema):
    """All keys that a schema has, at any depth; in a case also faces."""
    if isinstance(schema, dict):
        yield from schema.get("properties", {})
        yield from schema.get("propertyNames", {}).get("enum", ())
        for value in schema.values():
            yield from names(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from names(value)


def keys_of(value):
    """All keys of a value as YAML reads it."""
    if isinstance(value, dict):
        for key, below in value.items():
            yield from str(key).split(".")
            yield from keys_of(below)
    elif isinstance(value, list):
        for below in value:
            yield from keys_of(below)


def test_keys_in_lines_of_text_exist():
    """As in `affine: true`, or `output: {grid: [contact]}`."""
    known = {*names(json_schema()), *names(study_schema())}
    found, cases = 0, LINKED["cases/README.md"]
    for name, text in (PAGES | TUTORIALS | {"cases/README.md": cases}).items():
        for code in re.findall(r"`([a-z][\w.-]*: [^`]*)`", FENCE.sub("", text)):
            code = " ".join(code.split())
            if "Literal[" in code or name == "docs/developing.md":  # which adds to the package
                continue
            for key in keys_of(YAML_SAFE.load(code)):
                assert key in known, f"{name}: {code}: there is no key {key}"
            found += 1
    assert found > 40


def test_the_state_that_is_declared_is_that_of_softening():
    text = (ROOT / "cases/softening.py").read_text(encoding="utf-8")
    (there,) = [
        node.value
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "STATE"
    ]
    printed = block_of("from pgimp.physics.materials import State\n")
    assert f"STATE = {ast.unparse(there)}" in ast.unparse(ast.parse(printed))
    exec(compile(printed, "docs/materials.md", "exec"), {})
