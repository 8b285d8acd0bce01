"""What commands print: on streams that break or are not there, and never what steers a terminal."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from processes import PROGRAMS, clean_env, run
from run_pair import run_pair
from two_blocks import CASE

import pgimp
from pgimp import terminal
from pgimp.cli import main
from pgimp.running.log import Log

pytestmark = pytest.mark.slow(30)

PROBE = PROGRAMS / "stream_probe.py"
STUDY = """
format: 1
case: case.yaml
sweep: [{method.shape: [gimp, finite-gimp]}]
error: mass
"""
BATCH = ["batch", "--ranks=2", "--wall-time=1:00:00"]
UNSAFE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
NASTY = "a\x1b[31m\x9b2J\u202eb\rc"
#: Those that go on whatever becomes of their words.
LONG = ("run", "study")


@pytest.fixture
def pair(tmp_path):
    return run_pair(tmp_path)


@pytest.fixture
def folder(pair, monkeypatch):
    folder = pair[0].parent
    (folder / "case.yaml").write_text(CASE)
    (folder / "one" / "case.yaml").write_text(CASE)
    (folder / "study.yaml").write_text(STUDY)
    monkeypatch.chdir(folder)
    return folder


def test_streams_that_break_or_are_not_there(folder, python):
    job = python([PROBE], cwd=folder, timeout=300)
    assert job.returncode == 0, job.stderr
    answers = [json.loads(line) for line in job.stdout.splitlines()]
    assert len(answers) == 15 * 6
    for name, condition, status, said, data in answers:
        about = (name, condition, status, said)
        assert "Traceback" not in said and "Exception" not in said, about
        if name == "wrong":
            assert status == 2, about
        elif condition == "nobody" and name not in LONG:
            assert (status, said) == (141, ""), about
        elif condition.startswith("full") and name not in LONG:
            assert status == 1, about
            if condition == "full":
                words = "pgimp: cannot write to standard output: No space left on device\n"
                assert said == words, about
        else:
            # A study of which no run has a result has failed.
            assert (status, "pgimp:" in said) == (int(name == "study"), False), about
        if name == "run":
            assert data == "data\n", about


def test_a_run_without_any_standard_stream(folder):
    """The next files that are opened must not get the streams' numbers, and so their text."""
    words = ["-m", "pgimp", "case.yaml", "--set", "time.end=0.1", "--set", "output.at=[]"]
    shell = 'exec "$@" <&- >&- 2>&-'
    done = subprocess.run(
        ["sh", "-c", shell, "sh", sys.executable, *words], env=clean_env(), timeout=300
    )
    assert done.returncode == 0
    found = pgimp.open("case.out")
    assert found.state == "done"
    assert [frame.step for frame in found] == [0, 10]
    assert (folder / "case.out" / "log.txt").read_text().startswith("pgimp ")
    assert len(found.history) == 2


def test_reading_the_first_line_is_enough():
    done = run(["sh", "-c", f"{sys.executable} -m pgimp schema | head -n 1"])
    assert (done.stdout, done.stderr) == ("{\n", "")


def test_a_log_without_stdout_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    log = Log(True)
    log.write_to(tmp_path / "log.txt")
    log.say(f"with {NASTY} and \udc80")
    log.close()
    text = (tmp_path / "log.txt").read_text()
    assert text == "with a\\x1b[31m\\x9b2J\\u202eb\\rc and \\udc80\n"


@pytest.fixture
def hostile(folder):
    """Control characters in all that a stranger may have written."""
    (folder / NASTY).mkdir()
    (folder / f"{NASTY}.yaml").write_text("format: 1\n" + f'"{NASTY!a}": 1\n'.replace("'", ""))
    (folder / "bad.yaml").write_text('format: 1\ntitle: "\\e[31m\\r\\u202e"\n"\\e[2J": "\\e"\n')
    path = folder / "one" / "run.json"
    info = json.loads(path.read_text())
    info["starts"][-1] |= {"state": NASTY, "began": NASTY, "message": NASTY}
    path.write_text(json.dumps(info))
    path = folder / "one" / "history.csv"
    path.write_text(path.read_text().replace("value_0", NASTY.replace("\r", "")))
    return folder


@pytest.mark.parametrize(
    "words",
    [
        [f"{NASTY}.yaml"],
        [NASTY],
        ["case.yaml", "-o", "one"],
        ["case.yaml", "-o", NASTY, "--set", f"{NASTY}=1"],
        ["bad.yaml"],
        ["check", "bad.yaml"],
        ["check", f"{NASTY}.yaml"],
        ["check", "case.yaml", f"--{NASTY}"],
        ["init", NASTY],
        ["study", f"{NASTY}.yaml"],
        ["study", NASTY],
        ["plot", "one", "--columns", NASTY],
        ["plot", "one", "--columns", "nothing"],
        ["plot", "one", "--field", NASTY],
        ["plot", NASTY],
        ["compare", "one", "two"],
        ["compare", NASTY, "two"],
        [*BATCH, f"{NASTY}.yaml"],
        ["schema", NASTY],
        ["doctor", NASTY],
        ["bench", f"--cells={NASTY}"],
        ["case.yaml", "--import", f"{NASTY}.py"],
    ],
    ids=lambda words: UNSAFE.sub("", " ".join(words)),
)
def test_nothing_steers_the_terminal(hostile, capsys, words):
    assert main(words) != 0
    out, err = capsys.readouterr()
    assert out + err
    assert not UNSAFE.search(out + err), (out, err)


