"""Controllers on all ranks: each_probe.py OUTPUT [resume | fail | local | ram | ram resume]."""

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "cases"))
from rams import struck
from two_blocks import flying

import pgimp

#: Gravity along x follows the centre of mass; two checkpoints before the end.
CASE = flying(
    gravity=[{"control": "push", "start": 0.5}, 0.0],
    checkpoint={"every": {"steps": 40}, "keep": 9},
    history={"every": {"steps": 20}},
    output={"every": 1.0, "fields": ["velocity", "stress"]},
)

#: The ram's velocity, and the force at which it stops.
SPEED, MOST = 1.0, -4.0
RAM = struck(2, {"friction": 0.3}, velocity=[{"control": "feed", "start": SPEED}, 0.0]) | {
    "gauges": {"top": {"level": [5.5]}, "half": {"cut": {"box": {"min": [5.5, 0], "max": [9, 8]}}}},
    "checkpoint": {"every": {"steps": 20}, "keep": 9},
    "history": {"every": {"steps": 15}},
    "output": {"every": 1.0},
}


def control(now):
    """Pull the blocks back to the middle, by a rule with a memory."""
    p = now.particles
    weight = now.sum(p["volume"])
    centre = now.sum(p["volume"][:, None] * p["position"]) / weight
    masses = now.vertices()["mass"]
    now.state["mass"] = now.sum(masses)
    now.state["far"][:] = now.max(p["position"][:, 0]), now.min(p["position"][:, 0])
    now.state["sum"] += now.dt * (centre[0] - 6.0)
    now.state["calls"] += 1
    now.loads["push"] = -0.8 * (centre[0] - 6.0) - 0.3 * now.state["sum"]
    if sys.argv[2:] == ["fail"] and now.step == 20 and now.rank == now.ranks - 1:
        raise ZeroDivisionError("the controller is at its end")
    if sys.argv[2:] == ["local"]:
        now.state["mine"] = len(p["id"])


def each():
    """The controller with its memory."""
    state = {"sum": 0.0, "calls": 0, "far": np.zeros(2), "mass": 0.0}
    return pgimp.Each(control, steps=4, state=state)


def hold(now):
    """Stop at the force; note what was felt every time, and a gauge every third time."""
    felt = now.state["felt"]
    row = [now.time, now.history["rigid.ram.force-x"], now.history["momentum-x"], 0.0, 0.0]
    if now.step % 12 == 0:
        row[3:] = now.history["gauge.top.height"], now.history["gauge.half.force-x"]
    now.state["felt"] = np.concatenate([felt, [row]])
    if row[1] < MOST:
        now.loads["feed"] = 0.0


def ram():
    """That of the ram."""
    return pgimp.Each(hold, steps=4, state={"felt": np.zeros((0, 5))})


if __name__ == "__main__":
    case, function = (RAM, ram()) if "ram" in sys.argv else (CASE, each())
    pgimp.run(case, output=sys.argv[1], each=function, resume="resume" in sys.argv, quiet=True)
