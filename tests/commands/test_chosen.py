"""Runs of a case that names no method: the same on ranks and resumed, said and written down."""

import pytest
from run_files import digests

import pgimp
from pgimp.cli import main

pytestmark = pytest.mark.slow(30)

CASE = """\
format: 2
dimensions: 2
grid: {size: [8.0, 6.0], cell: [0.5, 0.5]}
time: {end: 1.0}    # not long
materials:
  soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}
bodies:
  block: {material: soft, region: {box: {min: [1.0, 1.2], max: [5.0, 4.0]}}}
gravity: [0.0, -1.0]
boundaries: {y-min: unilateral}
output: {every: 0.5, fields: [stress]}
checkpoint: {every: 0.5}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chosen")
    (folder / "case.yaml").write_text(CASE)
    return folder


@pytest.fixture(scope="module")
def alone(folder):
    assert main([f"{folder / 'case.yaml'}", "-o", f"{folder / 'one'}", "--quiet"]) == 0
    return pgimp.open(folder / "one")


def test_ranks_choose_the_same_and_have_the_same_bits(folder, alone, mpirun):
    done = mpirun(3, ["-m", "pgimp", folder / "case.yaml", "-o", folder / "three", "--quiet"])
    assert done.returncode == 0, done.stderr
    assert digests(folder / "three") == digests(alone.path)
    texts = [(path / "case.yaml").read_text() for path in (alone.path, folder / "three")]
    assert texts[0] == texts[1] and texts[0].startswith("# chosen: block: formulation")


def test_log_report_and_checkpoint_say_what_was_chosen(folder, alone, capsys):
    line = "block: formulation total-lagrangian - elastic"
    assert f"chosen: {line}" in (alone.path / "log.txt").read_text()
    assert main(["report", str(alone.path), "-o", str(folder / "report.html")]) == 0
    assert line in (folder / "report.html").read_text()
    capsys.readouterr()
    assert main(["check", str(folder / "case.yaml")]) == 0
    assert f"chosen           {line}" in capsys.readouterr().out


def test_a_longer_run_goes_on_as_it_began(folder, alone, capsys):
    words = [str(folder / "case.yaml"), "-o", str(alone.path), "--resume"]
    assert main([*words, "--set", "time.end=1.5"]) == 0
    assert "chosen: block: formulation total-lagrangian" in capsys.readouterr().out


def test_check_writes_the_choices_into_the_case(folder, capsys):
    path = folder / "written.yaml"
    path.write_text(CASE)
    assert main(["check", str(path), "--set", "time.end=2.0", "--write"]) == 2
    assert path.read_text() == CASE
    assert main(["check", str(path), "--write"]) == 0
    text = path.read_text()
    assert "# not long" in text and "step: {courant: auto}" in text
    assert "block: {formulation: total-lagrangian, " in text
    assert pgimp.load(path).model_dump() == pgimp.load(folder / "case.yaml").model_dump()
    capsys.readouterr()
    assert main(["check", str(path), "--write"]) == 0
    assert "nothing was chosen" in capsys.readouterr().out
