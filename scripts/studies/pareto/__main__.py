"""Measures error against cost and writes docs/error-against-cost.md; see scripts/pareto."""

import argparse
import csv
import json
import os
import subprocess
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path
from time import process_time

from benchmarks.workers.taichi_python import taichi_python
from studies.pareto.candidates import METHODS
from studies.pareto.fronts_drawn import draw
from studies.pareto.fronts_table import fronts, prices
from studies.pareto.ladders import ladder
from studies.pareto.large_bodies import Hertz, Impact, Vortex
from studies.pareto.peer_runs import peer_ladder
from studies.pareto.small_bodies import Bending, Spinning, Waves

from pgimp.io.rundir.runinfo import cpu

ROOT = Path(__file__).resolve().parents[3]
OUT = ROOT / "pareto.out"
PAGES = ROOT / "scripts" / "pages"
PROBLEMS = (
    Waves(2), Bending(2), Vortex(), Spinning(2), Hertz(), Impact(), Waves(3), Bending(3),
    Spinning(3),
)  # fmt: skip


def origin(taichi):
    """Machine, versions and date."""
    names = ("pgimp", "numba", "numpy")
    words = [f"{name} {version(name)}" for name in names] + [f"Taichi {taichi}"] * bool(taichi)
    return f"{cpu()} ({os.cpu_count()} cores), {', '.join(words)}, {date.today()}"


def measure(problems, store):
    """Measure these problems; what the store has of others stays."""
    kept = json.loads(store.read_text()) if store.exists() else {"origins": {}, "records": []}
    names = {problem.name for problem in problems}
    kept["records"] = [r for r in kept["records"] if r["problem"] not in names]

    python = taichi_python()
    for problem in problems:
        began = process_time()
        methods = [m for m in METHODS if problem.initial or not m.initial]
        kept["records"] += ladder(problem, methods, problem.sizes)
        if problem.peer and python:
            found, kept["taichi"] = peer_ladder(problem, python)
            kept["records"] += found
        kept["origins"][problem.name] = origin(kept.get("taichi"))
        store.write_text(json.dumps(kept, indent=1))
        print(f"pareto: {problem.name}, {process_time() - began:.0f} s", flush=True)


def report(kept, problems):
    """Write pareto.csv; if all problems are there the tables, the pictures and the page, too."""
    records = kept["records"]
    keys = list(dict.fromkeys(key for record in records for key in record))
    with (OUT / "pareto.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, keys)
        writer.writeheader()
        writer.writerows(records)
    if len(problems) < len(PROBLEMS):
        print(f"{fronts(records, problems)}\n\n{prices(records, problems)}")
        print("pareto: not all problems are there; the page stays as it is")
        return
    said = dict.fromkeys(kept["origins"][problem.name] for problem in problems)
    flat, solid = ([p for p in problems if p.D == D] for D in (2, 3))
    tables = {
        "fronts": fronts(records, problems),
        "prices": f"{prices(records, flat)}\n\n{prices(records, solid)}",
        "origin": f"Measured on one core of {'; '.join(said)}.",
    }
    for name, text in tables.items():
        (PAGES / "tables" / f"pareto-{name}.md").write_text(text + "\n", encoding="utf-8")
    draw("error-against-cost", flat, records)
    draw("error-against-cost-3d", solid, records)
    subprocess.run([sys.executable, str(PAGES)], check=True)


def main():
    """Measure, and write pareto.json, the tables, the pictures and the page."""
    parser = argparse.ArgumentParser(prog="scripts/pareto")
    parser.add_argument("--redraw", action="store_true", help="tables from what is there")
    parser.add_argument("--only", default="", metavar="PROBLEM,..", help="the others stay")
    options = parser.parse_args()
    only = tuple(filter(None, options.only.split(",")))
    known = {problem.name: problem for problem in PROBLEMS}
    for name in only:
        if name not in known:
            parser.error(f"there is no {name}; there are {', '.join(known)}")
    OUT.mkdir(exist_ok=True)
    store = OUT / "pareto.json"
    if not options.redraw:
        measure([known[name] for name in only or known], store)
    kept = json.loads(store.read_text())
    report(kept, [p for p in PROBLEMS if p.name in kept["origins"]])
