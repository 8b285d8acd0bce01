"""When a run is to stop before its end: the parts that tell."""

import argparse
import ctypes
import os
import signal
import threading
import time
from types import SimpleNamespace

import pytest
from mentioned import mentions

from pgimp import signals
from pgimp.mpi.comm import Serial
from pgimp.running import stop as module
from pgimp.running.running import _request
from pgimp.running.stop import Held, Stop, clock, slurm_seconds_left, wall_time
from pgimp.solver.reduction import Request

pytestmark = pytest.mark.slow(30)


@pytest.fixture(autouse=True)
def usual(monkeypatch):
    """A program with no handlers of its own, outside of any batch job and of nohup."""
    defaults = {number: signal.SIG_DFL for number in (*signals.STOPPING, signal.SIGHUP)}
    defaults[signal.SIGINT] = signal.default_int_handler
    before = {number: signal.signal(number, usual) for number, usual in defaults.items()}
    for name in os.environ:
        if name.startswith("SLURM_"):
            monkeypatch.delenv(name)
    yield defaults
    for number, handler in before.items():
        signal.signal(number, handler)
    assert signals.received == []


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("0:00:01", 1),
        ("2:00:00", 7200),
        ("02:03:04", 7384),
        ("100:00:00", 360_000),
        ("1-00:00:00", 86_400),
        ("3-23:59:59", 345_599),
        ("2-12", 216_000),
        ("2-12:30", 217_800),
        (" 0:10:00 ", 600),
    ],
)
def test_wall_times(text, seconds):
    assert wall_time(text) == seconds
    assert wall_time(clock(seconds)) == seconds


@pytest.mark.parametrize(
    "text",
    ["", "90", "90:00", "1:2:3", "0:00:00", "0-0", "1:60:00", "1:00:60", "1-24:00:00", "-1:00:00",
     "1:00:00.5", "1h", "1-1-1", "nan", "1:00:00:00", "9" * 5000 + ":00:00"],
)  # fmt: skip
def test_what_is_no_wall_time(text):
    with pytest.raises(argparse.ArgumentTypeError, match="write HH:MM:SS or D-HH:MM:SS"):
        wall_time(text)


@pytest.fixture
def at(monkeypatch):
    """``at(t)`` sets the clock; it starts at 1000 s, 1e9 s after the epoch."""
    now = SimpleNamespace(value=1000.0)
    fake = SimpleNamespace(monotonic=lambda: now.value, time=lambda: 1e9 + now.value - 1000.0)
    monkeypatch.setattr(module, "time", fake)
    return lambda value: setattr(now, "value", value)


def first_moment(stop, at, reserve, among):
    for t in among:
        at(t)
        if stop.requested(reserve):
            return t
    return None


@pytest.mark.parametrize(("whole", "margin"), [(10.0, 1.0), (100.0, 5.0), (7200.0, 60.0)])
def test_a_wall_time_leaves_room_for_the_checkpoint_and_a_margin(at, whole, margin):
    stop = Stop(Serial(), whole)
    assert stop.reason == ""
    last = 1000.0 + whole - margin - 0.5
    assert first_moment(stop, at, 0.5, (1000.0, last - 0.01, last)) == last
    assert stop.signal == 0
    mentions(stop.reason, "wall time", clock(whole))
    mentions(str(stop), "before", stop.reason)
    at(0.0)
    assert stop.requested(0.0)


def test_the_command_counts_from_its_start_and_others_leave_the_clock_to_rank_0(at, monkeypatch):
    monkeypatch.setattr(signals, "installed", True)
    monkeypatch.setattr(signals, "BEGAN", 900.0)
    assert Stop(Serial(), 105.0).requested(0.0)
    assert not Stop(SimpleNamespace(rank=1), 105.0).requested(0.0)


