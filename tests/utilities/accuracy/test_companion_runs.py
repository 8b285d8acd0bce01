"""Runs with companions: what is in their directories, how they stop and go on, what is told."""

import json
import re

import numpy as np
import pytest
from scenes import box, scene
from two_blocks import CASE

import pgimp
from pgimp.case.reader import read_case
from pgimp.cli import main
from pgimp.errors import CaseError, UsageError
from pgimp.mpi.comm import Serial
from pgimp.utilities.accuracy.companions import companions, levels_of, notes
from pgimp.utilities.accuracy.found import Companions

pytestmark = pytest.mark.slow(30)

#: Cells of half the size, so that companions have those of the case: six across a block.
FINE = {"grid.cell": [0.5, 0.5], "time.step": 0.005, "output.every": None, "time.end": 1.0}
PROBE = {"corner": {"body": "left", "at": [4.0, 4.0]}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("companions")
    (folder / "blocks.yaml").write_text(CASE)
    return folder


@pytest.fixture(scope="module")
def start(folder):
    """``start(name, changes, ..)`` runs the case on fine cells in a directory."""

    def start(name, changes=(), **options):
        changes = FINE | {"probes": PROBE} | dict(changes)
        options = {"quiet": True, "overrides": changes} | options
        return pgimp.run(folder / "blocks.yaml", Serial(), folder / name, **options)

    return start


@pytest.fixture(scope="module")
def done(start):
    return start("done", error=True)


def test_errors_are_differences_from_a_run_on_cells_twice_as_large(done, start, folder):
    """Whose history is that of the case with these cells, steps and lines."""
    alone = start("alone", {"grid.cell": [1.0, 1.0], "time.step": 0.01, "history.every.steps": 3})
    large = pgimp.open(done.path / "coarse" / "2h")
    assert large.case.grid.cell == (1.0, 1.0) and large.state == "done"
    for name in ("time", "kinetic-energy", "reaction.x-min-x"):
        np.testing.assert_array_equal(large.history[name], alone.history[name])
    history, errors = done.history, done.history.errors
    energy = np.interp(history["time"], large.history["time"], large.history["kinetic-energy"])
    difference = np.abs(history["kinetic-energy"] - energy)
    assert (errors["kinetic-energy"] >= difference * (1.0 - 1e-9)).all()
    assert errors["kinetic-energy"].max() == pytest.approx(difference.max())
    assert "step" not in errors and history[2:5].errors["mass"].shape == (3,)
    assert {"displacement-x", "velocity-y"} <= {*done.probes["corner"].errors}
    assert "volume" not in done.probes["corner"].errors
    text = (done.path / "errors.csv").read_text().splitlines()
    assert text[0] == "quantity,last,last-error,greatest,greatest-time,greatest-error,order"
    assert "probe.corner.displacement-x" in {line.split(",")[0] for line in text}


def test_the_run_itself_has_the_bits_of_one_without_companions(done, start):
    plain = start("plain")
    assert plain.history.errors == {}
    for name in plain.history.dtype.names:
        np.testing.assert_array_equal(plain.history[name], done.history[name])
    for name in plain.frame(-1).fields:
        np.testing.assert_array_equal(plain.frame(-1)[name], done.frame(-1)[name])


def test_what_was_stopped_in_a_companion_goes_on(start, done):
    """And companions that are done do not run again."""
    run = start("stopped", error=True, wall_time=1e-9)
    assert run.state == "stopped" and run.info["steps"] == 0
    assert "companion" in run.info["message"]
    assert pgimp.open(run.path / "coarse" / "2h").info["steps"] < 100
    run = start("stopped", resume=True)  # it knows that it has companions
    assert run.state == "done"
    assert (run.path / "errors.csv").read_bytes() == (done.path / "errors.csv").read_bytes()
    starts = json.loads((run.path / "coarse" / "2h" / "run.json").read_text())["starts"]
    assert [one["state"] for one in starts] == ["stopped", "done"]
    start("stopped", resume=True)
    assert len(json.loads((run.path / "coarse" / "2h" / "run.json").read_text())["starts"]) == 2


def test_a_run_that_is_done_gets_errors_afterwards_and_loses_them_with_its_files(start, done):
    start("later")
    run = start("later", resume=True, error=True)
    assert (run.path / "errors.csv").read_bytes() == (done.path / "errors.csv").read_bytes()
    assert len(run.starts) == 1
    (run.path / "coarse" / "notes.txt").write_text("mine")
    start("later", overwrite=True)
    assert not (run.path / "errors.csv").exists()
    assert [path.name for path in (run.path / "coarse").rglob("*")] == ["notes.txt"]
    start("later", overwrite=True, error=True)
    assert (run.path / "errors.csv").exists()


def test_a_function_of_steps_is_refused_with_companions(start):
    for changes in ({"error": True}, {}):
        asked = {} if changes else {"accuracy": {"of": "kinetic-energy", "within": 1.0}}
        with pytest.raises(ValueError, match="each: a companion run"):
            start("each", asked, each=lambda now: None, **changes)


def test_thin_bodies_are_told_and_few_cells_refused(folder, tmp_path):
    case = pgimp.load(folder / "blocks.yaml")
    assert levels_of(case) == [2.0]
    (text,) = notes(case, companions(case, [2.0], tmp_path))
    assert re.match(r"body 'left' is 1\.5 cells across on the companion's cells of 2", text)
    thick = pgimp.load(folder / "blocks.yaml", {"grid.cell": [0.25, 0.25], "time.step": 0.0025})
    assert levels_of(thick) == [2.0, 4.0] and not [
        *notes(thick, companions(thick, [2.0], tmp_path))
    ]
    assert [one.path.name for one in companions(thick, [2.0, 4.0], tmp_path)] == ["4h", "2h"]
    walls = {"x-min": "fixed", "x-max": "fixed"}
    one = scene(1, box([0.0], [1.0]), cells=[1], end=1.0, step=0.1, boundaries=walls)
    with pytest.raises(UsageError, match="too few for a companion run"):
        companions(pgimp.load(one), [2.0], tmp_path)


def test_the_entry_of_a_case():
    text = CASE + "probes: {tip: {body: left, at: [2.0, 2.0]}}\n"
    for entry, wrong in {
        "{of: kinetic-energy, within: 2 parts}": "accuracy.within: expected a part of the value",
        "{of: kinetic-energy, within: 0 %}": "accuracy.within: expected a part of the value",
        "{of: kinetic-energy, within: -1}": "accuracy.within",
        "{of: kinetic-energy, within: 2 %, at: 3.0}": "accuracy.at: 3 is after the end at 2",
        "{of: probe.tap.velocity-x, within: 2 %}": "accuracy.of: unknown probe 'tap'",
        "{of: kinetic-energy, within: 2 %, finest: 2.0}": "accuracy.finest",
    }.items():
        with pytest.raises(CaseError, match=re.escape(wrong)):
            read_case(f"{text}accuracy: {entry}\n")
    case = read_case(f"{text}accuracy: {{of: probe.tip.velocity-x, at: max, within: 2.5 %}}\n")
    entry = case.accuracy
    assert (entry.probe, entry.column, entry.label) == ("tip", "velocity-x", entry.of + "@max")
    assert entry.allowed(-4.0) == pytest.approx(0.1) and case.stages[0] is case


def test_cells_are_chosen_for_an_accuracy_and_a_run_goes_on_with_them(start, folder):
    entry = {"of": "strain-energy", "at": "max", "within": "20 %"}
    coarse = FINE | {"grid.cell": [1.0, 1.0], "time.step": 0.01, "accuracy": entry}
    run = start("asked", coarse)
    chosen = run.case.grid.cell[0]
    assert chosen <= 1.0 and (12.0 / chosen) % 1.0 < 1e-9
    assert all(ratio > 1.0 for ratio, _ in Companions(run.path).runs)
    log = (run.path / "log.txt").read_text()
    assert re.search(r"strain-energy@max is .* \+- .* on cells of .*20 %", log)
    assert re.search(r"the run itself, on cells of \S+: about \S+ s on 1 rank", log)
    assert re.search(r"(warning: )?strain-energy@max: \S+ \+- \S+ \(\S+ %\)", log)
    again = start("asked", coarse, resume=True)
    assert again.case.grid.cell == run.case.grid.cell and len(again.starts) == 1
    tight = entry | {"within": "0.01 %"}
    with pytest.raises(UsageError, match=r"needs cells of .*: .*\nThat is finer than"):
        start("tight", coarse | {"accuracy": tight})
    assert pgimp.open(folder / "tight" / "coarse" / "2h").state == "done"
    with pytest.raises(UsageError, match=r"accuracy\.of: unknown column 'heap'"):
        start("unknown", coarse | {"accuracy": entry | {"of": "heap"}})
    assert not (folder / "unknown" / "coarse").exists()


def test_the_command_on_three_ranks_stopped_by_a_forecast(done, folder, mpirun, python):
    """What it says, its statuses, and bits and errors as on one rank."""
    changes = [f"--set={key}={value}" for key, value in FINE.items() if value is not None]
    changes += ["--set=output.every=null", "--set=probes={corner: {body: left, at: [4.0, 4.0]}}"]
    words = ["-m", "pgimp", "blocks.yaml", "-o", "three", *changes]
    job = mpirun(3, [*words, "--forecast"], cwd=folder)
    assert job.returncode == 0, job.stdout + job.stderr
    assert "the run itself, on cells of 0.5: about" in job.stdout and "on 3 ranks" in job.stdout
    assert "--resume in place of --forecast" in job.stdout
    assert pgimp.open(folder / "three").info["forecast"]["cell"] == [0.5, 0.5]
    batch = [
        "batch",
        "blocks.yaml",
        "--ranks=6",
        "--wall-time=0:01:00",
        "-o",
        "three",
        "--script=-",
    ]
    told = python(["-m", "pgimp", *batch, "--script=-", "--error"], cwd=folder)
    assert "three has a forecast: cells of 0.5" in told.stderr and "1 job of" in told.stderr
    assert "--error" in told.stdout
    job = mpirun(3, [*words, "--resume"], cwd=folder)
    assert job.returncode == 0, job.stdout + job.stderr
    assert re.search(r"estimated errors, of the greatest values: kinetic-energy .* %", job.stdout)
    assert (folder / "three" / "errors.csv").read_bytes() == (done.path / "errors.csv").read_bytes()
    run = pgimp.open(folder / "three")
    np.testing.assert_array_equal(run.frame(-1)["position"], done.frame(-1)["position"])
    job = python([*words, "--resume", "--forecast"], cwd=folder)
    assert job.returncode == 2 and "it needs no --forecast" in job.stderr


def test_bands_and_a_section_show_the_errors(done, start, folder, capsys):
    table = folder / "bands.csv"
    words = ["plot", str(done.path), "--y", "kinetic-energy,mass", "--factor=2"]
    assert main([*words, "-o", str(folder / "bands.svg"), "--csv", str(table)]) == 0
    assert "bands are estimated errors" in capsys.readouterr().out
    head = table.read_text().splitlines()[0]
    assert head.endswith("error of 2 x kinetic-energy,error of 2 x mass")
    drawn = np.genfromtxt(table, delimiter=",", skip_header=1, usecols=(1, 2, 4))
    np.testing.assert_allclose(drawn[:, 2], 2.0 * done.history.errors["kinetic-energy"])
    for more in (["--over=mass"], ["--mean=3"], ["--x=kinetic-energy"]):
        assert main([*words, *more, "-o", str(folder / "none.csv")]) == 0
        assert "error of" not in (folder / "none.csv").read_text()
    assert main(["report", str(done.path)]) == 0
    page = (done.path / "report.html").read_text()
    assert "<h2>Estimated errors</h2>" in page and "probe.corner.displacement-x" in page
    plain = start("bare")
    assert main(["report", str(plain.path)]) == 0
    assert "Estimated errors" not in (plain.path / "report.html").read_text()


def test_a_check_tells_of_the_companions_and_of_a_wrong_column(folder, capsys):
    words = ["check", str(folder / "blocks.yaml"), "--set"]
    assert main([*words, "accuracy={of: strain-energy, within: 5 %}"]) == 0
    out = capsys.readouterr().out
    assert "accuracy: runs on cells of 2, 1 come first" in out
    assert "note: body 'left' is 1.5 cells across" in out
    assert main([*words, "accuracy={of: stain-energy, within: 5 %}"]) == 2
    assert "accuracy.of: unknown column 'stain-energy'; did you mean" in capsys.readouterr().err
    assert main([*words, "accuracy={of: time, within: 5 %}"]) == 2
    assert "accuracy.of: time has no error of its own" in capsys.readouterr().err
