"""The hard cases, the nut, fluid and solution from outside: what the first seconds show."""

import subprocess
import sys

import numpy as np
from common import BLUE, GREY, PICTURES, RED, instants, particles, plt, run, save, shrink, speed

FLUID = ["--import", "cases/fluid.py"]


def nut(redraw):
    """Four instants, by ``pgimp plot``."""
    directory = run("geometry/nut", redraw, "nut").path
    path = PICTURES / "geometry-nut.png"
    words = [sys.executable, "-m", "pgimp", "plot", directory, "--field", "von-mises"]
    words += ["--time", "0,0.036,0.046,0.06", "-o", path]
    subprocess.run(words, check=True)
    shrink(path)


def fluid_dam_break(redraw):
    """The water at six instants, coloured by its speed."""
    results = run("fluid/dam-break", redraw, "fluid-dam-break", ranks=1, words=FLUID)
    figure, axes = plt.subplots(2, 3, figsize=(9, 3.6), sharex=True, sharey=True)
    times = (0.0, 0.25, 0.5, 0.75, 1.0, 4.0)
    look = {"xlim": (0.0, 2.0), "ylim": (0.0, 1.0), "aspect": "equal", "title": "t = {:.2f} s"}
    instants(axes.flat, results, times, speed, (0.0, 3.0), {"label": "speed [m/s]"}, **look)
    save(figure, "fluid-dam-break")


def own_swirl(redraw):
    """The body at three instants, coloured by the von Mises stress; its error on three grids."""
    cells, results, words = (0.1, 0.05, 0.025), {}, ["--import", "cases/swirl.py"]
    for cell in cells:
        change = [f"grid.cell=[{cell},{cell}]", f"time.step={0.05 * cell}"]
        results[cell] = run("own/swirl", redraw, f"swirl-{cell}", change, ranks=1, words=words)
    figure, axes = plt.subplots(1, 4, figsize=(10, 2.8), layout="constrained")
    look = {"xlim": (0.0, 1.0), "ylim": (0.0, 1.0), "aspect": "equal", "title": "t = {:.1f} s"}
    bar = {"label": "von Mises stress [Pa]"}
    shown = results[0.05], (0.0, 0.2, 0.4), "von-mises", (0.0, 220.0)
    instants(axes[:3], *shown, bar, **look)
    for cell, colour in zip(cells, (RED, BLUE, GREY), strict=True):
        history = results[cell].history
        error = 1e3 * history["error.displacement-l2"]
        axes[3].semilogy(history["time"][1:], error[1:], color=colour, label=f"{1e3 * cell:g} mm")
    axes[3].set(xlabel="time [s]", ylabel="error of the displacement [mm]")
    axes[3].legend(fontsize=7)
    save(figure, "own-swirl")


def hard_shock(redraw):
    """Stress along the bar at the end, with viscosity and without, against the exact one."""
    bare = ["materials.bar.viscosity=null"]
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.0), sharey=True)
    for axis, shape in zip(axes, ("finite-gimp", "mpm"), strict=True):
        axis.plot([0, 32, 32, 42], [-200, -200, 0, 0], "k-", lw=1, label="exact")
        for label, colour, more in (("without", RED, bare), ("with viscosity", BLUE, [])):
            changes = [f"method.shape={shape}", *more]
            name = f"hard-shock-{shape}-{len(more)}"
            frame = run("hard/shock", redraw, name, changes, ranks=1).frame(-1)
            place, stress = frame["position"][:, 0], frame["stress"][:, 0] / 1e3
            axis.plot(place, stress, ".-", color=colour, ms=3, lw=0.6, label=label)
        axis.set(xlabel="x", xlim=(0, 42))
        axis.set_title(shape, fontsize=10)
    axes[0].set_ylabel("stress [1000]")
    axes[1].legend(fontsize=8, loc="lower right")
    save(figure, "hard-shock")


