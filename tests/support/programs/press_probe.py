"""A ram that stops at a force, on all ranks: press_probe.py OUTPUT [resume]."""

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "cases"))
from rams import struck

import pgimp

#: The ram's velocity, and the force at which it stops.
SPEED, MOST = 1.0, -4.0
CASE = struck(2, {"friction": 0.3}, velocity=[{"control": "feed", "start": SPEED}, 0.0]) | {
    "gauges": {"top": {"level": [5.5]}, "half": {"cut": {"box": {"min": [5.5, 0], "max": [9, 8]}}}},
    "checkpoint": {"every": {"steps": 20}, "keep": 9},
    "history": {"every": {"steps": 15}},
    "output": {"every": 1.0},
}


def control(now):
    """Stop at the force; note what was felt every time, and a gauge every third time."""
    felt = now.state["felt"]
    row = [now.time, now.history["tool.ram.force-x"], now.history["momentum-x"], 0.0, 0.0]
    if now.step % 12 == 0:
        row[3:] = now.history["gauge.top.height"], now.history["gauge.half.force-x"]
    now.state["felt"] = np.concatenate([felt, [row]])
    if row[1] < MOST:
        now.loads["feed"] = 0.0


def each():
    """The controller with its memory."""
    return pgimp.Each(control, steps=4, state={"felt": np.zeros((0, 5))})


if __name__ == "__main__":
    pgimp.run(CASE, output=sys.argv[1], each=each(), resume="resume" in sys.argv, quiet=True)
