"""The column of the paper: stress against the exact solution."""

import numpy as np
from common import BLUE, GREY, ORANGE, frame_at, plt, run, save

YOUNG, LENGTH, RATE = 1.0e6, 50.0, 400.0


def column_stress(x, time):
    """Exact stress (42) of the column at a time of the ramp, and its length (43)."""
    b = -RATE * time
    length = LENGTH + b * LENGTH**2 / (2.0 * YOUNG)
    inside = np.maximum(2.0 * b * (length - x) / YOUNG + 1.0, 0.0)
    return YOUNG * (np.sqrt(inside) - 1.0), length


def compaction(redraw):
    """Stress over position at the paper's four instants, against the exact solution."""
    initial = "method.volume=initial"
    # With the case's step mpm stops when the last particle leaves its cell.
    mpm = ["method.shape=mpm", initial, "time.step=2.0e-5"]
    kinds = [
        ("gimp, volume tracked (the case)", BLUE, "o", run("compaction", redraw)),
        ("gimp, volume initial", ORANGE, "s",
         run("compaction", redraw, "compaction-initial", [initial], ranks=1)),
        ("mpm, volume initial", GREY, "x", run("compaction", redraw, "compaction-mpm", mpm, 1)),
    ]  # fmt: skip
    figure, axes = plt.subplots(
        2, 4, figsize=(9, 4.6), sharex=True, sharey="row", height_ratios=(1.2, 1.0)
    )
    for (upper, lower), time in zip(axes.T, (0.5, 0.6, 1.5, 2.0), strict=True):
        weight = RATE * time * LENGTH
        for label, colour, marker, results in reversed(kinds):
            frame = frame_at(results, time)
            x, stress = frame["position"][:, 0], frame["stress"][:, 0]
            style = {"color": colour, "label": label, "ms": 3, "mew": 0.8}
            upper.plot(x, stress / 1e3, marker, **style)
            lower.plot(x, 100.0 * (stress - column_stress(x, time)[0]) / weight, marker, **style)
        x = np.linspace(0.0, column_stress(0.0, time)[1], 200)
        upper.plot(x, column_stress(x, time)[0] / 1e3, "k-", lw=1.0, label="exact (42)")
        lower.axhline(0.0, color="k", lw=1.0)
        lower.set(xlabel="position x", ylim=(-8, 8))
        upper.set_title(f"W = {weight:.0f}, t = {time:g}", fontsize=10)
    axes[0, 0].set_ylabel("stress / 1000")
    axes[1, 0].set_ylabel("difference from (42)\n[% of W]")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside upper center", ncol=4, fontsize=9)
    save(figure, "compaction")
