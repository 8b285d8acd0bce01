"""Runs of a problem with a method: its error, and the CPU time of its steps alone."""

from math import sqrt
from statistics import mean, median
from time import process_time

from pgimp.errors import RunError

#: Runs that take less are done so often.
SHORT, ROUNDS = 0.2, 3


def once(problem, method, n, steps=None):
    """Run a problem, or so many steps of it: its error, None if it fails, and its CPU time."""
    sim, X = problem.begin(method, n)
    spent = 0.0
    try:
        while not sim.finished and sim.step != steps:
            began = process_time()
            sim.advance()
            spent += process_time() - began
            problem.step(sim)
    except RunError as fault:
        return {"error": None, "seconds": spent, "steps": sim.step, "fault": str(fault)[:80]}
    return {
        "error": problem.found(sim, X, n), "seconds": spent, "steps": sim.step,
        "particles": sim.count,
    }  # fmt: skip


def ladder(problem, methods, sizes):
    """A record of every method and size; short runs thrice by turns, the median of their times."""
    for method in methods:
        once(problem, method, problem.quick, 3)  # compiles, or loads the kernels
    records = []
    for n in sizes:
        found = {(method, off): [] for method in methods for off in problem.places}
        for _ in range(ROUNDS):
            for (method, problem.off), runs in found.items():
                if not runs or runs[0]["seconds"] < SHORT:
                    runs.append(once(problem, method, n))
        for method in methods:
            key = {"problem": problem.name, "method": method.label, "n": n}
            records.append(key | joined({off: found[method, off] for off in problem.places}))
    return records


def joined(runs):
    """A record of the repeated runs by place: the root mean square error, the mean time."""
    errors = {off: each[0]["error"] for off, each in runs.items()}
    failed = None in errors.values()
    first = next(iter(runs.values()))[0]
    return first | {
        "error": None if failed else sqrt(mean(e * e for e in errors.values())),
        "errors": errors,
        "seconds": mean(median(run["seconds"] for run in each) for each in runs.values()),
    }
