"""What pages print is what the repository has."""

import ast
import inspect
import re
import sys

import pytest
from pages import PAGES, ROOT, TEXT, block_of
from processes import run

from pgimp.case.reader import read_case
from pgimp.jit import algebra
from pgimp.utilities.study.plan import read_plan


def test_first_case_is_printed_as_it_is():
    printed = read_case(block_of("format: 2\ntitle"), "docs/case-file.md", [])
    there = (ROOT / "cases/block3d.yaml").read_text(encoding="utf-8")
    assert printed == read_case(there, "block3d.yaml", [])


@pytest.mark.parametrize(("dimensions", "case"), [(3, "block3d"), (2, "rolling")])
def test_short_cases_of_the_pages_are_those_in_cases(dimensions, case):
    """They are complete, and but for labels and output they say the same."""
    short = read_case(block_of(f"format: 2\ndimensions: {dimensions}"), "README.md", [])
    there = (ROOT / f"cases/{case}.yaml").read_text(encoding="utf-8")
    whole = read_case(there, f"{case}.yaml", [])
    for name in type(whole).model_fields:
        if name not in ("title", "units", "output", "history"):
            assert getattr(short, name) == getattr(whole, name), name


def rows(table, first):
    """Cells of a table of Markdown by the first cell of the line and the title of the column."""
    lines = table[table.index(first) :].partition("\n\n")[0].splitlines()
    (titles, _, *rest) = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {row[0]: dict(zip(titles, row, strict=True)) for row in rest}


def test_table_of_the_readme_is_that_of_the_methods():
    """Its figures are those of two tables of the page, and so is the date of the first."""
    page = PAGES["docs/methods.md"]
    short = rows(PAGES["README.md"], "| problem | error of")
    whole, steps = rows(page, "| problem | error of"), rows(page, "| method | bending")
    assert len(short) == 10
    for words, row in short.items():
        name = words.partition(" (")[0]
        if name in whole:
            found = (whole[name][title] for title in list(whole[name])[2:4])
            expected = [cell.partition(",")[0] for cell in found]
        else:
            expected = [steps[f"{each}, 2 a cell"][name] for each in ("gimp, initial", "gimp")]
        assert list(row.values())[2:] == expected, name
    origin, *_ = re.findall(r"^Measured .* on (AMD EPYC .*?)\.$", page, re.M)
    assert origin in PAGES["README.md"]
    peers = rows(PAGES["docs/performance.md"], "|  | pgimp | pgimp, lattice")
    one, two = (peers[f"3D, {cores}"]["pgimp"].split()[0] for cores in ("1 core", "2 cores"))
    said = " ".join(PAGES["README.md"].split())
    assert f"advances {one} million" in said and f"two cores {two}" in said


def test_pages_of_measurements_are_what_their_texts_and_tables_give():
    words = [sys.executable, str(ROOT / "scripts" / "pages"), "--check"]
    done = run(words)
    assert done.returncode == 0, done.stderr


def test_the_study_is_one(tmp_path):
    """It is a part of the study in cases/studies."""
    text = block_of("format: 1\ncase: ")
    path = tmp_path / "printed.yaml"
    path.write_text(text.replace("../compaction.yaml", str(ROOT / "cases/compaction.yaml")))
    there = read_plan(ROOT / "cases/studies/compaction.yaml").runs
    assert {run.name for run in read_plan(path).runs} < {run.name for run in there}


def test_material_of_ones_own_is_printed_as_it_is():
    """But for its docstrings, `cases/fluid.py`."""

    def code(text):
        tree = ast.parse(text)
        for node in ast.walk(tree):
            body = getattr(node, "body", None)
            if isinstance(body, list) and ast.get_docstring(node) is not None:
                del body[0]
            if isinstance(node, ast.FunctionDef):
                node.returns = None
        return ast.unparse(tree)

    text = (ROOT / "cases/fluid.py").read_text(encoding="utf-8")
    assert code(block_of("from math import log, sqrt\nfrom typing")) == code(text)


def test_the_stress_that_remembers_is_printed_as_it_is():
    """But for its docstring, that of `cases/softening.py`."""
    text = (ROOT / "cases/softening.py").read_text(encoding="utf-8")
    found = [node for node in ast.walk(ast.parse(text)) if getattr(node, "name", "") == "stress"]
    (stress,) = found
    stress.decorator_list = []
    del stress.body[0]
    printed = block_of("from math import log\n\nfrom pgimp.jit.algebra import isotropic, left")
    assert ast.unparse(stress) in ast.unparse(ast.parse(printed))


def test_all_operations_on_tensors_are_listed():
    """Each function of `pgimp.jit.algebra` with its arguments, and no other."""
    table = TEXT.partition("| operation | result |\n|---|---|\n")[2].partition("\n\n")[0]
    listed = re.findall(r"^\| `(.*?)`", table, re.MULTILINE)
    there = [
        f"{name}{inspect.signature(function)}"
        for name, function in vars(algebra).items()
        if inspect.isfunction(function) and function.__module__ == algebra.__name__
        if not name.startswith("_")
    ]
    assert listed == there