@pytest.fixture
def squeue(tmp_path, monkeypatch):
    """``squeue(SCRIPT)`` puts a program of this name first on the path."""

    def put(script):
        program = tmp_path / "squeue"
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)

    monkeypatch.setenv("SLURM_JOB_ID", "12")
    return put


@pytest.mark.parametrize(
    ("left", "seconds"),
    [
        ("0:07", 7),
        ("9:30", 570),
        ("1:00:00", 3600),
        ("2-01:00:00", 176_400),
        ("UNLIMITED", None),
        ("NOT_SET", None),
        ("INVALID", None),
        ("", None),
    ],
)
def test_slurm_says_how_long_a_job_may_go_on(squeue, left, seconds):
    squeue(f'printf "11 0:01\\n12 {left}\\n13 0:01\\n"')
    assert slurm_seconds_left() == seconds


def test_squeue_is_asked_for_this_job_in_this_form(squeue, tmp_path):
    squeue(f'printf "%s|" "$@" >{tmp_path}/words; echo 12 1:00')
    assert slurm_seconds_left() == 60.0
    words = (tmp_path / "words").read_text()
    assert words == "--noheader|--jobs=12|--format=%A %L|"


@pytest.mark.parametrize(
    "script", ["exit 1", "echo what?", "echo 12 1:00 more", "sleep 30; echo 12 1:00"]
)
def test_a_squeue_that_does_not_work_is_no_limit(squeue, script, monkeypatch, capfd):
    monkeypatch.setattr(module, "_SQUEUE_SECONDS", 0.2)
    squeue(script)
    assert slurm_seconds_left() is None
    assert capfd.readouterr() == ("", "")


def test_the_environment_of_newer_slurms_saves_asking(squeue, at, monkeypatch):
    squeue("echo 12 0:01")
    monkeypatch.setenv("SLURM_JOB_END_TIME", "1000000100")
    assert slurm_seconds_left() == 100.0
    stop = Stop(Serial(), 7200.0)
    assert first_moment(stop, at, 0.0, (1094.0, 1095.0)) == 1095.0
    mentions(stop.reason, "Slurm")
    mentions(str(stop), "before", stop.reason)
    stop = Stop(Serial(), 4.0)
    assert first_moment(stop, at, 0.0, (1097.0, 1098.0)) == 1098.0
    mentions(stop.reason, "wall time 0:00:04")
    # A shell that has outlived its job is not in it any more.
    monkeypatch.setenv("SLURM_JOB_END_TIME", "999999999")
    assert slurm_seconds_left() is None
    monkeypatch.delenv("SLURM_JOB_ID")
    monkeypatch.setenv("SLURM_JOB_END_TIME", "1000000100")
    assert slurm_seconds_left() is None


@pytest.mark.parametrize("number", signals.STOPPING)
def test_signals_are_noted_within_the_context_and_strike_as_usual_after_it(usual, number):
    ends = {signal.SIGINT: KeyboardInterrupt, signal.SIGTERM: SystemExit}.get(number)
    try:
        with Stop(Serial(), None) as stop:
            assert not stop.requested(1e9) and not stop.agree(1e9)
            signal.raise_signal(number)
            assert stop.requested(0.0) and stop.agree(0.0)
    except (KeyboardInterrupt, SystemExit) as error:
        assert type(error) is ends
        assert ends is KeyboardInterrupt or error.code == 143
    else:
        assert ends is None
    name = signal.Signals(number).name
    assert (stop.signal, stop.reason, str(stop)) == (number, name, f"on {name}")
    assert {one: signal.getsignal(one) for one in usual} == usual
    with Stop(Serial(), None) as later:
        assert not later.requested(0.0)


def test_ctrl_c_that_comes_when_the_run_is_done_is_not_lost():
    with pytest.raises(KeyboardInterrupt), Stop(Serial(), None):
        signal.raise_signal(signal.SIGINT)


