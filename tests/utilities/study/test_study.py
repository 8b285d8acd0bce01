"""``pgimp study`` as its users see it: runs, reuse, failures, tables, picture, interruption."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from falling_study import END, GRAVITY, STUDY, put
from matplotlib.image import imread
from processes import clean_env

from pgimp.cli import main
from pgimp.utilities.study import runs
from pgimp.utilities.study.plan import read_plan
from pgimp.utilities.study.runs import perform

pytestmark = pytest.mark.slow(30)


def rows(folder):
    with open(folder / "study.csv", encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def beginnings(folder):
    """When each run wrote its run.json last."""
    return {path.parent.name: path.stat().st_mtime_ns for path in folder.glob("runs/*/run.json")}


@pytest.fixture
def alone(monkeypatch):
    """This process as no launcher started it, though an earlier test may have initialised MPI.

    Nor has it imported a material, which the commands of a study would repeat.
    """
    for name in set(os.environ) - set(clean_env()):
        monkeypatch.delenv(name)
    monkeypatch.setattr(runs, "imported", [])


@pytest.fixture(scope="module")
def first(tmp_path_factory, python):
    """A study that ran once, started from another folder, and what it said."""
    path = put(tmp_path_factory.mktemp("study"))
    done = python(["-m", "pgimp", "study", path], cwd=path.parent.parent)
    return path, path.parent / "results", done


def test_failed_runs_are_rows_and_the_others_count(first):
    _, folder, done = first
    assert done.returncode == 1, done.stderr
    assert "2 of 3 runs have a result" in done.stdout
    good, better, bad = rows(folder)
    assert [row["state"] for row in (good, better, bad)] == ["done", "done", "failed"]
    assert "Courant number" in bad["message"] and not bad["error"]
    # Velocities lead positions by half a step, and nothing else is wrong with a uniform fall.
    for row, step in ((good, 0.1), (better, 0.05)):
        assert float(row["error"]) == pytest.approx(0.5 * -GRAVITY * END * step, rel=1e-9)
        assert float(row["x: time.step"]) == step
        assert int(row["particles"]) == 4 and int(row["steps"]) == round(END / step)
        assert float(row["particle-steps"]) == 4 * round(END / step)
        info = json.loads((folder / "runs" / row["run"] / "run.json").read_text())["starts"][-1]
        assert float(row["wall"]) == float(row["core"]) == info["seconds"] > 0.0
        assert float(row["history: mass"]) == 2.0
        kinetic = float(row["history: kinetic-energy@max"])
        assert kinetic == pytest.approx((GRAVITY * END) ** 2, rel=1e-9)
    assert good["order"] == ""
    assert float(better["order"]) == pytest.approx(1.0, abs=1e-8)
    assert [row["front: particle-steps"] for row in (good, better, bad)] == ["1", "1", ""]


def test_page_and_picture(first):
    path, folder, _ = first
    page = (folder / "study.md").read_text(encoding="utf-8")
    assert page.startswith("# A falling bar\n")
    assert "| 0.05 | 0.05 | 1.00 | 4 | 20 | 80 |" in page
    assert "| 0.02 | failed |" in page
    for part in ("Courant number", "numba: ", "pgimp: ", "Hosts: ", "Ranks: 1 on ", "Written 20"):
        assert part in page
    assert (folder / "report.html").read_text().startswith("<!DOCTYPE html>\n<!-- A report of")
    height, width, _ = imread(folder / "study.png").shape
    assert width > 3 * height  # four panels
    assert (folder / "study.yaml").read_text() == path.read_text()
    assert not list(folder.glob(".*.part"))


def test_finished_runs_are_reused_with_their_cost(first, python):
    path, folder, _ = first
    before, table = beginnings(folder), rows(folder)
    put(path.parent, STUDY.replace(", 0.02]", "]").replace(", 1.0e+6]", "]"))
    done = python(["-m", "pgimp", "study", path, "--quiet"])
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert beginnings(folder) == before
    for old, new in zip(table[:2], rows(folder), strict=True):
        assert (old["reused"], new["reused"]) == ("0", "1")
        assert all(old[key] == new[key] for key in old if key != "reused")


def test_what_is_not_the_same_run_is_run_again(first, tmp_path):
    _, folder, _ = first

    def reused(text, change=lambda output: None):
        (run, *_) = (plan := read_plan(put(tmp_path, text))).runs
        output = tmp_path / "run"
        shutil.rmtree(output, ignore_errors=True)
        shutil.copytree(folder / "runs" / run.name, output)
        change(output)
        # A run that is not reused is started, here with what ends at once.
        outcome = perform(plan.study.model_copy(update={"launcher": ("false",)}), run, output)
        assert outcome.reused == (outcome.state == "done")
        return outcome.reused

    def info(**changes):
        def change(output):
            content = json.loads((output / "run.json").read_text())
            content["starts"][-1] |= changes
            (output / "run.json").write_text(json.dumps(content))

        return change

    assert reused(STUDY)
    assert reused(STUDY.replace("title: A falling bar", "title: Another"))
    assert not reused(STUDY + "set: {bodies.bar.velocity: [1.0e-9]}\n")
    assert not reused(STUDY + "ranks: 2\n")
    assert not reused(STUDY, info(state="stopped"))
    assert not reused(STUDY, info(versions={"pgimp": "0.0.9"}))
    assert not reused(STUDY, info(seconds=None))
    assert not reused(STUDY, lambda output: (output / "run.json").unlink())
    assert not reused(STUDY, lambda output: (output / "run.json").write_text("{"))


def test_ranks_and_again(first, python, tmp_path):
    """Two ranks, started by the study's own launcher, give the error of one."""
    launcher = "[mpirun, -q, --oversubscribe, --bind-to, none, -n, '{ranks}']"
    text = STUDY.replace("0.1, 0.05, 0.02]", "0.1]").replace("1.0, 1.0, 1.0e+6]", "1.0]")
    path = put(tmp_path, f"{text}ranks: 2\nlauncher: {launcher}\n")
    done = python(["-m", "pgimp", "study", path, "-o", tmp_path / "out"])
    assert done.returncode == 0, done.stdout
    (row,) = rows(tmp_path / "out")
    assert row["ranks"] == "2"
    assert float(row["core"]) == 2.0 * float(row["wall"])
    assert float(row["error"]) == pytest.approx(0.5 * -GRAVITY * END * 0.1, rel=1e-9)
    assert not (tmp_path / "results").exists()
    path.write_text(f"{text}launcher: [sh, -c, 'echo pgimp: no; exit 3']\n")
    assert python(["-m", "pgimp", "study", path, "-o", first[1], "--again"]).returncode == 1
    assert rows(first[1])[0]["message"] == "no"


