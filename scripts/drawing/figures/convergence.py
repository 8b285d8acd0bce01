"""Figures 10 and 11: the error (47) of the column's stress over the size of the cells."""

from common import plt, save

from figures.methods import FUZZY, GHOSTS, METHODS, PAPER
from figures.runs import Run

#: W = 10000 at the paper's speed of the ramp, which is a multiple of two wave transits.
TIME, TRANSIT = 0.5, 0.05
#: Five times faster, as the paper, and four times slower.
SPEEDS = {5.0: "x5", 1.0: "x1", 0.25: "x1/4"}
COUNTS = (1, 2, 4)
#: One step for all cells, stable in the finest: a wave crosses a fifth of it, in a quick
#: reproduction half; with that runs of mpm stop.
CELLS = (50.0, 25.0, 10.0, 5.0, 2.5, 1.0, 0.5, 0.25, 0.1, 0.05)
STEP, QUICK_STEP, QUICK_MPM_STEP = 1.0e-5, 1.25e-4, 5.0e-5
QUICK_CELLS = (10.0, 5.0, 2.5, 1.0, 0.5, 0.25)
QUICK_FUZZY_CELLS = (10.0, 1.0, 0.25)
MARKERS = {1: "s", 2: "o", 4: "^"}
CROSSED = {1: "x", 2: "+", 4: "1"}
LEGEND = {"fontsize": 7, "frameon": True, "framealpha": 0.9, "edgecolor": "none"}
#: Where runs that stop are marked: above the frame, in parts of its height.
STOPPED = 1.02


def cells_and_step(quick):
    return (QUICK_CELLS, QUICK_STEP) if quick else (CELLS, STEP)


def error_run(method, per_cell, cell, step):
    """A point of figure 10; one of its lines is also one of figure 11."""
    if (method, per_cell) == ("finite-gimp", 1):
        return speed_run(1.0, cell, step)
    return Run("column", method, cell, per_cell, step, (TIME,))


def speed_run(speed, cell, step):
    """A point of figure 11: at the paper's weight, and when the waves are greatest after it."""
    time = TIME / speed
    return Run("column", "finite-gimp", cell, 1, step, (time, round(time + TRANSIT, 9)), speed)


def runs(quick):
    cells, step = cells_and_step(quick)
    lines = [(m, n) for m in (*PAPER, "gimp-tracked", *FUZZY) for n in COUNTS]
    lines += [(m, n) for m in GHOSTS for n in (1, 2)]
    if quick:
        lines = [line for line in lines if line not in QUICK_OMITS]
    found = [
        error_run(*line, cell, QUICK_MPM_STEP if quick and line[0] == "mpm" else step)
        for line in lines
        for cell in cells
        if not quick or cell in QUICK_FUZZY_CELLS or line[0] not in (*FUZZY, *GHOSTS)
    ]
    slow = [cell for cell in cells if not quick or 0.5 <= cell <= 2.5]
    return found + [
        speed_run(speed, cell, step)
        for speed in SPEEDS
        for cell in (slow if speed < 1.0 else cells)
    ]


#: Lines that a quick reproduction leaves out.
QUICK_OMITS = (
    ("gimp-tracked", 4),
    ("fuzzy-nearest", 4),
    *((method, n) for method in GHOSTS for n in (1, 2) if (method, n) != (GHOSTS[0], 2)),
)


def draw(results, folder):
    """Figure 10 as in the paper and for the others, figure 11."""
    figure, axis = plt.subplots(figsize=(6.0, 5.2))
    ours(axis, results, PAPER)
    _write(figure, folder / "fig10.png")
    figure, axis = plt.subplots(figsize=(6.0, 5.2))
    ours(axis, results, ("gimp-tracked", *FUZZY, GHOSTS[0], GHOSTS[1]))
    _write(figure, folder / "fig10-fuzzy.png")
    figure, axes = plt.subplots(1, 2, figsize=(9.4, 4.6), sharey=True)
    speeds(axes, results)
    _write(figure, folder / "fig11.png")


def for_docs(results, origin):
    """Both parts of figure 10 beside each other, for docs/convergence.md."""
    figure, axes = plt.subplots(1, 2, figsize=(9.4, 4.9), sharey=True)
    ours(axes[0], results, PAPER)
    ours(axes[1], results, ("gimp-tracked", *FUZZY, GHOSTS[0]))
    axes[0].set_title("the paper's methods (Fig. 10)", fontsize=10, pad=34)
    axes[1].set_title("volume tracked, and fuzzy particles", fontsize=10, pad=34)
    axes[1].set_ylabel("")
    figure.supxlabel(origin, fontsize=7, color="#606060")
    save(figure, "convergence")


