"""A second refinement where a run's own error is more than asked for: cells, kills, its limits."""

import re

import numpy as np
import pytest
from two_blocks import CASE

import pgimp
from pgimp.errors import RunError
from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import RUN
from pgimp.io.rundir.runinfo import describe_start
from pgimp.mpi.comm import Serial
from pgimp.utilities.accuracy import accompany, again, quantity
from pgimp.utilities.accuracy.forecast import foretold

pytestmark = pytest.mark.slow(20)

WITHIN = {"of": "kinetic-energy", "at": "max", "within": "1 %", "finest": 0.1}
CHANGES = {"time.step": 0.01, "output.every": None, "time.end": 1.0, "accuracy": WITHIN}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("again")
    (folder / "blocks.yaml").write_text(CASE)
    return folder


@pytest.fixture
def start(folder, monkeypatch):
    """``start(name, ..)`` runs the case, whose first cells are chosen for 2.5 times the error."""
    monkeypatch.setattr(quantity, "MARGIN", 2.5)

    def start(name, changes=(), **options):
        options = {"quiet": True, "overrides": CHANGES | dict(changes)} | options
        return pgimp.run(folder / "blocks.yaml", Serial(), folder / name, **options)

    return start


def cells(path):
    return pgimp.open(path).case.grid.cell[0]


def test_a_run_with_too_great_an_error_runs_once_more(start):
    """On smaller cells, of which it has said the most; its tables stay as a companion's."""
    run = start("once")
    (first,) = (run.path / "coarse").glob("first-*h")
    assert 0.5 <= cells(run.path) / cells(first) <= 2.0 / 3.0 + 1e-9
    assert {file.name for file in first.iterdir()} == {
        "case.yaml", "history.csv", "run.json", "probes"
    }  # fmt: skip
    log = (run.path / "log.txt").read_text()
    assert re.search(r"once more, on cells of \S+: it needs cells of \S+, .*: about", log)
    assert re.search(r"kinetic-energy@max: \S+ \+- \S+ \(\S+ %\)", log)
    more = start("once", resume=True)
    assert len(more.starts) == 1 and cells(more.path) == cells(run.path)


@pytest.mark.parametrize("when", ["before", "after"])
def test_a_run_killed_between_the_two_goes_on(start, folder, monkeypatch, when):
    """Whether the tables of the first one have been kept by then or not."""

    def killed(path, factor):
        if when == "after":
            again.keep_first(path, factor)
        raise RunError("killed")

    monkeypatch.setattr(accompany, "keep_first", killed)
    with pytest.raises(RunError, match="killed"):
        start(when)
    begun = cells(folder / when)
    monkeypatch.undo()
    monkeypatch.setattr(quantity, "MARGIN", 2.5)
    run, whole = start(when, resume=True), start(f"whole-{when}")
    assert run.state == "done" and cells(run.path) < begun
    for name in whole.history.dtype.names:
        np.testing.assert_array_equal(run.history[name], whole.history[name])
    assert (run.path / "errors.csv").read_bytes() == (whole.path / "errors.csv").read_bytes()


def test_its_cells_have_a_limit(start, folder):
    """Where more is needed the run says so, and stays."""
    run = start("tight", {"accuracy": WITHIN | {"finest": 0.7}})
    log = (run.path / "log.txt").read_text()
    assert re.search(r"warning: kinetic-energy@max: .*, more than the 1 % asked for", log)
    assert re.search(r"there is no second refinement: it needs cells of .*, which is finer", log)


def test_a_job_is_told_what_it_may_cost(tmp_path):
    known = {"seconds": 50.0, "most": 400.0, "ranks": 1, "cell": [0.5, 0.5]}
    start = describe_start(Serial(), 0) | {"state": "stopped", "steps": 0, "forecast": known}
    runinfo.write(tmp_path / RUN, start)
    first, second = foretold(tmp_path, 2, 60.0)
    assert "25 s on 2 ranks" in first and "1 job of" in first
    assert "it runs once more, for 3:20 min at most: 4 jobs of" in second
