"""Pictures of cases/README.md: the bar that is pulled, the blocks that meet."""

import numpy as np
from drawing.common import BLUE, GREEN, GREY, ORANGE, RED, boxes, plt, save
from studies.hard.rows import METHODS
from studies.hard.runs import begin, field, watch

SIGNED = plt.get_cmap("coolwarm", 64)  # few enough colours for a palette to have them all
#: The first of the methods.
COLOURS = dict(zip(METHODS, (GREY, BLUE, RED, GREEN, ORANGE), strict=False))


def draw():
    stretch()
    blocks()


def kept_at(name, changes, times, *names):
    """Fields of all particles at some times of a run, as far as it comes, and how it ended."""
    sim = begin(name, changes)
    frames = []

    def keep(sim):
        if len(frames) < len(times) and sim.time >= times[len(frames)] - 1e-9:
            frames.append([field(sim, one) for one in names])

    run = watch(sim, 200, keep)
    return frames, run


def stretch():
    """Force of the constraint over the stretch, and where particles are when the bars tear."""
    figure, (force, bars) = plt.subplots(1, 2, figsize=(9, 3.6), width_ratios=(1.0, 1.2))
    times = (0.8, 2.0, 4.0)
    for place, (method, colour) in enumerate(COLOURS.items()):
        frames, run = kept_at("stretch", METHODS[method], times, "x")
        time, pull = run.lines["time"], run.lines["constraint.right-x"]
        force.plot(1.0 + 0.25 * time, pull / 1e6, color=colour, lw=1.2, label=method)
        for k, shown in enumerate((0, 1, 2)):
            if len(frames) > shown:
                x = frames[shown][0][:, 0]
                height = 0.15 - place - 0.3 * k
                bars.plot(x, np.full(len(x), height), "|", color=colour, ms=5, mew=0.8)
        if len(frames) < len(times):
            ended = f"{run.fault} at {1.0 + 0.25 * run.sim.time:.2f} times the length"
            bars.text(70.0, -0.3 - place, ended, color=colour, ha="center", va="center", fontsize=8)
    force.plot([1.0, 3.0], [0.0, 2.0], "k-", lw=0.8, label="exact")
    force.set(xlabel="length of the gauge over the first", ylabel="force / E", ylim=(-0.3, 2.1))
    force.legend(fontsize=8)
    bars.set(xlabel="position of the particles\nat 1.2, 1.5 and 2 times the length, from above")
    bars.set_ylim(-len(COLOURS) + 0.1, 0.4)
    bars.set_yticks([-place - 0.15 for place in range(len(COLOURS))], list(COLOURS))
    bars.grid(False)
    save(figure, "hard-stretch")


def blocks():
    """Blocks at the greatest compression and after the rebound, coloured by the pressure."""
    kinds = {
        "mpm, viscosity": ("mpm", {}),
        "finite-gimp": ("finite-gimp", {"materials.rubber.viscosity": None}),
        "finite-gimp, viscosity": ("finite-gimp", {}),
    }
    times = (1.5, 2.0, 4.5)
    figure, axes = plt.subplots(3, 3, figsize=(9, 5.2), sharex=True, sharey=True)
    for row, (label, (method, changes)) in zip(axes, kinds.items(), strict=True):
        frames, run = kept_at("blocks", METHODS[method] | changes, times, "x", "V", "sigma")
        for k, (axis, time) in enumerate(zip(row, times, strict=True)):
            axis.set(aspect="equal", xlim=(0.9, 4.1), ylim=(0.45, 2.05))
            axis.set_title(f"t = {time:g}", fontsize=9)
            axis.grid(False)
            if k < len(frames):
                x, V, sigma = frames[k]
                pressure = -sigma[:, :3].mean(axis=1)
                place = np.pad(x, ((0, 0), (0, 1)))
                drawn = boxes(axis, place, 0.5 * np.sqrt(V), pressure, (-0.2, 0.2), SIGNED)
            else:
                text = f"{run.fault}\nat t = {run.sim.time:.2f}"
                axis.text(0.5, 0.5, text, transform=axis.transAxes, ha="center", va="center")
        row[0].set_ylabel(f"{label}\ny", fontsize=9)
    for axis in axes[-1]:
        axis.set_xlabel("x", fontsize=9)
    bar = figure.colorbar(drawn, ax=axes, label="pressure / E", shrink=0.6, extend="both")
    bar.outline.set_linewidth(0.6)
    save(figure, "hard-blocks")
