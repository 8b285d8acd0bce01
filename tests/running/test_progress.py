"""What a run says on the terminal and in its log, and when."""

from types import SimpleNamespace

import numpy as np
import pytest
from scenes import box, scene

import pgimp
from pgimp.running import progress
from pgimp.running.log import Log, timing_table
from pgimp.running.progress import Progress, duration
from pgimp.running.schedule import Schedule


def fixed_steps(schedule, step, number):
    return [n for n in range(1, number + 1) if schedule.due(n * step, n, step)]


def test_schedule_with_a_fixed_step():
    assert fixed_steps(Schedule(0.1), 1e-4, 20000) == list(range(1000, 20001, 1000))
    assert fixed_steps(Schedule(SimpleNamespace(steps=7)), 1e-4, 30) == [7, 14, 21, 28]
    assert fixed_steps(Schedule(0.25), 0.1, 12) == [3, 5, 8, 10]
    assert fixed_steps(Schedule(1e-6), 0.1, 4) == [1, 2, 3, 4]
    assert fixed_steps(Schedule(5e-324), 0.1, 4) == [1, 2, 3, 4]
    assert fixed_steps(Schedule(0.5, [0.72, 0.3, 0.31]), 0.1, 12) == [3, 4, 5, 8, 10]
    assert fixed_steps(Schedule(), 0.1, 100) == []
    # However the product rounds, multiples of a third of a day fall on every 25,000th step.
    assert fixed_steps(Schedule(28800.0 / 7), 28800.0 / 7 / 25000, 100_000) == [
        25000,
        50000,
        75000,
        100000,
    ]


def test_schedule_with_steps_of_any_size():
    random = np.random.default_rng(5)
    schedule, time, hits = Schedule(0.1), 0.0, []
    for step in range(1, 400):
        dt = random.uniform(0.001, 0.3)
        before, time = time, time + dt
        if schedule.due(time, step, dt):
            hits.append(step)
        crossed = int(np.floor(time / 0.1)) > int(np.floor(before / 0.1))
        assert crossed == (hits[-1:] == [step])
    assert hits


def test_the_log_keeps_what_was_said(tmp_path, capsys):
    log = Log(speaks=True)
    log.say("before there is a directory")
    log.write_to(tmp_path / "log.txt")
    log.say("after")
    log.note("only in the file")
    log.close()
    assert capsys.readouterr().out == "before there is a directory\nafter\n"
    text = (tmp_path / "log.txt").read_text()
    assert text == "before there is a directory\nafter\nonly in the file\n"
    quiet = Log(speaks=True, quiet=True)
    quiet.say("to the file only")
    assert capsys.readouterr().out == ""


def test_timing_table():
    table = timing_table([{"P2G": 3.0, "frames": 1.0}], 5.0).splitlines()
    cells = {line.split()[0]: line.split()[1:] for line in table[2:]}
    assert cells["P2G"] == ["3.0000", "3.0000", "3.0000", "60.0", "%"]
    assert cells["other"][-2:] == ["20.0", "%"]
    assert cells["total"] == ["5.0000", "100.0", "%"]


def test_timing_table_of_several_ranks_tells_the_imbalance():
    """Of what they do without waiting: 4 and 2 seconds, a third more than the mean."""
    ranks = [{"P2G": 3.0, "sort": 1.0, "exchange": 0.0}, {"P2G": 2.0, "exchange": 2.0}]
    assert timing_table(ranks, 5.0).splitlines()[-1].startswith("imbalance 33 %: the busi")


def test_plain_progress_lines_grow_rare(monkeypatch, capsys):
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(progress, "perf_counter", lambda: clock.now)
    sim = SimpleNamespace(time=0.0, step=0, dt=1e-4, known_count=1000, settling=False)
    sim.balance = SimpleNamespace(imbalance=None)
    bar = Progress(Log(speaks=True), sim, 100.0, 0)
    lines, looks = [], 0
    for step in range(1, 1_000_000):
        sim.step, sim.time = step, step * 1e-4
        clock.now = step * 5e-4
        bar.step()
        if out := capsys.readouterr().out if bar._looked == clock.now else "":
            lines.append((clock.now, out))
        looks += bar._looked == clock.now
    assert looks < 6000
    pauses = np.diff([0.0, *(when for when, _ in lines)])
    assert 10.0 <= pauses[0] < 10.5
    assert (pauses[1:] > pauses[:-1] - 0.5).all() and 60.0 <= pauses[-1] < 60.5
    when, line = lines[3]
    assert f"/100  step {round(when / 5e-4)}  dt 0.0001  2e+06 particle-steps/s" in line
    assert line.endswith(f"{duration(500.0 - when)} left\n") and "imbalance" not in line


def test_the_progress_line_tells_the_present_load(monkeypatch, capsys):
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(progress, "perf_counter", lambda: clock.now)
    load = SimpleNamespace(imbalance=0.042)
    sim = SimpleNamespace(time=0.0, step=0, dt=1e-4, known_count=1000, balance=load, settling=False)
    bar = Progress(Log(speaks=True), sim, 100.0, 0)
    for step in range(1, 60):
        sim.step, sim.time, clock.now = step, step * 1e-4, float(step)
        if step == 20:
            sim.known_count, load.imbalance = 500, 0.38
        bar.step()
    first, *_, last = capsys.readouterr().out.splitlines()
    assert "1e+03 particle-steps/s  imbalance 4 %  " in first
    assert "500 particle-steps/s  imbalance 38 %  " in last


def test_durations():
    assert [duration(s) for s in (0.0123, 9.996, 65.4, 3725.0, float("inf"))] == [
        "0.0123 s",
        "10 s",
        "1:05 min",
        "1:02:05 h",
        "?",
    ]


@pytest.mark.parametrize(("gravity", "shown"), [(0.2, False), (2.0, False), (4.0, True)])
def test_notes_at_the_end_are_shown_where_a_result_is_wrong(tmp_path, capsys, gravity, shown):
    """A column of twenty particles, of which the lowest boxes come to lie past the floor.

    Of the part o past it, the vertex behind the floor gets the mean of y from 0 to o, over cells.
    """
    column = scene(
        1, box([0], [10]), cells=[12], end=2.0, gravity=[-gravity],
        boundaries={"x-min": "fixed"}, history={"every": 0.1},
    )  # fmt: skip
    run = pgimp.run(column, output=tmp_path / "run")
    words = "% of the mass lay past x-min"
    log = (tmp_path / "run" / "log.txt").read_text()
    (note,) = (line for line in log.splitlines() if words in line)
    assert (words in capsys.readouterr().out) == shown
    assert ("too little to matter" in note) != shown
    assert ("are too small by that part" in note) == shown
    past = np.maximum(0.25 - run.frame(-1)["position"][:, 0], 0.0)
    part = float(note.partition("up to ")[2].split()[0])
    assert part == pytest.approx(100.0 * (past @ past) / 20.0, rel=0.03)  # two digits
