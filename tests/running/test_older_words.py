"""A run directory with older words: it goes on, and plots and comparisons read it."""

import numpy as np
import pytest
from resumed import EVERY, check_same

import pgimp
from pgimp.cli import main

pytestmark = pytest.mark.slow(20)

OLD = {
    "case.yaml": {"particles-per-cell": "particles_per_cell", "pic-damping": "relaxation",
                  "formulation: updated-lagrangian": "configuration: current",
                  "outflow": "escape", "wall-time": "wall", "body-force": "body_force",
                  "equilibrate": "settle"},
    "history.csv": {"overlap-mass.": "beyond."},
}  # fmt: skip


def age(path):
    """Put the older words into the files of a run."""
    for name, words in OLD.items():
        text = before = (path / name).read_text()
        for new, old in words.items():
            text = text.replace(new, old)
        assert text != before
        (path / name).write_text(text)


def test_an_older_run_goes_on_to_the_same_end(run, whole):
    age(run.output)
    resumed = run()
    assert resumed.info["resumed_from"] == 160
    check_same(whole, resumed)


def test_an_older_run_is_read(run, whole, capsys):
    age(run.output)
    old, new = pgimp.open(run.output), pgimp.open(whole.path)
    assert old.case == new.case
    assert old.history.dtype.names == new.history.dtype.names
    for name in ("beyond.x-min", "overlap-mass.x-min"):
        np.testing.assert_array_equal(old.history[name], new.history[name])
    figure = run.output / "curve.csv"
    columns = ["--columns", "beyond.*", "-o", str(figure)]
    assert main(["plot", str(run.output), str(whole.path), *columns]) == 0
    assert "run,time,overlap-mass.x-min," in figure.read_text()
    assert main(["compare", str(run.output), str(whole.path)]) == 0
    assert main(["report", str(run.output), "-o", str(run.output / "report.html")]) == 0
    page = (run.output / "report.html").read_text()
    assert "updated-lagrangian" in page and "beyond." not in page


def test_a_running_case_of_older_words_is_the_same_case(run, folder, whole):
    """What is compared at a resume are meanings, not words."""
    file = folder / "older.yaml"
    file.write_text(
        (folder / "blocks.yaml").read_text().replace("particles-per-cell", "particles_per_cell")
    )
    resumed = pgimp.run(file, output=run.output, overrides=[EVERY], quiet=True, resume=True)
    check_same(whole, resumed)
