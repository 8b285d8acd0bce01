"""Figures 4 to 9: stress over position in the column, and behind the shock."""

import numpy as np
from column import LENGTH, RATE, column_stress
from common import plt
from matplotlib.ticker import MultipleLocator

from figures.methods import FUZZY, GHOSTS, METHODS, PAPER, TRACKED
from figures.runs import SHOCK, TRANSIT, Run, shock_stress

INSTANTS = (0.5, 0.6, 1.5, 2.0)
FRACTIONS = (0.25, 0.3, 0.75, 1.0)
STEP = 1.0e-4
#: With the step of the others mpm stops when the last particle leaves its cell.
MPM_STEP = 2.0e-5
COUNTS = (1, 2, 4)
TITLES = {
    PAPER: "as in the paper", (*TRACKED, "finite-gimp"): "volume tracked",
    FUZZY: "size tracked, wall mirror", GHOSTS: "size fixed, wall ghost",
}  # fmt: skip
#: What all legends have in common; they may cover cell boundaries, no particles.
LEGEND = {
    "fontsize": 8, "title_fontsize": 9, "frameon": True, "framealpha": 0.9, "edgecolor": "none",
}  # fmt: skip


def column_run(method, step=None):
    step = step or (MPM_STEP if method.startswith("mpm") else STEP)
    return Run("column", method, 1.0, 2, step, INSTANTS, profile=True)


def shock_run(method, per_cell=2):
    times = tuple(TRANSIT * fraction for fraction in FRACTIONS)
    return Run("shock", method, 1.0, per_cell, STEP, times, profile=True)


def runs(quick):
    """The runs of figures 4 to 9, the same for a quick reproduction; the first one stops."""
    return [
        column_run("mpm", STEP),
        *(column_run(method) for method in METHODS),
        *(shock_run(method) for method in METHODS),
        *(shock_run(method, n) for n in COUNTS for method in METHODS),
    ]


def draw(results, folder):
    """Figures 4 to 9, and the same with the fuzzy methods."""
    crowds = {"": list(TITLES)[:2], "-fuzzy": list(TITLES)[2:]}
    for suffix, columns in crowds.items():
        column(results, folder / f"fig04{suffix}.png", columns, (0, 1), (-12000.0, 0.0), 2000)
        column(results, folder / f"fig05{suffix}.png", columns, (2, 3), (-40000.0, 0.0), 5000)
        shock(results, folder / f"fig06{suffix}.png", columns, (0, 1))
        shock(results, folder / f"fig07{suffix}.png", columns, (2, 3))
        zoom(results, folder / f"fig08{suffix}.png", columns)
    particles(results, folder / "fig09.png", ("mpm", "gimp", "gimp-tracked", "finite-gimp"))
    particles(results, folder / "fig09-fuzzy.png", (*FUZZY, *GHOSTS))


def column(results, path, columns, instants, limits, ticks):
    """Stress of the column at two instants, one above the other as in the paper."""
    figure, axes = _panels(columns, limits, ticks)
    for row, instant in zip(axes, instants, strict=True):
        time = INSTANTS[instant]
        x = np.linspace(0.0, column_stress(0.0, time)[1], 400)
        for axis, methods in zip(row, columns, strict=True):
            axis.plot(x, column_stress(x, time)[0], "k-", lw=1.0, label="exact (42)")
            # The paper has Finite GIMP in figure 5(b) only.
            shown = [m for m in methods if time == 2.0 or m != "finite-gimp"]
            for method in shown:
                _points(axis, results[column_run(method)][instant], METHODS[method])
            axis.legend(loc="lower right", title=f"W = {RATE * time * LENGTH:.0f}", **LEGEND)
    _save(figure, path)


def shock(results, path, columns, instants):
    """Stress behind the shock at two instants."""
    figure, axes = _panels(columns, (-25000.0, 0.0), 5000)
    for row, instant in zip(axes, instants, strict=True):
        fraction = FRACTIONS[instant]
        for axis, methods in zip(row, columns, strict=True):
            axis.plot(*shock_stress(fraction * TRANSIT), "k-", lw=1.0, label="exact (46)")
            for method in methods:
                if method != "finite-gimp":
                    _points(axis, results[shock_run(method)][instant], METHODS[method])
            place = "lower right" if fraction < 0.5 else "upper left"
            axis.legend(loc=place, title=f"t/(wave travel time) = {fraction:g}", **LEGEND)
    _save(figure, path)


def zoom(results, path, columns):
    """Stress behind the shock after one transit, in a narrow range (figure 8)."""
    figure, axes = _panels(columns, (-22000.0, -16000.0), 1000, rows=1)
    for axis, methods in zip(axes[0], columns, strict=True):
        axis.axhline(SHOCK, color="k", lw=1.0, label="exact (46)")
        for method in methods:
            if not method.startswith("mpm"):  # far outside
                _points(axis, results[shock_run(method)][-1], METHODS[method])
        axis.legend(loc="upper center", title="t/(wave travel time) = 1", **LEGEND)
    _save(figure, path)


def particles(results, path, methods):
    """Stress after one transit with 1, 2 and 4 particles per cell (figure 9)."""
    figure, axes = _panels([methods[:2], methods[2:]], (-25000.0, 0.0), 5000, titled=False)
    for axis, method in zip(axes.T.flat, methods, strict=True):
        axis.axhline(SHOCK, color="k", lw=0.8, ls=":")
        for per_cell, style in zip(COUNTS, ("--", "-.", "-"), strict=True):
            record = results[shock_run(method, per_cell)][-1]
            colour = ("#d98e04", "#1f5fa8", "#303030")[COUNTS.index(per_cell)]
            label = f"{per_cell} particle{'s' * (per_cell > 1)} per cell"
            if "x" in record:
                axis.plot(record["x"], record["stress"], style, color=colour, lw=1.0, label=label)
        axis.set_title(METHODS[method].label, fontsize=10)
        axis.legend(loc="upper left", **LEGEND)
    _save(figure, path)


def _panels(columns, limits, ticks, rows=2, titled=True):
    """Panels with the paper's axes; light vertical lines are the cells' boundaries."""
    width = 4.7 * len(columns)
    figure, axes = plt.subplots(
        rows, len(columns), figsize=(width, 3.3 * rows), squeeze=False, sharey=True
    )
    for axis in axes.flat:
        axis.grid(False)
        axis.vlines(np.arange(0.0, 51.0), *limits, color="#e2e2e2", lw=0.5, zorder=0)
        axis.set(xlim=(0.0, 50.0), ylim=limits, xlabel="position")
        axis.xaxis.set_major_locator(MultipleLocator(5))
        axis.yaxis.set_major_locator(MultipleLocator(ticks))
    for row in axes:
        row[0].set_ylabel("stress")
    if titled:
        for axis, methods in zip(axes[0], columns, strict=True):
            axis.set_title(TITLES[methods], fontsize=10)
    return figure, axes


def _points(axis, record, method):
    """A method's particles, or in the legend that it has none to show."""
    if "x" not in record:
        axis.plot([], [], method.marker, color=method.colour, label=f"{method.label}: stopped")
        return
    face = method.colour if method.marker == "x" else "none"
    style = {"mfc": face, "color": method.colour, "ms": 4.0, "mew": 0.9, "lw": 0.6}
    axis.plot(record["x"], record["stress"], method.marker + "--", label=method.label, **style)


def _save(figure, path):
    figure.savefig(path)
    plt.close(figure)
