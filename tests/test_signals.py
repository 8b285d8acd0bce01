"""Signals to whole processes, from first moments to last ones, and a run that stops in time."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from processes import clean_env, interruptible
from two_blocks import CASE

from pgimp import cli, commands, signals

pytestmark = pytest.mark.slow(210)

CONSOLE = Path(sys.executable).parent / "pgimp"
# Imported by `signal` itself, and the first parts of pgimp.
LIGHT = {"__future__", "pgimp", "pgimp.signals", "signal", "enum", "types", "functools", "operator"}
LIGHT |= {"collections", "itertools", "keyword", "reprlib", "time"}
LIGHT |= {"_operator", "_collections", "_functools", "_signal"}


def test_before_its_handlers_a_run_imports_next_to_nothing(python):
    bare = python(["-c", "import sys; print(*sys.modules)"]).stdout.split()
    done = python(["-c", "import sys, pgimp.signals; print(*sys.modules)"])
    assert set(done.stdout.split()) - set(bare) <= LIGHT
    done = python(["-X", "importtime", CONSOLE, "none.yaml"])
    order = re.findall(r"^import time:.*\| +([\w.]+)$", done.stderr, re.M)
    assert order.index("pgimp.signals") < order.index("argparse") < order.index("pgimp.cli")
    assert not {"typing", "numpy", "mpi4py"} & set(order[: order.index("pgimp.signals")]) - set(
        bare
    )


STATE = """
import signal, sys
sys.argv[1:] = {words}
signal.signal(signal.SIGINT, signal.{interrupt})
import pgimp.__main__ as entry
from pgimp import cli, signals

numbers = signals.STOPPING
print([int(signal.getsignal(number) is signals.note) for number in numbers])
cli.main = lambda: 7
print(entry.main(), [int(signal.getsignal(number) == signal.SIG_IGN) for number in numbers])
"""


@pytest.mark.parametrize(
    ("words", "interrupt", "noted"),
    [
        (["some.yaml"], "default_int_handler", [1, 1, 1]),
        (["some.yaml"], "SIG_IGN", [0, 1, 1]),  # a shell's background job
        (["check", "some.yaml"], "default_int_handler", [0, 0, 0]),
        (["study"], "default_int_handler", [0, 0, 0]),
    ],
)
def test_signals_are_noted_for_runs_alone_and_ignored_at_the_end(python, words, interrupt, noted):
    done = python(["-c", STATE.format(words=words, interrupt=interrupt)])
    ignored = [1, 1, 1] if any(noted) else noted
    assert done.stdout == f"{noted}\n7 {ignored}\n", done.stderr


def test_tests_in_a_job_scripts_background_can_be_interrupted():
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        interruptible()
        child = subprocess.Popen(["sleep", "60"])
        child.send_signal(signal.SIGINT)
        assert child.wait(10) == -signal.SIGINT
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, usual)


def test_every_command_is_known_before_it_is_imported():
    modules = {path.stem for path in Path(commands.__file__).parent.glob("[a-z]*.py")}
    assert modules == {"run", "job", *commands.COMMANDS}  # a run, and what it is made of


def start(words, **more):
    return subprocess.Popen(
        list(map(str, words)), env=clean_env(), stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **more
    )  # fmt: skip


def wait_for_handler(process, number=signal.SIGUSR1):
    """Return the seconds until the process has a handler for the signal; that is the window."""
    began = time.monotonic()
    python = os.fsencode(sys.executable)
    while not Path(f"/proc/{process.pid}/cmdline").read_bytes().startswith(python):
        assert process.poll() is None  # before exec it has the launcher's handlers
    status = Path(f"/proc/{process.pid}/status")
    while not int(re.search(r"SigCgt:\s*(\w+)", status.read_text())[1], 16) >> (number - 1) & 1:
        assert process.poll() is None and time.monotonic() - began < 30.0
    return time.monotonic() - began


def test_ctrl_c_twice_in_the_first_moments_is_answered_in_one_line(tmp_path):
    (tmp_path / "slow.py").write_text("import time\ntime.sleep(5.0)\n")
    process = start([CONSOLE, "--import", tmp_path / "slow.py", "none.yaml"])
    wait_for_handler(process)
    for _ in range(2):
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
    assert (process.wait(30), process.stderr.read()) == (130, "pgimp: interrupted\n")


def test_what_a_module_makes_of_ctrl_c_is_an_interruption(monkeypatch, capsys):
    """C code that is interrupted may raise another error instead of the KeyboardInterrupt."""

    def broken(words):
        raise SystemError("a result with an exception set")

    monkeypatch.setattr(cli, "_dispatch", broken)
    assert cli.main(["none.yaml"]) == 1
    monkeypatch.setattr(signals, "interrupted", True)
    assert cli.main(["none.yaml"]) == 130
    first, second = capsys.readouterr().err.splitlines()
    assert "a result with an exception set" in first
    assert second == "pgimp: interrupted"


@pytest.mark.parametrize("words", [[CONSOLE], [sys.executable, "-m", "pgimp"]])
def test_from_its_handler_to_its_end_no_signal_kills(words, record_property):
    windows = []
    for _ in range(4):
        process = start([*words, "none.yaml"])
        windows.append(wait_for_handler(process))
        while process.poll() is None:
            process.send_signal(signal.SIGUSR1)
            process.send_signal(signal.SIGTERM)
            time.sleep(0.0005)
        assert process.returncode == 2
        assert "there is no case file none.yaml" in process.stderr.read()
    record_property("longest window in ms", 1e3 * max(windows))
    print("windows in ms:", *(f"{1e3 * window:.0f}" for window in sorted(windows)))


@pytest.fixture
def running(tmp_path):
    """``running(ranks)`` starts a run of hours; returns what was started, and the ranks' ids."""
    (tmp_path / "blocks.yaml").write_text(CASE)
    words = ["-m", "pgimp", "blocks.yaml", "-o", "out", "--set=time.end=200000.0"]
    words += ["--set=output.every={steps: 100000}", "--set=output.at=[]"]
    started = []

    def go(ranks, *more):
        mpirun = ["mpirun", "-q", "--oversubscribe", "--bind-to", "none", "-n", ranks]
        command = [*(mpirun if ranks > 1 else []), sys.executable, *words, *more]
        process = start(command, cwd=tmp_path)
        started.append(process)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        until = time.monotonic() + 30.0
        while ranks > 1 and len(children.read_text().split()) < ranks:
            assert process.poll() is None and time.monotonic() < until
            time.sleep(0.005)
        pids = [process.pid] if ranks == 1 else list(map(int, children.read_text().split()))
        return process, pids

    yield go
    for process in started:
        process.kill()
        process.communicate()