def test_ctrl_c_twice_strikes_at_once_and_other_signals_do_not():
    reached = []
    with pytest.raises(KeyboardInterrupt), Stop(Serial(), None) as stop:
        for number in (signal.SIGTERM, signal.SIGTERM, signal.SIGUSR1, signal.SIGUSR1):
            signal.raise_signal(number)
        signal.raise_signal(signal.SIGINT)
        reached.append(stop.requested(0.0))
        signal.raise_signal(signal.SIGINT)
        reached.append("too far")
    assert reached == [True] and stop.reason == "SIGTERM"


def test_a_failure_after_a_signal_stays_what_it_is():
    with pytest.raises(ZeroDivisionError), Stop(Serial(), None):
        signal.raise_signal(signal.SIGINT)
        raise ZeroDivisionError


def test_handlers_of_the_program_around_stay(usual):
    came = []
    signal.signal(signal.SIGUSR1, lambda number, _: came.append(number))
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    with Stop(Serial(), None) as stop:
        signal.raise_signal(signal.SIGUSR1)
        signal.raise_signal(signal.SIGTERM)
        assert not stop.requested(0.0)
    assert came == [signal.SIGUSR1]


def test_a_thread_leaves_signals_alone():
    seen = []

    def work():
        with Stop(Serial(), None) as inner:
            seen.append(signal.getsignal(signal.SIGUSR1))
            signals.received.append(signal.SIGUSR1)
            seen.append(inner.requested(0.0))
            signals.received.clear()

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [signal.SIG_DFL, False]


def test_ranks_agree_on_the_reason_of_the_lowest():
    def on(rank, others):
        return SimpleNamespace(rank=rank, allgather=lambda mine: [mine, *others])

    stop = Stop(on(0, [("", 0), ("SIGUSR1", 10), ("SIGTERM", 15)]), None)
    assert not stop.requested(0.0)
    assert stop.agree(0.0) and (stop.reason, stop.signal) == ("SIGUSR1", 10)
    assert stop.requested(0.0)
    assert not Stop(on(0, [("", 0)]), None).agree(0.0)


def test_held_raises_where_it_is_asked():
    with Held((signal.SIGTERM, signal.SIGHUP)) as held:
        held.check()
        signal.raise_signal(signal.SIGHUP)
        with pytest.raises(KeyboardInterrupt):
            held.check()
    assert held.came == [signal.SIGHUP]


def test_system_calls_of_libraries_go_on_after_a_signal():
    reader, writer = os.pipe()
    ident = threading.main_thread().ident

    def strike():
        time.sleep(0.1)
        signal.pthread_kill(ident, signal.SIGUSR1)
        time.sleep(0.1)
        os.write(writer, b"x")

    with Held((signal.SIGUSR1,)) as held:
        thread = threading.Thread(target=strike)
        thread.start()
        try:
            assert ctypes.CDLL(None).read(reader, ctypes.create_string_buffer(1), 1) == 1
        finally:
            thread.join()
            os.close(reader)
            os.close(writer)
    assert held.came == [signal.SIGUSR1]


def test_a_checkpoint_is_asked_for_once_until_it_is_known_whether_it_is_granted():
    """On several ranks that is a step later."""
    checkpoints = SimpleNamespace(overdue=True, seconds=0.0)
    recorder = SimpleNamespace(checkpoints=checkpoints, ready=True)
    stop = SimpleNamespace(requested=lambda reserve: False)
    sim = SimpleNamespace(agreed=True, request=Request.NONE, comm=Serial())
    sim.request = _request(sim, recorder, stop, 0.1)
    assert sim.request == Request.CHECKPOINT
    sim.agreed = False
    sim.request = _request(sim, recorder, stop, 0.1)
    assert sim.request == Request.NONE
    # What was asked for before is known now.
    assert _request(sim, recorder, stop, 0.1) == Request.CHECKPOINT
    # It was written, but there is time for another.
    sim.agreed, sim.request = True, Request.CHECKPOINT
    assert _request(sim, recorder, stop, 0.1) == Request.CHECKPOINT
