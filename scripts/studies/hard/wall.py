"""The column under its weight near its wall: with and without mirrors, by shape.

Run as ``scripts/hard wall``: the column of cases/compaction.yaml at W = 40000, when
its foot is compressed by 4 %; deviations of the stress from (42), as parts of W.
"""

import numpy as np
from studies.hard.runs import field
from studies.harness import CASES
from studies.scenes import core, finished

SHAPES = ("gimp", "finite-gimp", "cpdi", "bspline-quadratic", "bspline-cubic")
YOUNG, LENGTH, WEIGHT = 1.0e6, 50.0, 40000.0


def column(shape, wall):
    """Mean and greatest deviation, that of the cell at the wall with its sign, and the tip's.

    Of the tip it is how far it stands too high, over the length.
    """
    method = f"method={{shape: {shape}, particles-per-cell: [2], wall: {wall}}}"
    sim = finished(core(CASES / "compaction.yaml", [method, "output.every=null"]))
    b = -WEIGHT / LENGTH
    length = LENGTH + b * LENGTH**2 / (2.0 * YOUNG)
    x, stress = field(sim, "x")[:, 0], field(sim, "sigma")[:, 0]
    above = np.maximum(length - x, 0.0)
    exact = YOUNG * (np.sqrt(2.0 * b * above / YOUNG + 1.0) - 1.0)
    error = (exact - stress) / WEIGHT
    tip = (x.max() + 0.25 - length) / LENGTH
    return np.abs(error).mean(), np.abs(error).max(), error[x < 1.0].mean(), tip


def main():
    for shape in SHAPES:
        for wall in ("ghost", "mirror"):
            mean, worst, near, tip = column(shape, wall)
            print(
                f"{shape}, {wall}: mean {mean:.1e}, worst {worst:.1e}, at the wall {near:+.1e}, "
                f"tip {tip:+.1e}"
            )
