"""Measures error against cost and writes docs/error-against-cost.md; see scripts/pareto."""

from time import process_time

from benchmarks.workers.taichi_python import taichi_python
from studies.harness import Kept, options_of, origin, out, put, write_csv
from studies.pareto.candidates import METHODS
from studies.pareto.fronts_drawn import draw
from studies.pareto.fronts_table import fronts, masses, prices
from studies.pareto.ladders import ladder
from studies.pareto.large_bodies import Hertz, Impact, Vortex
from studies.pareto.peer_runs import peer_ladder
from studies.pareto.small_bodies import Bending, Spinning, Waves

PROBLEMS = (
    Waves(2), Bending(2), Vortex(), Spinning(2), Hertz(), Impact(), Waves(3), Bending(3),
    Spinning(3),
)  # fmt: skip


def measure(problems, kept):
    """Measure these problems; what is kept of others stays."""
    names = {problem.name for problem in problems}
    kept["records"] = [r for r in kept.get("records", []) if r["problem"] not in names]
    kept.setdefault("origins", {})
    python = taichi_python()
    for problem in problems:
        began = process_time()
        methods = [m for m in METHODS if problem.initial or not m.initial]
        kept["records"] += ladder(problem, methods, problem.sizes)
        if problem.peer and python:
            found, kept["taichi"] = peer_ladder(problem, python)
            kept["records"] += found
        taichi = [f"Taichi {kept['taichi']}"] if kept.get("taichi") else []
        kept["origins"][problem.name] = origin(*taichi)
        kept.save()
        print(f"pareto: {problem.name}, {process_time() - began:.0f} s", flush=True)


def report(kept, problems):
    """Write pareto.csv; if all problems are there the tables, the pictures and the page, too."""
    records = kept["records"]
    write_csv(records, out("pareto") / "pareto.csv")
    if len(problems) < len(PROBLEMS):
        print(f"{fronts(records, problems)}\n{prices(records, problems)}")
        print("pareto: not all problems are there; the page stays as it is")
        return
    said = dict.fromkeys(kept["origins"][problem.name] for problem in problems)
    flat, solid = ([p for p in problems if p.D == D] for D in (2, 3))
    draw("error-against-cost", flat, records)
    draw("error-against-cost-3d", solid, records)
    put({
        "pareto-fronts": fronts(records, problems),
        "pareto-prices": f"{prices(records, flat)}\n{prices(records, solid)}",
        "pareto-origin": f"Measured on one core of {'; '.join(said)}.\n",
    })  # fmt: skip


def measure_masses(problems, kept):
    """Measure lumped and averaged mass in the initial configuration, and write their table."""
    methods = [m for m in METHODS if m.initial and (m.shape, m.affine) == ("gimp", False)]
    methods = [m for m in methods if m.per_cell == 2]
    records = []
    for problem in problems:
        if (name := f"masses of {problem.name}") not in kept:
            kept.add(name, ladder(problem, methods, problem.sizes))
            print(f"pareto: {problem.name}", flush=True)
        records += kept[name]
    note = f"Measured on one core of {origin()}."
    put({"pareto-masses": f"{masses(records, problems)}\n{note}\n"})


def main():
    """Measure, and write pareto.json, the tables, the pictures and the page."""
    known = {problem.name: problem for problem in PROBLEMS}
    only = {"among": known, "metavar": "PROBLEM,..", "help": "the others stay"}
    words = "only lumped and averaged mass in the initial configuration"
    options = options_of("pareto", redraw="tables from what is there", only=only, masses=words)
    kept = Kept(out("pareto") / "pareto.json")
    if options.masses:
        some = [known[name] for name in options.only or known if known[name].initial]
        measure_masses(some, kept)
        return
    if not options.redraw:
        measure([known[name] for name in options.only or known], kept)
    report(kept, [p for p in PROBLEMS if p.name in kept["origins"]])
