"""A controller of gravity on all ranks: each_probe.py OUTPUT [resume | fail | local]."""

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "cases"))
from two_blocks import flying

import pgimp

#: Gravity along x follows the centre of mass; two checkpoints before the end.
CASE = flying(
    gravity=[{"control": "push", "start": 0.5}, 0.0],
    checkpoint={"every": {"steps": 40}, "keep": 9},
    history={"every": {"steps": 20}},
    output={"every": 1.0, "fields": ["velocity", "stress"]},
)


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


if __name__ == "__main__":
    pgimp.run(CASE, output=sys.argv[1], each=each(), resume="resume" in sys.argv, quiet=True)