def test_list_runs_nothing(first, alone, tmp_path, capsys):
    text = STUDY.replace(", 0.02]", "]").replace(", 1.0e+6]", "]")
    assert main(["study", str(put(tmp_path, text)), "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    assert "--set time.step=0.05 --set materials.bar.young=1.0 -o " in lines[1]
    assert not (tmp_path / "results").exists()


def test_list_refuses_what_check_refuses(alone, tmp_path, capsys):
    """The last of three steps is beyond the limit: it shows with the particles only."""
    assert main(["study", str(put(tmp_path)), "--list"]) == 2
    said = capsys.readouterr()
    assert not said.out and "time.step: 0.02 is a Courant number of" in said.err
    assert "stability limit" in said.err and len(said.err.splitlines()) == 1


def test_list_finds_an_error_that_no_run_has(alone, tmp_path, capsys):
    path = put(tmp_path, STUDY.replace("body.bar.centre-x, ref", "body.bar.center-x, ref"))
    for more in (["--list"], []):
        assert main(["study", str(path), *more]) == 2
        said = capsys.readouterr().err
        assert "fall.yaml:7: error.column: unknown column 'body.bar.center-x'; did you mean" in said
    assert not (tmp_path / "results").exists()


def test_timeout(python, tmp_path):
    path = put(tmp_path, STUDY + "launcher: [sh, -c, sleep 60]\ntimeout: 0.2\n")
    done = python(["-m", "pgimp", "study", path])
    assert done.returncode == 1
    assert "0 of 3 runs" in done.stdout
    assert all("0.2 s, the study's timeout" in row["message"] for row in rows(tmp_path / "results"))
    assert not (tmp_path / "results" / "study.png").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interruption_ends_the_run_and_leaves_tables(tmp_path, number):
    launcher = f"launcher: [sh, -c, 'echo $$ > {tmp_path}/pid; exec sleep 60']\n"
    path = put(tmp_path, STUDY + launcher)
    words = [sys.executable, "-m", "pgimp", "study", str(path)]
    process = subprocess.Popen(words, env=clean_env(), stderr=subprocess.PIPE, text=True)
    pid = Path(tmp_path / "pid")
    until = time.monotonic() + 30.0
    while not (pid.exists() and pid.read_text().strip()):
        assert time.monotonic() < until and process.poll() is None
        time.sleep(0.02)
    if number == signal.SIGINT:
        second = subprocess.run(words, env=clean_env(), capture_output=True, text=True)
        assert second.returncode == 2
        assert "a study is writing to" in second.stderr
    process.send_signal(number)
    assert process.wait(30) == 130
    assert process.stderr.read() == "pgimp: interrupted\n"
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)
    assert {row["state"] for row in rows(tmp_path / "results")} == {"not run"}
    assert "0.1 | not run" in (tmp_path / "results" / "study.md").read_text()


class Awaited(subprocess.Popen):
    """A process that notes how long it is waited for."""

    def wait(self, timeout=None):
        self.waits = [*getattr(self, "waits", ()), timeout]
        return super().wait(timeout)


def test_a_run_in_a_job_scripts_background_ends_without_waiting_for_ctrl_c():
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        process = Awaited(["sleep", "60"], start_new_session=True)
        runs._end(process)
    finally:
        signal.signal(signal.SIGINT, usual)
    assert process.waits == [dict(runs._PATIENCE)[signal.SIGTERM]]
    assert process.returncode == -signal.SIGTERM


def test_a_launcher_around_the_study_is_refused(alone, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "1")
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "0")
    assert main(["study", str(put(tmp_path))]) == 2
    assert "without a launcher" in capsys.readouterr().err


def test_a_run_is_no_folder_for_a_study(first, alone, tmp_path, capsys):
    _, folder, _ = first
    run = next(folder.glob("runs/*"))
    assert main(["study", str(put(tmp_path)), "-o", str(run)]) == 2
    assert "is the directory of a run" in capsys.readouterr().err
