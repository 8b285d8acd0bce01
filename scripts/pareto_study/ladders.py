"""Runs of a problem with a method: its error, and the CPU time of its steps alone."""

from statistics import median
from time import process_time

from pgimp.errors import RunError

SHORT, ROUNDS = 0.3, 3


def once(problem, method, n, steps=None):
    """Error, None if the run fails or is worth nothing, CPU seconds of the steps, and their number.

    With `steps` only so many are done.
    """
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
    error = problem.found(sim, X, n)
    return {"error": error, "seconds": spent, "steps": sim.step, "particles": sim.count}


def ladder(problem, methods, sizes):
    """A record of every method and size; short runs thrice by turns, the median of their times."""
    for method in methods:
        once(problem, method, problem.quick, 3)  # compiles, or loads the kernels
    records = []
    for n in sizes:
        found = {method: [once(problem, method, n)] for method in methods}
        for _ in range(ROUNDS - 1):
            for method, runs in found.items():
                if runs[0]["seconds"] < SHORT:
                    runs.append(once(problem, method, n))
        for method, runs in found.items():
            record = {"problem": problem.name, "method": method.label, "n": n} | runs[0]
            record["seconds"] = median(run["seconds"] for run in runs)
            records.append(record)
    return records
