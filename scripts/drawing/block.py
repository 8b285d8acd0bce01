"""The standard block of ``pgimp bench`` on one and two ranks, as the README's table."""

import json
import os
import subprocess
import sys
from statistics import median

from common import RUNS
from cost import origin, put_between

START = "<!-- written by scripts/pictures bench -->\n"
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
