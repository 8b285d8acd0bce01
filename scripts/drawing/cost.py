"""Error against cost: the column at W = 10000 with every shape, from coarse cells to fine."""

import json
from time import perf_counter
from typing import NamedTuple

from common import ROOT, RUNS, plt, save
from figures.methods import METHODS
from matplotlib.ticker import NullLocator
from studies.harness import origin, put, table

import pgimp
from pgimp.errors import RunError
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

TIME = 0.5


class Kind(NamedTuple):
    """A line of the picture: a method, its particles per cell, and what it costs to be stable."""

    name: str
    method: str
    per_cell: int
    cells: tuple[float, ...]
    courant: float = 0.2

    @property
    def label(self):
        """Name in picture and table."""
        return f"{self.name}, {self.per_cell} a cell"


COARSE = (5.0, 2.5, 1.0, 0.5, 0.25, 0.1)
FINE = (*COARSE, 0.05)
KINDS = (
    # At the Courant number of the others, mpm stops when the last particle leaves its cell.
    Kind("mpm", "mpm-tracked", 1, COARSE, 0.02),
    Kind("mpm", "mpm-tracked", 2, COARSE, 0.02),
    Kind("gimp, initial volume", "gimp", 1, FINE),
    Kind("gimp", "gimp-tracked", 1, FINE),
    Kind("gimp", "gimp-tracked", 2, FINE),
    Kind("finite-gimp", "finite-gimp", 1, FINE),
    Kind("finite-gimp", "finite-gimp", 2, FINE),
    Kind("fuzzy-nearest", "fuzzy-nearest", 2, FINE),
    Kind("fuzzy-constant", "fuzzy-constant", 1, FINE),
    Kind("fuzzy-constant", "fuzzy-constant", 2, FINE),
)


def measure(kind, cell):
    """Run the column on one rank, short runs thrice; returns the point of the quickest run."""
    points = [advance(kind, cell)]
    while len(points) < 3 and points[0]["seconds"] < 1.0:
        points.append(advance(kind, cell))
    return min(points, key=lambda point: point["seconds"])


def advance(kind, cell):
    """Run the column once; returns a point, its error None if the run stopped early."""
    words = [
        f"method={{{METHODS[kind.method].entry}, particles-per-cell: [{kind.per_cell}]}}",
        f"grid={{origin: [0.0], size: [55.0], cell: [{cell}]}}",
        f"time={{end: {TIME}, step: {kind.courant * 1.0e-3 * cell!r}}}",
        "exact=compaction",
    ]
    sim = Simulation(pgimp.load(ROOT / "cases/compaction.yaml", words), Serial())
    began = perf_counter()
    failure = None
    try:
        while not sim.finished:
            sim.advance()
    except RunError as found:
        failure = found
        print(f"pictures: {kind.label}, cell {cell}: {failure}")
    seconds = perf_counter() - began
    return {
        "kind": kind.label,
        "cell": cell,
        "error": None if failure else sim.diagnostics()["error"],  # (47)
        "particle_steps": sim.count * sim.step,
        "seconds": seconds,
    }


def front(points, cost):
    """The points that no other beats in both cost and error, from cheap to dear."""
    best = []
    for point in sorted(points, key=lambda point: (point[cost], point["error"])):
        if not best or point["error"] < best[-1]["error"]:
            best.append(point)
    return best


def error_and_cost(redraw):
    """Draw the error (47) over cell size, particle-steps and time, and write its page."""
    store = RUNS / "error-and-cost.json"
    if not (redraw and store.exists()):
        for kind in KINDS:
            advance(kind, 5.0)  # compiles
        points = [measure(kind, cell) for kind in KINDS for cell in kind.cells]
        RUNS.mkdir(exist_ok=True)
        found = {"origin": f"one core of {origin()}", "points": points}
        store.write_text(json.dumps(found, indent=1))
    data = json.loads(store.read_text())
    figure, axes = plt.subplots(1, 3, figsize=(9.4, 4.4), sharey=True)
    titles = {
        "cell": "cell size (column: 50)",
        "particle_steps": "particles x steps",
        "seconds": "wall time on one core [s]",
    }
    done = [point for point in data["points"] if point["error"] is not None]
    for axis, (quantity, title) in zip(axes, titles.items(), strict=True):
        for kind in KINDS:
            points = [p for p in done if p["kind"] == kind.label]
            colour = METHODS[kind.method].colour
            look = {"marker": "o", "mfc": "none"} if kind.per_cell == 2 else {"marker": "s"}
            axis.loglog(
                [p[quantity] for p in points], [p["error"] for p in points], **look, color=colour,
                label=kind.label, ms=4.5, lw=1.1,
            )  # fmt: skip
        if quantity != "cell":
            best = front(done, quantity)
            axis.step(
                [p[quantity] for p in best], [p["error"] for p in best], where="post",
                color="#d0d0d0", lw=6.0, zorder=0, label="best for its cost",
            )  # fmt: skip
        axis.set_xlabel(title)
    cells = sorted({point["cell"] for point in done})
    axes[0].set_xticks(cells, [f"{cell:g}" for cell in cells])
    axes[0].xaxis.set_minor_locator(NullLocator())
    axes[0].set_ylabel("error (47) at W = 10000")
    handles, labels = axes[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncol=4, fontsize=8)
    figure.supxlabel(data["origin"], fontsize=7, color="#606060")
    save(figure, "error-and-cost")
    write_table(data)


def write_table(data):
    """Write docs/convergence.md with the points."""
    cells = sorted({point["cell"] for point in data["points"]}, reverse=True)
    found = {(point["kind"], point["cell"]): _entry(point) for point in data["points"]}
    lines = [(kind.label, *(found.get((kind.label, cell), "") for cell in cells)) for kind in KINDS]
    titles = ("cell", *(f"{cell:g}" for cell in cells))
    put({"error-and-cost": table(titles, lines, f"Measured on {data['origin']}.")})


def _entry(point):
    error = "stopped" if point["error"] is None else f"{point['error']:.1e}"
    return f"{error} in {point['seconds']:.2g} s"
