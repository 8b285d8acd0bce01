"""A run stops before its wall time."""

import itertools
import os
import time
from types import SimpleNamespace

from mentioned import mentions
from resumed import steps

import pgimp


def test_a_run_stops_before_its_wall_time(folder, tmp_path, capsys, monkeypatch):
    looks = itertools.count()  # by a clock that goes on by a hundredth of a second a look
    clock = SimpleNamespace(monotonic=lambda: 0.01 * next(looks), time=time.time)
    monkeypatch.setattr("pgimp.running.stop.time", clock)
    run = pgimp.run(
        folder / "blocks.yaml",
        output=tmp_path / "run",
        overrides=["time.end=200000.0", "output={every: null}"],
        wall_time=2.0,
    )
    assert clock.monotonic() < 1.2  # a second before it, and for a checkpoint
    assert run.state == "stopped" and steps(run) == [run.info["steps"]]
    for said in (capsys.readouterr().out, run.info["message"]):
        mentions(said, "stopped", "wall time 0:00:02")
    assert len(run) == 1 and os.listdir(run.path / "checkpoints")
