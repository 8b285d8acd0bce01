"""Words that were renamed: old ones are read as new ones, everywhere, and renewed on request."""

from copy import deepcopy
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mentioned import mentions

import pgimp
from pgimp.case.reader import read_case
from pgimp.case.schema import Case
from pgimp.case.writer import dump_case, flow
from pgimp.commands.check import _write
from pgimp.errors import CaseError
from pgimp.io.results import history
from pgimp.io.results.tables import Table
from pgimp.schema.document import parse
from pgimp.schema.words.renamed import COLUMNS, KEYS, VALUES, new_column
from pgimp.schema.words.renew import renewed, renewed_text

SOIL = """\
format: 1
dimensions: 2
grid: {size: [8.0, 4.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2], volumetric: b-bar, pic-damping: 1.0}
time:
  end: 0.1
  step: 0.001
  stages:
    - {name: weak, strength-reduction: {factor: 1.2}, equilibrate: {steps: 100}}
    - {name: more, end: 0.2, method: {pic-damping: 0.5}, outflow: {x-max: remove},
       boundaries: {x-min: {unilateral: {friction: 0.1}}, x-max: null}}
start: {equilibrate: {tolerance: 1.0e-3}}
materials:
  soil: {model: mohr-coulomb, young: 1.0e6, poisson: 0.3, density: 2000.0, cohesion: 1.0e3,
         friction-angle: 30.0, dilation-angle: 0.0}
bodies:
  ground: {material: soil, region: {box: {min: [0.0, 0.0], max: [4.0, 2.0]}},
           formulation: updated-lagrangian}
gravity: [0.0, -10.0]
boundaries: {x-min: {unilateral: {friction: 0.2}}, y-min: unilateral, x-max: slip}
checkpoint: {every: {wall-time: 60}}
"""
SOLIDS = """\
format: 1
dimensions: 2
grid: {size: [12.0, 6.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 0.1, step: 0.001}
materials: {soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}}
bodies:
  a: {material: soft, region: {box: {min: [1.0, 1.0], max: [3.0, 3.0]}}, surface: cut-particles,
      formulation: total-lagrangian}
  b: {material: soft, region: {box: {min: [3.0, 1.0], max: [5.0, 3.0]}},
      formulation: total-lagrangian}
  c: {rigid: {velocity: [-1.0, 0.0]}, region: {box: {min: [7.0, 1.0], max: [9.0, 3.0]}}}
body-force: {rotating-frame: {rate: 1.0, about: [0.0, 0.0]}}
contact:
  - {bodies: [a, b], law: tie}
  - {bodies: [b, c], adhesion: {normal: 1.0, range: 0.1}}
accuracy: {of: rigid.c.force-x, within: 2 %}
"""
WAVE = """\
format: 1
dimensions: 2
grid: {size: [8.0, 2.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 0.1, step: 0.001}
materials: {soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}}
bodies:
  body: {material: soft, surface: whole-particles,
         region: {box: {min: [0.0, 0.0], max: [8.0, 2.0]}}}
boundaries: {x-min: periodic, x-max: periodic, y-min: periodic, y-max: periodic}
exact: {plane-wave: {polarization: y, amplitude: 0.01, wavenumber: 2, velocity: [0.5, 0.2]}}
"""
GROUND = """\
format: 1
dimensions: 2
grid: {size: [8.0, 4.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 0.1, step: 0.001}
materials: {soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}}
bodies:
  ground:
    material: soft
    region:
      union:
        - heights: {file: hill.csv, bottom: 0.0, window: {min: [1.0], max: [7.0]}}
        - box: {min: [1.0, 0.0], max: [2.0, 3.0]}
boundaries: {x-min: {absorbing: {static-force: fixed}}, y-min: fixed}
"""
CASES = {"soil": SOIL, "solids": SOLIDS, "wave": WAVE, "ground": GROUND}
OF_STUDIES = {("bisect", "slide", "failure-displacement")}
ENTRIES = [entry for entry in (*KEYS, *VALUES) if entry not in OF_STUDIES]


@pytest.fixture(autouse=True)
def hill(tmp_path, monkeypatch):
    (tmp_path / "hill.csv").write_text("0 1\n4 2\n8 1\n")
    monkeypatch.chdir(tmp_path)


def fits(pattern, path):
    """Whether keys are at a place of the table; in a stage as in the case."""
    for text in (".".join(path), ".".join(path[3:] if path[:2] == ("time", "stages") else path)):
        if fnmatchcase(text, pattern.replace("**.", "*.")):
            return True
    return False


def older(data, entries, path=()):
    """The data with old words of some entries of the tables."""
    if isinstance(data, list):
        return [older(item, entries, (*path, str(i))) for i, item in enumerate(data)]
    if isinstance(data, dict):
        names = {new: old for where, old, new in entries if (where, old, new) in KEYS
                 and new in data and fits(where, path)}  # fmt: skip
        return {names.get(k, k): older(v, entries, (*path, k)) for k, v in data.items()}
    words = {new: old for where, old, new in entries if (where, old, new) in VALUES
             and fits(where, path)}  # fmt: skip
    return words.get(data, data) if isinstance(data, str) else data