def test_from_python_too(hostile):
    found = pgimp.open("one")
    assert not UNSAFE.search(repr(found) + repr(found.history) + repr(found.probes))
    with pytest.raises(KeyError) as caught:
        found.history["vlue_1"]
    assert "did you mean 'value_1'? there are: time, step" in str(caught.value)
    assert not UNSAFE.search(str(caught.value))


def test_escaping_leaves_text_alone():
    text = "Zwölf 😀\tµm\n| naïve · 日本 |"
    assert terminal.escape(text) == text
    once = terminal.escape(NASTY)
    assert not UNSAFE.search(once) and terminal.escape(once) == once


def pipes(path):
    path.unlink()
    os.mkfifo(path)


def folders(path):
    path.unlink()
    path.mkdir()


def devices(path):
    path.unlink()
    path.symlink_to("/dev/zero")


def large(path):
    path.unlink()
    with open(path, "wb") as stream:
        stream.truncate(10**10)  # takes no room


@pytest.mark.parametrize("becomes", [pipes, folders, devices, large])
@pytest.mark.parametrize(
    "name", ["run.json", "history.csv", "case.yaml", "frames/particles-000001.h5"]
)
def test_what_is_no_plain_file_keeps_nobody_waiting(folder, capsys, monkeypatch, becomes, name):
    becomes(folder / "one" / name)
    for words in (["compare", "one", "two"], ["plot", "one"], ["plot", "one", "--field", "mass"]):
        status = main(words)
        err = capsys.readouterr().err
        assert status in (0, 1, 2) and "unexpected" not in err, (words, err)
    if name == "run.json":
        with pytest.raises(pgimp.UsageError):
            pgimp.open("one")
    assert main(["case.yaml", "-o", "one", "--set", "time.end=-1"]) == 2


@pytest.mark.parametrize("becomes", [pipes, folders, devices, large])
@pytest.mark.parametrize("command", [[], ["check"], ["study"], BATCH])
def test_a_case_that_is_no_plain_file(folder, capsys, monkeypatch, becomes, command):
    monkeypatch.setattr("pgimp.storage.plain.PATIENCE", 0.2)
    (folder / "new.yaml").touch()
    becomes(folder / "new.yaml")
    assert main([*command, "new.yaml"]) == 2
    assert "unexpected" not in capsys.readouterr().err


def test_a_case_from_a_pipe(folder, capsys):
    os.mkfifo("piped.yaml")
    writer = subprocess.Popen(["sh", "-c", "sleep 0.3; echo 'format: 3' > piped.yaml"])
    assert main(["check", "piped.yaml"]) == 2
    assert "format" in capsys.readouterr().err
    assert writer.wait() == 0


@pytest.mark.parametrize("kind", ["external link", "soft link", "storage", "virtual", "group"])
@pytest.mark.parametrize("grid", [False, True])
def test_frames_that_lead_to_other_files_are_refused(folder, capsys, kind, grid):
    """Behind the link is a pipe, which the HDF5 library would wait for."""
    import h5py

    from pgimp.io.results.gridreader import GridFrame

    os.mkfifo("pipe.h5")
    name = "position" if grid else "volume"
    path = folder / "one" / "frames" / ("grid-000001.h5" if grid else "particles-000001.h5")
    with h5py.File(path, "a") as file:
        if grid:
            file.attrs.update({"time": 0.1, "step": 1})
            file["connectivity"] = np.zeros((1, 4), "i8")
        else:
            del file[name]
        if kind == "external link":
            file[name] = h5py.ExternalLink("pipe.h5", "/data")
        elif kind == "soft link":
            file[name] = h5py.SoftLink("/id")
        elif kind == "group":
            file.create_group(name)
        elif kind == "storage":
            outside = [(str(folder / "pipe.h5"), 0, 8 * 31)]
            file.create_dataset(name, (31,), "f8", external=outside)
        else:
            layout = h5py.VirtualLayout((31,), "f8")
            layout[:] = h5py.VirtualSource(str(folder / "pipe.h5"), "data", (31,))
            file.create_virtual_dataset(name, layout)
    words = {"external link": "is a link", "soft link": "is a link", "group": "is no dataset"}
    with pytest.raises(pgimp.RunError, match=f"its {name} {words.get(kind, 'lies in other')}"):
        GridFrame(path) if grid else pgimp.open("one").frames
    if not grid:
        assert main(["compare", "one", "two"]) == 1
        assert main(["plot", "one", "--field", "volume"]) == 1
        assert "unexpected" not in capsys.readouterr().err
