"""``now.history``: forces of tools and gauges for a function, against momentum and the history."""

import shutil

import each_probe
import numpy as np
import pytest
from processes import PROGRAMS
from run_files import digests, go_back
from staged_bar import bar

import pgimp
from pgimp.errors import RunError

pytestmark = pytest.mark.slow(60)

PROBE = PROGRAMS / "each_probe.py"


def seen(case, function, steps=4):
    """Call a function after every few steps of a case; the simulation."""
    sim = pgimp.Simulation(case, each=pgimp.Each(function, steps))
    sim.advance()
    return sim


def test_a_ram_stops_at_a_force_that_is_the_momentum_it_gave():
    """Means are over the time since the function last asked; lines of the history stay their own.

    What is told of a gauge is what the history has of that time.
    """
    felt, lines = [], []

    def control(now):
        each_probe.hold(now)
        felt[:] = now.state["felt"].tolist()

    sim = pgimp.Simulation(each_probe.RAM, each=pgimp.Each(control, 4, each_probe.ram().state))
    for _ in range(25):
        sim.step(4)
        lines.append(sim.diagnostics())
    time, force, momentum, level, cut = np.array(felt).T
    np.testing.assert_allclose(np.diff(momentum), -force[1:] * np.diff(time), atol=1e-12)
    assert momentum[0] == pytest.approx(-force[0] * time[0], abs=1e-12)  # since the start
    np.testing.assert_array_equal(momentum, [line["momentum-x"] for line in lines])
    np.testing.assert_allclose(force, [line["rigid.ram.force-x"] for line in lines], rtol=1e-12)
    asked = np.arange(2, 25, 3)
    for name, values in (("gauge.top.height", level), ("gauge.half.force-x", cut)):
        np.testing.assert_array_equal(values[asked], [lines[k][name] for k in asked])
    assert level[2] > 1.0 and np.abs(cut).max() > 0.1
    stop = int(np.argmax(force < each_probe.MOST))
    way = each_probe.SPEED * time[stop]
    assert 0.0 < way < 1.0 and force.min() < each_probe.MOST
    assert lines[-1]["rigid.ram.displacement-x"] == pytest.approx(way, rel=1e-12)


def test_bits_do_not_depend_on_ranks_nor_on_a_kill(mpirun, tmp_path):
    alone = pgimp.run(each_probe.RAM, output=tmp_path / "1", each=each_probe.ram(), quiet=True).path
    done = mpirun(3, [PROBE, tmp_path / "3", "ram"], 300)
    assert done.returncode == 0, done.stderr
    assert digests(tmp_path / "3") == digests(alone)
    shutil.copytree(alone, resumed := tmp_path / "2")
    go_back(resumed, 0.2)
    done = mpirun(2, [PROBE, resumed, "ram", "resume"], 300)
    assert done.returncode == 0, done.stderr
    assert digests(resumed) == digests(alone)


def test_a_resumed_run_feels_what_it_would_have_felt(tmp_path):
    """The mean that is asked for first began before the checkpoint."""
    felt = {}

    def control(now):
        each_probe.hold(now)
        felt[now.step] = now.history["rigid.ram.force-x"]

    def run(**how):
        felt.clear()
        function = pgimp.Each(control, 4, each_probe.ram().state)
        pgimp.run(each_probe.RAM, output=tmp_path / "run", each=function, quiet=True, **how)
        return dict(felt)

    whole = run()
    go_back(tmp_path / "run", 0.2)
    again = run(resume=True)
    assert min(again) == 24 and again[24] < -0.5
    assert again == {step: whole[step] for step in again}


def test_forces_go_on_into_the_next_stage():
    """Of a load that the second stage keeps, and one that it ends: rows are found by name."""
    pull = {"body": "bar", "face": "x-max", "traction": [2.0]}
    push = {"body": "bar", "face": "x-min", "traction": [0.5]}
    stages = [{"end": 1.2, "tractions": {"push": None}}]
    more = {"constraints": {}, "tractions": {"push": push, "pull": pull}, "boundaries": {}}
    found = []

    def look(now):
        found.append([now.history[f"traction.{name}-x"] for name in ("push", "pull")])

    seen(bar(*stages, waits=False, **more), look, 30)
    np.testing.assert_allclose(found[:3], [[0.5, 2.0]] * 3, rtol=1e-9)
    np.testing.assert_allclose(found[3], [np.nan, 2.0], rtol=1e-9)
    assert len(found) == 4


def test_unknown_columns_are_named():
    with pytest.raises(RunError, match=r"KeyError: .*unknown column 'momentum'.*momentum-x"):
        seen(bar(waits=False), lambda now: now.history["momentum"])