def line_of(results, method, per_cell):
    """Records of a line of figure 10 by cell size, from coarse to fine."""
    found = {
        run.cell: records[0]
        for run, records in results.items()
        if run == error_run(method, per_cell, run.cell, run.step)
    }
    return dict(sorted(found.items(), reverse=True))


def speed_of(results, speed):
    """Both records of a line of figure 11 by cell size, from coarse to fine."""
    found = {
        run.cell: records
        for run, records in results.items()
        if run == speed_run(speed, run.cell, run.step)
    }
    return dict(sorted(found.items(), reverse=True))


def ours(axis, results, methods):
    """The errors of some methods, with the paper's axes, guides and markers."""
    ended, rows = [], 0
    for method in methods:
        shown = METHODS[method]
        for per_cell in COUNTS:
            line = line_of(results, method, per_cell)
            if not line:
                continue
            markers = CROSSED if method == "finite-gimp" else MARKERS
            style = {
                "marker": markers[per_cell], "mfc": shown.colour if method == "mpm" else "none",
                "color": shown.colour, "ms": 6.0, "lw": 0.7,
            }  # fmt: skip
            done = {cell: r["error"] for cell, r in line.items() if "error" in r}
            label = f"{per_cell} p/c {shown.label}"
            axis.plot(list(done), list(done.values()), label=label, **style)
            stopped = [cell for cell, r in line.items() if "stopped" in r]
            if stopped:
                place = [STOPPED + 0.03 * rows] * len(stopped)
                above = {"transform": axis.get_xaxis_transform(), "clip_on": False}
                axis.plot(stopped, place, **style | above | {"lw": 0.0, "ms": 4.5})
                ended += stopped
                rows += 1
    if ended:
        axis.text(
            1.5 * max(ended), STOPPED + 0.015 * (rows - 1), "these stop early: no error",
            transform=axis.get_xaxis_transform(), va="center", fontsize=8,
        )  # fmt: skip
    guides(axis)
    axis.set(xlim=(0.01, 100.0), ylim=(1e-8, 1.0), xscale="log", yscale="log")
    axis.set(xlabel="cell size (column: 50)", ylabel="error (47) at W = 10000")
    axis.legend(loc="lower right", labelspacing=0.25, **LEGEND)


def guides(axis):
    """First order dashed, second order solid, as in the paper."""
    ends = [0.02, 50.0]
    axis.plot(ends, [4e-3 * x for x in ends], "--", color="#b0b0b0", lw=1.0, zorder=0)
    axis.plot(ends, [2e-4 * x * x for x in ends], "-", color="#b0b0b0", lw=1.0, zorder=0)
    for x, y, order in ((0.016, 2.4e-4, 1), (0.016, 1.3e-6, 2)):
        axis.text(x, y, f"order {order}", fontsize=8, color="#808080")


def speeds(axes, results):
    """Finite GIMP with one particle per cell under faster and slower ramps."""
    colours = dict(zip(SPEEDS, ("#c0392b", "#303030", "#1f5fa8"), strict=True))
    for speed, name in SPEEDS.items():
        line = speed_of(results, speed)
        label = {"x5": "5 times faster", "x1": "as in figure 10", "x1/4": "4 times slower"}[name]
        style = {"color": colours[speed], "ms": 6.0, "lw": 0.8}
        cells = list(line)
        axes[0].plot(cells, [r[0]["error"] for r in line.values()], "x-", label=label, **style)
        static = f"{label}, against (42)"
        axes[1].plot(cells, [r[1]["error"] for r in line.values()], "x-", label=static, **style)
        label = f"{label}, with the waves"
        dynamic = [r[1]["dynamic"] for r in line.values()]
        axes[1].plot(cells, dynamic, "o--", mfc="none", label=label, **style)
    for axis in axes:
        guides(axis)
        axis.set(xlim=(0.01, 100.0), ylim=(1e-7, 1.0), xscale="log", yscale="log")
        axis.set_xlabel("cell size (column: 50)")
        axis.legend(loc="lower right", **LEGEND)
    axes[0].set_ylabel("error (47)")
    axes[0].set_title("W = 10000: the ramp's waves vanish", fontsize=10)
    axes[1].set_title("one wave transit later: they are at their greatest", fontsize=10)


def _write(figure, path):
    figure.savefig(path)
    plt.close(figure)
