"""Files of probes: which are kept, which are cleared, and what is in their way."""

import shutil
from pathlib import Path

import pytest
from probed import run
from run_files import go_back
from scenes import box, scene

from pgimp.errors import RunError, UsageError
from pgimp.mpi.comm import Serial
from pgimp.storage.lines import LineFile


def test_a_resumed_run_may_have_other_probes_as_far_as_they_are_known(tmp_path):
    case = scene(1, box([1.0], [5.0], [1.0]), end=0.4, history={"every": {"steps": 10}})
    probes = {"a": {"body": "body", "at": [2.0]}, "b": {"place": [3.0]}}
    stop = {"checkpoint": {"every": {"steps": 10}, "keep": 9}}
    before = run(tmp_path, case | {"probes": probes} | stop)
    whole = {path.name: path.read_text() for path in (before.path / "probes").iterdir()}
    go_back(before.path, 0.5)

    def again(probes):
        copy = tmp_path / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(tmp_path / "out", copy / "out")
        return run(copy, case | {"probes": probes} | stop, resume=True)

    with pytest.raises(UsageError, match=r"probes\.c: the run began without it"):
        again(probes | {"c": {"body": "body", "at": [2.0]}})
    for other in ({"place": [2.0]}, {"body": "body", "at": [2.1]}):
        with pytest.raises(UsageError, match=r"probes\.a: .* another probe of this name"):
            again({"a": other})
    result = again(probes | {"c": {"place": [4.0]}})
    assert result.info["resumed_from"] == 20
    assert result.probes["c"]["step"].tolist() == [30, 40]
    for name, text in whole.items():
        assert (result.path / "probes" / name).read_text() == text


def test_overwriting_takes_the_files_of_the_probes_and_no_others(tmp_path):
    case = scene(1, box([1.0], [5.0]), end=0.1)
    result = run(tmp_path, case | {"probes": {"a": {"place": [3.0]}, "b": {"place": [4.0]}}})
    (result.path / "probes" / "mine.csv").write_text("time\n")
    run(tmp_path, case | {"probes": {"b": {"place": [2.0]}}}, overwrite=True)
    assert sorted(path.name for path in (result.path / "probes").iterdir()) == ["b.csv", "mine.csv"]
    assert list(result.probes) == ["b"]


def test_a_run_without_probes_has_no_folder(tmp_path):
    result = run(tmp_path, scene(1, box([1.0], [5.0]), end=0.1))
    assert not (result.path / "probes").exists() and result.probes == {}


def test_lines_of_a_probe_that_comes_back_stay(tmp_path):
    """A resume that has a place again, of which it has no record, keeps what was seen before."""
    path = tmp_path / "gauge.csv"
    path.write_bytes(b"time,step,density\n0,0,1\n0.1,10,2\n0.2,20,3\n0.3,3")
    file = LineFile(path)
    file.resume(Serial(), 15)
    file.append({"time": 0.16, "step": 16, "density": 4.0})
    file.sync()
    file.close()
    lines = path.read_text().split()
    assert lines[:-1] == ["time,step,density", "0,0,1", "0.1,10,2"]
    assert [float(x) for x in lines[-1].split(",")] == [0.16, 16, 4]


@pytest.mark.parametrize("left", [b"", b"time,st", b"time,step\n0.1,10\n"])
def test_a_file_before_its_first_line_never_stops_a_resume(tmp_path, left):
    path = tmp_path / "late.csv"
    path.write_bytes(left)
    file = LineFile(path)
    file.resume(Serial(), -1)
    assert file.step == -1 and path.read_bytes() == b""


def test_overwriting_takes_the_files_of_probes_that_a_resume_has_dropped(tmp_path):
    case = scene(1, box([1.0], [5.0]), end=0.4, history={"every": {"steps": 10}})
    case |= {"checkpoint": {"every": {"steps": 10}, "keep": 9}}
    probes = {"a": {"place": [3.0]}, "b": {"place": [4.0]}, "c": {"place": [5.0]}}
    result = run(tmp_path, case | {"probes": probes})
    for _ in range(2):  # the second resume knows of c from what the first has kept
        go_back(result.path, 0.5)
        del probes[max(probes)]
        assert list(run(tmp_path, case | {"probes": probes}, resume=True).probes) == list(probes)
    assert result.info["probes"] == ["a", "b", "c"]
    (result.path / "probes" / "mine.csv").write_text("time\n")
    run(tmp_path, case, overwrite=True)
    assert [path.name for path in (result.path / "probes").iterdir()] == ["mine.csv"]
    assert result.info["probes"] == []


def test_a_start_that_was_killed_knows_the_probes_of_the_run_before(tmp_path, monkeypatch):
    """run.json says that a run starts before the old one's files go; it keeps their names."""

    def killed(path, **_):
        raise OSError("killed")

    case = scene(1, box([1.0], [5.0]), end=0.1)
    result = run(tmp_path, case | {"probes": {"a": {"place": [3.0]}}})
    (result.path / "case.yaml").unlink()  # nothing but run.json knows of the probe
    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", killed)
        with pytest.raises(RunError, match="killed"):
            run(tmp_path, case, overwrite=True)
    assert result.state == "starting" and (result.path / "probes" / "a.csv").exists()
    run(tmp_path, case, overwrite=True)
    assert not (result.path / "probes" / "a.csv").exists()


@pytest.mark.parametrize("way", ["overwrite", "resume"])
def test_what_is_in_the_way_of_a_probe_is_found_before_anything_is_deleted(tmp_path, way):
    case = scene(1, box([1.0], [5.0]), end=0.2)
    result = run(tmp_path, case)
    folder = result.path / "probes"
    folder.write_text("mine")
    before = contents(result.path)
    for probes in ({"a": {"place": [3.0]}}, {}):
        if probes:
            with pytest.raises(UsageError, match=r"probes is in the way (.|\n)*move it away"):
                run(tmp_path, case | {"probes": probes}, **{way: True})
            assert contents(result.path) == before
        else:  # nothing is to be written there
            run(tmp_path, case | {"probes": probes}, **{way: True})
            assert folder.read_text() == "mine"
    folder.unlink()
    folder.mkdir()
    (folder / "a.csv").write_text("mine")
    with pytest.raises(UsageError, match=r"a\.csv is in the way .* no earlier start has written"):
        run(tmp_path, case | {"probes": {"a": {"place": [3.0]}}}, **{way: True})
    assert (folder / "a.csv").read_text() == "mine"


def contents(directory):
    return {path: path.read_bytes() for path in directory.rglob("*") if path.is_file()}