def text_of(data):
    return "".join(f"{key}: {flow(data[key])}   # {i}\n\n" for i, key in enumerate(data))


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: f"{entry[0]}.{entry[1]}")
def test_an_old_word_is_read_as_the_new_one(entry):
    """From a file, from a dictionary, and as an override; what is renewed is the file with it."""
    found = 0
    for text in CASES.values():
        new = parse(text, "case").data
        old = older(new, [entry])
        if old == new:
            continue
        found += 1
        case = read_case(text_of(new))
        for one in (read_case(text_of(old)), pgimp.load(old), Case.model_validate(old)):
            assert one == case
            assert dump_case(one) == dump_case(case)
        changed = {key: value for key, value in old.items() if new.get(key) != value}
        assert pgimp.load(new, changed) == case
        assert renewed(old) == new
        assert renewed_text(text_of(old)) == text_of(new)
    assert found


@given(st.sampled_from(sorted(CASES)), st.sets(st.sampled_from(ENTRIES)))
def test_any_of_the_old_words_mix_with_new_ones(name, entries):
    new = parse(CASES[name], "case").data
    old = older(new, entries)
    before = deepcopy(old)
    assert renewed(old) == new and old == before
    assert renewed_text(text_of(old)) == text_of(new)
    assert renewed(new) == new and renewed_text(text_of(new)) == text_of(new)


def test_comments_and_lines_stay(tmp_path, capsys):
    file = tmp_path / "old.yaml"
    swaps = (("unilateral", "separating"), ("particles-per-cell", "particles_per_cell"),
             ("formulation: updated-lagrangian", "configuration:   'current'  # kept, too"),
             ("strength-reduction", "strength"), ("equilibrate", "settle"))  # fmt: skip
    text = SOIL.replace("       formulation", "       formulation").replace(
        "}\ngrav", "\n  }\ngrav"
    )
    old = text
    for new, word in swaps:
        old = old.replace(new, word)
    file.write_text(old)
    _write(str(file), pgimp.load(file))
    assert "has now new words" in capsys.readouterr().out
    wanted = text.replace("formulation: updated-lagrangian",
                          "formulation:   updated-lagrangian  # kept, too")  # fmt: skip
    assert file.read_text() == wanted
    _write(str(file), pgimp.load(file))
    assert "no word is old" in capsys.readouterr().out and file.read_text() == wanted


def refused(text, *overrides):
    with pytest.raises(CaseError) as caught:
        read_case(text, "case.yaml", overrides)
    return str(caught.value)


def test_errors_have_the_words_and_lines_that_are_written():
    text = SOLIDS.replace("formulation: total-lagrangian", "configuration: first", 1)
    mentions(refused(text), "case.yaml:9: bodies.a.configuration: ", "total-lagrangian")
    said = refused(SOLIDS, "bodies.a.configuration=first")
    mentions(said, "--set bodies.a.configuration=first: ", "total-lagrangian")
    text = text.replace("configuration: first", "configuration: initial")
    mentions(refused(text, "bodies.a.formulation=first"), "bodies.a.formulation: unknown value")
    assert "did you mean 'formulation'?" in refused(SOLIDS.replace("formulation:", "configuratin:"))


def test_both_words_for_one_key_are_refused_with_their_lines():
    text = SOIL.replace("start:", "outflow: {x-max: stop}\nescape: {y-max: stop}\nstart:")
    mentions(refused(text), "case.yaml:13: escape: ", "'outflow'", "in line 12")


def test_an_override_may_have_either_word():
    text = SOIL.replace("pic-damping: 1.0", "relaxation: 1.0")
    for key in ("relaxation", "pic-damping"):
        case = read_case(text, "case.yaml", [f"method.{key}=3.0"])
        assert case.method.relaxation == 3.0
    stage = "time.stages.0.strength.factor=1.3"
    assert read_case(SOIL, "case.yaml", [stage]).time.stages[0].strength.factor == 1.3


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("tool.punch.force-y", "rigid.punch.force-y"),
        ("tool.punch.inside", "rigid.punch.penetrating-particles"),
        ("tool.*", "rigid.*"),
        ("beyond.x-min", "overlap-mass.x-min"),
        ("escaped.mass", "outflow.mass"),
        ("volume.water.carried", "volume.water.particles"),
    ],
)
def test_an_old_name_of_a_column_is_the_new_one(tmp_path, old, new):
    assert new_column(old) == new == new_column(new)
    file = tmp_path / "history.csv"
    file.write_text(f"time,step,{old}\n0,0,1.5\n")
    table = history.read(file).view(Table)
    assert table.dtype.names == ("time", "step", new)
    np.testing.assert_array_equal(table[old], table[new])
    assert table[new] == [1.5]


def test_the_glossary_has_all_of_them():
    page = (Path(pgimp.__file__).parents[1] / "docs" / "glossary.md").read_text()
    rows = [row for row in page.split("## Older words")[1].splitlines() if row.startswith("|")]
    for _, old, new in (*KEYS, *VALUES):
        if old not in ("configuration", "initial", "current", "mean", "tied"):
            assert any(f"| `{old}` | `{new}` |" in row for row in rows), old
    for key, old, new in (("formulation", "initial", "total-lagrangian"), ("law", "tied", "tie"),
                          ("formulation", "current", "updated-lagrangian"),
                          ("volumetric", "mean", "b-bar")):  # fmt: skip
        assert any(f"{old}` | `{key}: {new}`" in row for row in rows), old
    names = [row.split("`")[1].replace("...", ".x") for row in rows if "columns" in row]
    assert len(names) == len(COLUMNS) == 5
    assert all(new_column(name) != name for name in names)


def test_other_names_stay():
    assert new_column("kinetic-energy") == "kinetic-energy" and new_column("tools") == "tools"
