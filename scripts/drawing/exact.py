"""The cases with exact solutions: shock, vortex, spinning block."""

import numpy as np
from common import BLUE, GREEN, GREY, RED, frame_at, instants, plt, run, save
from matplotlib.ticker import NullFormatter

from pgimp.utilities.plot.style import log_ticks

TRANSIT = 0.05


def shock(redraw):
    """Stress along the bar at the paper's four instants, with viscosity and without."""
    bare = run("shock", redraw, "shock-bare", ["materials.bar.viscosity=null"])
    runs = (("without", RED, bare), ("with viscosity", BLUE, run("shock", redraw)))
    figure, axes = plt.subplots(1, 4, figsize=(9, 3.0), sharey=True)
    for axis, part in zip(axes, (0.25, 0.3, 0.75, 1.0), strict=True):
        time = part * TRANSIT
        front = (1.0 - 1.0 / 50.0) * 1000.0 * time
        axis.plot([0, front, front, 50], [-20, -20, 0, 0], "k-", lw=1, label="exact")
        for label, colour, results in runs:
            frame = frame_at(results, time)
            place, stress = frame["position"][:, 0], frame["stress"][:, 0] / 1e3
            axis.plot(place, stress, ".-", color=colour, ms=3, lw=0.6, label=label)
        axis.set(xlabel="x", xlim=(0, 50), ylim=(-28, 2))
        axis.set_title(f"t = {part:g} transits", fontsize=10)
    axes[0].set_ylabel("stress [1000]")
    axes[1].legend(fontsize=8, loc="center right")
    save(figure, "shock")


def vortex(redraw):
    """Ring and a line that was radial, at three instants; errors over time at three cell sizes."""
    cells, results = (0.1, 0.05, 0.025), {}
    for cell in cells:
        change = [f"grid.cell=[{cell},{cell}]", f"time.step={0.08 * cell}"]
        results[cell] = run("vortex", redraw, f"vortex-{cell}", change)
    figure = plt.figure(figsize=(9, 5.6))
    above, below = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
    axes = above.subplots(1, 3, subplot_kw={"aspect": "equal"})
    top = np.percentile(frame_at(results[0.05], 0.5)["von-mises"], 99)

    def spokes(axis, frame):
        radius = np.linspace(0.75, 1.25, 60)
        s = (radius - 1.0) / 0.5
        angle = 0.15 * np.sin(np.pi * frame.time) * (1.0 - 4.0 * s * s) ** 2
        for way in angle + np.arange(8)[:, None] * np.pi / 4:
            axis.plot(radius * np.cos(way), radius * np.sin(way), color=RED, lw=1.2)

    instants(
        axes, results[0.05], (0.0, 0.5, 1.0), "von-mises", (0.0, top),
        {"label": "von Mises stress [Pa]"}, each=spokes, xlim=(-1.3, 1.3), ylim=(-1.3, 1.3),
        xlabel="x [m]",
    )  # fmt: skip
    axes[0].set_ylabel("y [m]")
    lower = below.subplots(1, 3)
    for column, (name, label, factor) in enumerate(
        (("displacement-l2", "displacement [mm]", 1e3), ("stress-l2", "stress [Pa]", 1.0))
    ):
        axis = lower[column]
        for cell, colour in zip(cells, (GREY, GREEN, BLUE), strict=True):
            history = results[cell].history[1:]
            error = factor * history[f"error.{name}"]
            axis.semilogy(history["time"], error, color=colour, label=f"{cell} m")
        axis.set(xlabel="time [s]", ylabel=f"rms error: {label}")
        log_ticks(axis.yaxis)
    lower[0].legend(fontsize=8, title="cell", title_fontsize=8, loc="lower right")
    axis = lower[2]
    worst = [1e3 * results[cell].history["error.displacement-l2"].max() for cell in cells]
    axis.loglog(cells, worst, "o-", color=BLUE, label="displacement")
    axis.loglog(cells, worst[-1] * (np.array(cells) / cells[-1]) ** 2, "k--", lw=1, label="order 2")
    axis.set(xlabel="cell [m]", ylabel="greatest rms error [mm]")
    axis.set_xticks(cells, [str(cell) for cell in cells])
    axis.xaxis.set_minor_formatter(NullFormatter())
    log_ticks(axis.yaxis)
    axis.legend(fontsize=9)
    save(figure, "vortex")


def spinning_block(redraw):
    """The block at four instants, and the errors over time."""
    results = run("spinning-block", redraw)
    figure = plt.figure(figsize=(9, 5.4))
    above, below = figure.subfigures(2, 1, height_ratios=(1.15, 1.0))
    axes = above.subplots(1, 4, subplot_kw={"aspect": "equal"})
    bar = {"location": "bottom", "aspect": 50, "shrink": 0.6, "extend": "neither"}
    instants(
        axes, results, (0.0, 0.25, 0.5, 0.75), lambda frame: frame["von-mises"] / 1e3, (0.0, 60.0),
        bar | {"label": "von Mises stress [kPa]"}, xlim=(-0.72, 0.72), ylim=(-0.78, 0.78),
        xticks=[], yticks=[], dimension=3,
        each=lambda axis, frame: axis.spines[:].set_visible(False),
    )  # fmt: skip
    history = results.history[1:]
    quantities = (("displacement", "displacement [mm]", 1e3), ("stress", "stress [kPa]", 1e-3))
    for axis, (name, label, factor) in zip(below.subplots(1, 2), quantities, strict=True):
        for kind, text, colour in (("l2", "mean square", BLUE), ("max", "greatest", RED)):
            error = factor * history[f"error.{name}-{kind}"]
            axis.semilogy(history["time"], error, color=colour, label=text)
        axis.set(xlabel="time [s]", ylabel=f"error: {label}")
        log_ticks(axis.yaxis)
        axis.legend(fontsize=9)
    save(figure, "spinning-block")


def plane_waves(redraw):
    """Velocities at three instants, and the errors over time."""
    results = run("plane-waves", redraw)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for at, colour in ((0.0, BLUE), (0.375, GREEN), (0.5, RED)):
        frame = frame_at(results, at)
        x, v = frame["position"][:, 0], frame["velocity"][:, 1]
        start = frame["unwrapped"][:, 0] - 0.5 * at
        exact = 0.25 + 0.04 * np.pi * np.sin(2 * np.pi * start) * np.cos(4 * np.pi * at)
        order = np.argsort(x)
        left.plot(x[order], exact[order], color=colour, lw=1)
        left.plot(x[order][::24], v[order][::24], "o", ms=3, color=colour, label=f"t = {at:g} s")
    left.set(xlabel="x [m]", ylabel="velocity along y [m/s]", xlim=(0.0, 1.0))
    left.legend(fontsize=9)
    history = results.history[1:]
    for kind, text, colour in (("l2", "mean square", BLUE), ("max", "greatest", RED)):
        error = 1e3 * history[f"error.displacement-{kind}"]
        right.semilogy(history["time"], error, color=colour, label=text)
    right.set(xlabel="time [s]", ylabel="error: displacement [mm]")
    log_ticks(right.yaxis)
    right.legend(fontsize=9)
    save(figure, "plane-waves")
