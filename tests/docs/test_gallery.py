"""The gallery: cases have all that it shows; notebooks run; dead links are found."""

import json
import sys

import pytest
from gallery.facts import cases, studies
from gallery.links import dead
from gallery.notebook import notebook, programs
from gallery.pages import case_page
from gallery.trades import TRADES
from processes import run

from pgimp.commands.init import packaged

ALL = {case.name: case for case in cases()}


def test_every_case_has_one_trade():
    names = [name for trade in TRADES.values() for name in trade]
    assert sorted(names) == sorted(ALL)


def test_cases_and_studies_are_those_of_init():
    assert {*ALL, *(study.name for study in studies())} == set(packaged())


@pytest.mark.parametrize("case", ALL.values(), ids=lambda case: case.name)
def test_a_case_has_what_its_card_shows(case):
    """In its header, in the row and the section of cases/README.md, and among the pictures."""
    assert {"Physics", "Exact", "Expect", "Size", "Command"} <= set(case.parts)
    assert case.title and "(or" not in case.command and case.path in case.command
    assert case.verifies, "its row in cases/README.md has nothing after the dimensions"
    assert case.shows and case.remarks, "its picture is not shown, or without a remark"
    assert 10_000 < case.picture.stat().st_size < 150_000


def test_a_page_has_the_whole_case():
    case = ALL["hard/shock"]
    page = case_page(case)
    assert f'```yaml title="cases/hard/shock.yaml"\n{case.text}```' in page
    assert "# hard/shock" in page and "(hard/shock.yaml)" in page
    assert "mpm is all noise" in page


@pytest.mark.parametrize("case", ALL.values(), ids=lambda case: case.name)
def test_a_notebook_changes_values_of_its_case(case):
    written = json.loads(notebook(case))
    assert written["nbformat"] == 4
    code = [cell["source"] for cell in written["cells"] if cell["cell_type"] == "code"]
    assert ["".join(lines) for lines in code] == [text.strip() for text in programs(case)]
    compile("\n".join(programs(case)), case.name, "exec")
    assert '"grid.cell"' in programs(case)[2] and '"time.end"' in programs(case)[2]


@pytest.mark.parametrize(("name", "part"), [("shock", 1), ("fluid/dam-break", 100)])
def test_a_notebook_runs(name, part, tmp_path):
    """As one program: in one dimension; and shorter, with a material from outside."""
    program = "\n".join(programs(ALL[name]))
    end = ALL[name].contents["time"]["end"]
    assert f'"time.end": {end},' in program
    shorter = program.replace(f'"time.end": {end},', f'"time.end": {end / part},')
    path = tmp_path / "notebook.py"
    path.write_text(f"import matplotlib\nmatplotlib.use('Agg')\n{shorter}", encoding="utf-8")
    done = run([sys.executable, str(path)], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "columns: " in done.stdout


def test_links_that_lead_nowhere_are_found(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "other.html").write_text('<h2 id="place">x</h2><a href="../one.html">')
    (tmp_path / "picture.png").write_text("")
    (tmp_path / "one.html").write_text(
        '<a href="there/other.html#place"><img src="picture.png"><a href="https://example.org">'
        '<a href="#nowhere"><a href="there/other.html#lost"><a href="gone.html">'
        '<img src="lost.png"><script src="https://example.org/x.js"></script><a href="mailto:a@b">'
    )
    found = {line.partition(": ")[2] for line in dead(tmp_path)}
    expected = {"#nowhere", "there/other.html#lost", "gone.html", "lost.png"}
    assert found == expected | {"https://example.org/x.js"}
