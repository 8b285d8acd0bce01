"""Speed and error of a spinning block in 3D by method, as a table of the README."""

import json
from statistics import median
from time import perf_counter

from common import ROOT, RUNS
from cost import origin, put_between

from pgimp import Simulation, load
from pgimp.parallel.comm import Serial

START = "<!-- written by scripts/pictures methods -->\n"
ROUNDS = 5


METHODS = {
    "gimp": "{shape: gimp, particles_per_cell: [2, 2, 2]}",
    "gimp, affine": "{shape: gimp, particles_per_cell: [2, 2, 2], affine: true}",
    "finite-gimp": "{shape: finite-gimp, particles_per_cell: [2, 2, 2]}",
    "finite-gimp, affine": "{shape: finite-gimp, particles_per_cell: [2, 2, 2], affine: true}",
    "fuzzy-nearest": "{shape: fuzzy-nearest, particles_per_cell: [2, 2, 2]}",
    "fuzzy-constant": "{shape: fuzzy-constant, particles_per_cell: [2, 2, 2]}",
}


def methods(redraw):
    """Speed and errors of the spinning block by method, all by turns, into the README."""
    store = RUNS / "methods.json"
    if not (redraw and store.exists()):
        points: dict = {name: [] for name in METHODS}
        for turn in range(ROUNDS + 1):
            for name, method in METHODS.items():
                point = spin(method)
                if turn:  # the first one compiles
                    points[name].append(point)
        RUNS.mkdir(exist_ok=True)
        store.write_text(json.dumps({"origin": origin(), "points": points}, indent=1))
    data = json.loads(store.read_text())
    lines = ["| method | million particle-steps/s | displacement [mm] | stress [kPa] |"]
    lines.append("|---" * 4 + "|")
    for name, points in data["points"].items():
        speed = median(point["speed"] for point in points)
        u, s = points[0]["displacement"], points[0]["stress"]
        lines.append(f"| {name} | {speed / 1e6:.1f} | {1e3 * u:.2g} | {s / 1e3:.2g} |")
    note = f"Medians of {ROUNDS} runs, by turns, on {data['origin']}."
    put_between(START, "\n".join([*lines, "", note, ""]))


def spin(method):
    """Run cases/spinning-block.yaml once, in this process: its speed, its errors at the end."""
    sim = Simulation(load(ROOT / "cases/spinning-block.yaml", [f"method={method}"]), Serial())
    began = perf_counter()
    while not sim.finished:
        sim.advance()
    seconds = perf_counter() - began
    line = sim.diagnostics()
    return {
        "speed": sim.count * sim.step / seconds,
        "displacement": line["error.displacement-l2"],
        "stress": line["error.stress-l2"],
    }
