"""Speed and error of blocks in 3D, as the README's tables: the standard one, and by method."""

import json
import os
import subprocess
import sys
from statistics import median
from time import perf_counter

from common import ROOT, RUNS
from cost import origin, put_between

from pgimp import Simulation, load
from pgimp.parallel.comm import Serial

START = "<!-- written by scripts/pictures bench -->\n"
METHODS_START = "<!-- written by scripts/pictures methods -->\n"
PHASES = ("P2G", "grid", "G2P", "sort", "exchange")
ROUNDS = 5


def bench_once(ranks):
    """Run the benchmark in a process of its own."""
    words = [sys.executable, "-m", "pgimp", "bench", "--repeats", "4", "--json"]
    if ranks > 1:
        words = ["mpirun", "-q", "-n", str(ranks), *words]
    allow = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    done = subprocess.run(words, check=True, capture_output=True, text=True, env=os.environ | allow)
    return json.loads(done.stdout)


def bench(redraw):
    """Measure both by turns, and write the medians into the README."""
    store = RUNS / "bench.json"
    if not (redraw and store.exists()):
        bench_once(1)  # compiles
        rounds = [{ranks: bench_once(ranks) for ranks in (1, 2)} for _ in range(ROUNDS)]
        RUNS.mkdir(exist_ok=True)
        store.write_text(json.dumps({"origin": origin(), "rounds": rounds}, indent=1))
    data = json.loads(store.read_text())
    lines = ["| ranks | " + " | ".join(PHASES) + " | total | error of velocity | error of stress |"]
    lines.append("|---" * (len(PHASES) + 4) + "|")
    for ranks in ("1", "2"):
        runs = [one[ranks] for one in data["rounds"]]
        speeds = [median(run["phases"][phase] for run in runs) for phase in PHASES]
        speeds.append(median(run["particle_steps_per_second"] for run in runs))
        error = runs[0]["error"]
        cells = [ranks, *(f"{speed / 1e6:.1f}" for speed in speeds)]
        cells += [f"{error['velocity']:.1e}", f"{error['stress']:.1e}"]
        lines.append("| " + " | ".join(cells) + " |")
    machine = data["origin"].removeprefix("one core of ")
    note = f"Medians of {ROUNDS} runs of either, by turns, on {machine}."
    put_between(START, "\n".join([*lines, "", note, ""]))


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
    put_between(METHODS_START, "\n".join([*lines, "", note, ""]))


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
