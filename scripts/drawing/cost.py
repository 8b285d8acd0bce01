"""Error against cost: the column at W = 10000 with the shapes and volumes, from coarse to fine."""

import json
import os
import platform
from datetime import date
from importlib.metadata import version
from pathlib import Path
from time import process_time
from typing import NamedTuple

import numpy as np
from column import LENGTH, RATE, column_stress
from common import BLUE, GREEN, GREY, ORANGE, RED, ROOT, RUNS, plt, save

import pgimp
from pgimp.errors import RunError
from pgimp.parallel.comm import Serial

TIME = 0.5
START, END = "<!-- written by scripts/pictures error-and-cost -->\n", "<!-- end -->"


class Kind(NamedTuple):
    """A line of the picture; the steps are in parts of the time a wave takes through a cell."""

    label: str
    shape: str
    volume: str
    per_cell: int
    courant: float
    colour: str
    marker: str
    cells: tuple[float, ...]


COARSE = (5.0, 2.5, 1.0, 0.5, 0.25, 0.1)
KINDS = (
    Kind("gimp, tracked, 1 a cell", "gimp", "tracked", 1, 0.2, BLUE, "o", (*COARSE, 0.05)),
    Kind("gimp, tracked, 2 a cell", "gimp", "tracked", 2, 0.2, GREEN, "^", (*COARSE, 0.05)),
    Kind("gimp, initial, 2 a cell", "gimp", "initial", 2, 0.2, ORANGE, "s", (*COARSE, 0.05)),
    # At the Courant number of the others, mpm stops when the last particle leaves its cell.
    Kind("mpm, tracked, 2 a cell", "mpm", "tracked", 2, 0.02, GREY, "x", COARSE),
    Kind("mpm, initial, 2 a cell", "mpm", "initial", 2, 0.02, RED, "+", COARSE),
)


def measure(kind, cell):
    """Run the column on one rank, short runs thrice; returns the point of the quickest run."""
    points = [advance(kind, cell)]
    while len(points) < 3 and points[0]["seconds"] < 1.0:
        points.append(advance(kind, cell))
    return min(points, key=lambda point: point["seconds"])


def advance(kind, cell):
    """Run the column once; returns a point, its error None if the run stopped early."""
    overrides = {
        "method.shape": kind.shape,
        "method.volume": kind.volume,
        "method.particles_per_cell": [kind.per_cell],
        "grid.cell": [cell],
        "grid.size": [55.0],
        "time.end": TIME,
        "time.step": kind.courant * 1.0e-3 * cell,
    }
    words = [f"{key}={value}" for key, value in overrides.items()]
    sim = pgimp.Simulation(pgimp.load(ROOT / "cases/compaction.yaml", words), Serial())
    began = process_time()
    error = None
    try:
        while not sim.finished:
            sim.advance()
        rows = sim.live()
        exact, _ = column_stress(sim.particles.x[rows, 0], TIME)
        difference = np.abs(exact - sim.particles.sigma[rows, 0])
        weight = RATE * TIME * LENGTH
        error = float((difference * cell / kind.per_cell).sum() / (weight * LENGTH))  # (47)
    except RunError as failure:
        print(f"pictures: {kind.label}, cell {cell}: {failure}")
    seconds = process_time() - began
    return {
        "kind": kind.label,
        "cell": cell,
        "error": error,
        "particle_steps": sim.count * sim.step,
        "seconds": seconds,
    }


def origin():
    """Machine, versions and date of a measurement."""
    cpu = platform.machine()
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            cpu = line.partition(":")[2].strip()
            break
    versions = ", ".join(f"{name} {version(name)}" for name in ("pgimp", "numba", "numpy"))
    return f"one core of {cpu} ({os.cpu_count()} cores), {versions}, {date.today()}"


def error_and_cost(redraw):
    """Draw the error (47) over cell size, particle-steps and time, and write the README's table."""
    store = RUNS / "error-and-cost.json"
    if not (redraw and store.exists()):
        measure(KINDS[0], 5.0)  # compiles
        points = [measure(kind, cell) for kind in KINDS for cell in kind.cells]
        RUNS.mkdir(exist_ok=True)
        store.write_text(json.dumps({"origin": origin(), "points": points}, indent=1))
    data = json.loads(store.read_text())
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.9), sharey=True)
    titles = {
        "cell": "cell size (column: 50)",
        "particle_steps": "particles x steps",
        "seconds": "CPU time [s]",
    }
    for axis, (quantity, title) in zip(axes, titles.items(), strict=True):
        for kind in KINDS:
            points = [p for p in data["points"] if p["kind"] == kind.label]
            done = [p for p in points if p["error"] is not None]
            axis.loglog(
                [p[quantity] for p in done],
                [p["error"] for p in done],
                marker=kind.marker,
                color=kind.colour,
                label=kind.label,
                ms=5,
                lw=1.2,
            )
        axis.set_xlabel(title)
    axes[0].invert_xaxis()
    axes[0].set_ylabel("error (47) of the stress at W = 10000")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncol=3, fontsize=9)
    figure.supxlabel(data["origin"], fontsize=7, color="#606060")
    save(figure, "error-and-cost")
    write_table(data)


def write_table(data):
    """Put the points into README.md, between their marks."""
    cells = sorted({point["cell"] for point in data["points"]}, reverse=True)
    table = {(point["kind"], point["cell"]): point for point in data["points"]}
    lines = ["| cell | " + " | ".join(kind.label for kind in KINDS) + " |"]
    lines.append("|---" * (len(KINDS) + 1) + "|")
    for cell in cells:
        entries = [_entry(table.get((kind.label, cell))) for kind in KINDS]
        lines.append(f"| {cell:g} | " + " | ".join(entries) + " |")
    put_between(START, "\n".join([*lines, "", f"Measured on {data['origin']}.", ""]))


def put_between(start, text):
    """Replace what README.md has between a mark and the next end mark."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    before, mark, rest = page.partition(start)
    _, end, after = rest.partition(END)
    if not (mark and end):
        raise SystemExit(f"pictures: README.md lacks the marks {start.strip()} and {END}")
    (ROOT / "README.md").write_text(before + mark + text + end + after, encoding="utf-8")


def _entry(point):
    if point is None:
        return ""
    error = "stopped" if point["error"] is None else f"{point['error']:.1e}"
    return f"{error} in {point['seconds']:.2g} s"
