"""Measures error against cost and writes docs/error-against-cost.md; see scripts/pareto."""

import argparse
import json
import os
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path
from time import process_time

from candidates import METHODS
from large_bodies import Hertz, Impact, Vortex
from ladders import ladder
from peer_runs import peer_ladder, taichi_python
from small_bodies import Bending, Spinning, Waves

from pgimp.io.rundir.runinfo import cpu

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "pareto.out"
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

    def put(found):
        kept["records"] += found
        store.write_text(json.dumps(kept, indent=1))

    for problem in problems:
        began = process_time()
        put(ladder(problem, METHODS, problem.sizes))
        kept["origins"][problem.name] = origin("")
        print(f"pareto: {problem.name}, {process_time() - began:.0f} s", flush=True)
    python = taichi_python()
    if python:
        found, taichi = peer_ladder(problems, python)
        kept["origins"] |= dict.fromkeys(names, origin(taichi))
        put(found)


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


if __name__ == "__main__":
    main()
