"""The benchmarks' scripts: tables are whole, speed and error together; no speed is judged."""

import csv
import importlib
import json
import sys
from pathlib import Path

import pytest
from processes import PROGRAMS

from pgimp.case.reader import read_case

pytestmark = pytest.mark.slow(30)

BENCHMARKS = Path(__file__).resolve().parents[2] / "scripts/benchmarks"
sys.path.insert(0, str(BENCHMARKS))

PARTS = {"kernels": 4, "domain": 2, "features": 3}


@pytest.fixture(scope="module")
def folder(tmp_path_factory, python):
    """What the quick parts write that need neither Taichi nor a compiler for long."""
    folder = tmp_path_factory.mktemp("benchmark")
    done = python([BENCHMARKS, *PARTS, "--quick", "-o", folder])
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize("part", PARTS)
def test_tables_have_speed_and_error(folder, part):
    with (folder / f"{part}.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == PARTS[part]
    for row in rows:
        assert float(row["speed"]) > 0.0
        assert float(row["velocity"]) < 1e-9
        assert float(row["stress"]) < 1e-9
    lines = (folder / f"{part}.md").read_text().splitlines()
    table = [line for line in lines if line.startswith("|")]
    assert len(table) == len(rows) + 2
    assert {line.count("|") for line in table} == {table[0].count("|")}
    assert "error of velocity" in table[0]
    assert "numba" in lines[-1]
    assert "cores" in lines[-1]


def test_all_tables_are_put_together(folder):
    whole = (folder / "benchmark.md").read_text()
    assert all((folder / f"{part}.md").read_text() in whole for part in PARTS)
    assert "| gimp | " in (folder / "page.md").read_text()
    assert (folder / "kernels.png").stat().st_size > 1000


def test_compiling_is_measured_by_turns(tmp_path, monkeypatch):
    """Two checkouts in each round, with folders of kernels of their own; all cases are valid."""
    compile = importlib.import_module("compile")
    calls = []

    def measure(root, folder, changes):
        calls.append((root.name, folder, tuple(changes)))
        return (3.0, 200.0) if root.name == "other" else (len(changes) + 1.0, 100.0)

    monkeypatch.setattr(compile, "measure", measure)
    monkeypatch.setattr(compile, "run", lambda *_: None)
    compile.main(tmp_path, False, tmp_path / "other")
    for changes in compile.ROWS.values():
        read_case(compile.CASE, "case.yaml", changes)
    assert [changes for name, _, changes in calls if name == "other"] == [
        tuple(changes) for _ in range(3) for changes in compile.ROWS.values()
    ]
    assert {name for name, *_ in calls[::2]} == {compile.ROOT.name}
    assert len({folder for _, folder, _ in calls}) == 2 * 3
    with (tmp_path / "compile.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["scene"] for row in rows] == list(compile.ROWS)
    assert {(row["seconds 1"], row["memory 1"]) for row in rows} == {("3.0", "200.0")}
    assert [float(row["seconds 0"]) for row in rows] == [1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0]


def test_unknown_part_is_named(python):
    done = python([BENCHMARKS, "kernel"])
    assert done.returncode == 2
    assert "there is no part kernel" in done.stderr


def test_taichi_is_imported_only_where_it_runs(python):
    words = "import sys; sys.modules['taichi'] = None; import workers.taichi_worker, peers"
    done = python(["-c", words], env={"PYTHONPATH": str(BENCHMARKS)})
    assert done.returncode == 0, done.stderr


def test_messages_are_counted_exactly(tmp_path, mpirun):
    from workers.messages import counting

    env = counting(tmp_path) | {"PYTHONPATH": str(BENCHMARKS)}
    done = mpirun(2, [PROGRAMS / "message_probe.py"], env=env)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [[8, 5 * 800 + 3 * 1600, 7, 7 * 24]] * 2