def hard_column(redraw):
    """Stress at a weight of 2000, and its difference from (42), with gimp and finite-gimp."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.0))
    weight = 2000.0
    for shape, colour in (("gimp", RED), ("finite-gimp", BLUE)):
        changes = [f"method.shape={shape}", "time.end=0.1", "output.at=[]"]
        frame = run("hard/column", redraw, f"hard-column-{shape}", changes, ranks=1).frame(-1)
        place, stress = frame["position"][:, 0], frame["stress"][:, 0]
        # A point that was at X is at the integral of the stretch, of which (42) is the stress.
        start = np.linspace(0.0, 50.0, 5001)
        pressed = -weight * (1.0 - start / 50.0)
        moved = start - weight / 1e6 * (start - start**2 / 100.0)
        exact = np.interp(place, moved, pressed)
        left.plot(place, stress, color=colour, label=shape)
        right.plot(place, 100.0 * (stress - exact) / weight, color=colour, lw=0.8, label=shape)
    left.plot(place, exact, "k--", lw=1, label="exact")
    left.set(xlabel="x", ylabel="stress")
    right.set(xlabel="x", ylabel="difference [% of the weight]")
    left.legend(fontsize=8)
    save(figure, "hard-column")


def hard_grazing(redraw):
    """Energy over a hundred periods, relative to that of the start."""
    figure, axis = plt.subplots(figsize=(9, 3.0))
    for shape, colour in (("fuzzy-nearest", GREY), ("finite-gimp", BLUE)):
        changes = [f"method.shape={shape}"]
        history = run("hard/grazing", redraw, f"hard-grazing-{shape}", changes, ranks=1).history
        energy = history["kinetic-energy"] + history["strain-energy"]
        axis.plot(
            history["time"] / 0.08, 100 * energy / energy[0], color=colour, lw=0.7, label=shape
        )
    axis.set(xlabel="periods", ylabel="energy [%]", xlim=(0, 100))
    axis.legend(fontsize=8)
    save(figure, "hard-grazing")


def hard_spinning(redraw):
    """The square in its first turn, and its angular momentum over two."""
    turn = 62.83185307179586
    changes = [f"time.end={2 * turn}", f"output.every={turn / 8}", f"history.every={turn / 20}"]
    results = run("hard/spinning", redraw, "hard-spinning", changes, ranks=1)
    figure = plt.figure(figsize=(9, 2.8))
    left, right = figure.subfigures(1, 2, width_ratios=(2.2, 1.0))
    look = {"xlim": (0.2, 1.8), "ylim": (0.2, 1.8), "aspect": "equal"}
    times = (0.0, turn / 8, 2 * turn)
    instants(left.subplots(1, 3, sharey=True), results, times, speed, (0.0, 0.075),
             {"label": "speed", "shrink": 0.6}, title="t = {:.3g}", **look)  # fmt: skip
    axis, history = right.subplots(), results.history
    spin = history["angular-momentum-z"]
    axis.plot(history["time"] / turn, 100 * spin / spin[0], color=BLUE)
    axis.set(xlabel="turns", ylabel="angular momentum [%]")
    save(figure, "hard-spinning")


def hard_translation(redraw):
    """The stress after a tenth of the flight, with finite-gimp and mpm, and its error."""
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.0))
    for axis, shape, colour in zip(axes, ("finite-gimp", "mpm"), (BLUE, RED), strict=False):
        changes = [f"method.shape={shape}", "time.end=40.4", "history.every=0.404"]
        results = run("hard/translation", redraw, f"hard-translation-{shape}", changes, ranks=1)
        frame, history = results.frame(-1), results.history
        shown = particles(axis, frame, lambda frame: frame["stress"][:, 0], (0.0, 0.004))
        axis.set(aspect="equal")
        axis.set_title(f"{shape}, t = {frame.time:g}", fontsize=10)
        axes[2].semilogy(history["time"][1:], history["error"][1:], color=colour, label=shape)
    figure.colorbar(shown, ax=list(axes[:2]), label="stress xx", shrink=0.8, extend="both")
    axes[2].set(xlabel="time", ylabel="error of the stress")
    axes[2].legend(fontsize=8)
    save(figure, "hard-translation")


def hard_bending(redraw):
    """Deflection over the load, with mean dilatation and without, on cells twice as large."""
    figure = plt.figure(figsize=(9, 3.0))
    left, right = figure.subfigures(1, 2, width_ratios=(1.9, 1.0))
    axes, below = left.subplots(1, 2, sharey=True), right.subplots()
    for axis, label, colour, more in zip(
        axes,
        ("pointwise", "b-bar"),
        (RED, BLUE),
        ([], ["method.volumetric=b-bar", "time.step.courant=0.3"]),
        strict=True,
    ):
        changes = ["grid.cell=[0.25,0.25]", *more]
        results = run("hard/bending", redraw, f"hard-bending-{label}", changes, ranks=1)
        frame, history = results.frame(-1), results.history
        shown = particles(axis, frame, "pressure", (-4e-3, 4e-3))
        axis.set(aspect="equal", xlim=(0.0, 2.1))
        axis.set_title(f"volumetric: {label}", fontsize=10)
        way = 1.0 - history["body.beam.centre-y"]
        below.plot(history["time"], 1e3 * way, color=colour, label=label)
    left.colorbar(shown, ax=list(axes), label="pressure", shrink=0.7, extend="both")
    below.axhline(5.80, color="k", ls="--", lw=1, label="quadratic elements")
    below.set(xlabel="time", ylabel="deflection [1e-3]")
    below.legend(fontsize=8)
    save(figure, "hard-bending")