def wait_for_steps(process, folder):
    until = time.monotonic() + 60.0
    while not (folder / "out" / "frames" / "particles-000000.h5").exists():
        assert process.poll() is None and time.monotonic() < until
        time.sleep(0.02)
    time.sleep(0.1)


def check_stopped(process, folder, why):
    _, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (75, "")
    info = json.loads((folder / "out" / "run.json").read_text())["starts"][-1]
    assert (info["state"], info["message"]) == ("stopped", f"stopped {why}")
    assert f"stopped {why} at step {info['steps']}, " in (folder / "out" / "log.txt").read_text()
    assert (folder / "out" / "checkpoints" / f"step-{info['steps']:09d}.h5").exists()
    assert not list(folder.rglob("*.part"))
    return info["steps"]


@pytest.mark.parametrize(
    ("ranks", "addressee", "number"),
    [(1, 0, signal.SIGTERM), (2, 1, signal.SIGINT), (3, "mpirun", signal.SIGUSR1)],
)
def test_a_signal_to_any_rank_stops_the_run_with_a_checkpoint(
    running, tmp_path, ranks, addressee, number
):
    process, pids = running(ranks)
    wait_for_steps(process, tmp_path)
    os.kill(process.pid if addressee == "mpirun" else pids[addressee], number)
    assert check_stopped(process, tmp_path, f"on {signal.Signals(number).name}") > 0


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_signal_during_set_up_stops_the_run_before_its_first_step(running, tmp_path, ranks):
    process, pids = running(ranks)
    wait_for_handler(SimpleNamespace(pid=pids[-1], poll=process.poll))
    os.kill(pids[-1], signal.SIGTERM)
    assert check_stopped(process, tmp_path, "on SIGTERM") == 0


def test_a_run_stops_before_its_wall_time(running, tmp_path):
    began = time.monotonic()
    process, _ = running(1, "--wall-time=0:00:04")
    steps = check_stopped(process, tmp_path, "before the wall time 0:00:04")
    # Where compiling took longer than that; else a second's grace for a machine with much to do.
    assert steps == 0 or 3.0 < time.monotonic() - began < 5.0
