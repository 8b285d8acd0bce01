"""The tables of docs/error-against-cost.md: the fronts, and what an error costs by method."""

from studies.harness import table
from studies.pareto.front import front, price, usable

#: Prices up to so many times the least are those of good methods.
GOOD = 1.5
#: Runs of a front are told if their error is less than this part of the one before.
LESS = 0.8


def seconds(value):
    if value < 0.0995:
        return f"{1e3 * value:.2g} ms"
    return f"{value:.0f} s" if value >= 9.95 else f"{value:.2g} s"


def percent(value):
    return f"{100.0 * value:.2g} %" if value < 0.995 else f"{100.0 * value:.0f} %"


def by_method(records, problem):
    """The runs of a problem by method, coarsest first."""
    ladders = {}
    for record in records:
        if record["problem"] == problem.name:
            ladders.setdefault(record["method"], []).append(record)
    return {name: sorted(runs, key=lambda r: r["n"]) for name, runs in ladders.items()}


def fronts(records, problems):
    """A line a problem: who is on the front of pgimp, from cheap to accurate, and the peer."""
    lines = []
    for problem in problems:
        mine = [r for r in records if r["problem"] == problem.name]
        best = front([r for r in mine if not r.get("peer")])
        told = []
        for run in best:
            if not told or run["error"] < LESS * told[-1]["error"]:
                told.append(run)
        shown = "; ".join(_run(run, run["method"] + ", ") for run in told)
        peers = [r for r in mine if r.get("peer") and "float32" not in r["method"]]
        other = "; ".join(_run(r) for r in peers) or "cannot: bodies on one grid stick"
        lines.append((problem.title, shown, other))
    titles = "problem", "front of pgimp: method, cells, error, CPU time", "Taichi's MLS-MPM"
    return table(titles, lines)


def _run(record, before=""):
    if not usable(record):
        return f"{before}{record['n']}: useless"
    return f"{before}{record['n']}: {percent(record['error'])} in {seconds(record['seconds'])}"


def prices(records, problems):
    """What the target of every problem costs with every method; those near the least are bold."""
    ladders = {problem.name: by_method(records, problem) for problem in problems}
    names = list(dict.fromkeys(r["method"] for r in records))
    names.sort(key=lambda name: name.startswith("Taichi"))  # stable: they come last
    lines, least = [], {}
    for p in problems:
        costs = [price(runs, p.target) for runs in ladders[p.name].values()]
        least[p.name] = min(filter(None, costs), default=None)
    for name in names:
        cells = [_price(p, ladders[p.name].get(name), least[p.name]) for p in problems]
        lines.append((name, *cells))
    heads = [f"{p.title}, {100.0 * p.target:g} %" for p in problems]
    return table(("method", *heads), lines)


def _price(problem, runs, least):
    """Cell of a method: what the target costs, else in brackets the least error, or what failed."""
    if runs is None:
        return ""
    cost = price(runs, problem.target)
    if cost is not None:
        return f"**{seconds(cost)}**" if cost <= GOOD * least else seconds(cost)
    stopped = runs[-1]["error"] is None
    errors = [r["error"] for r in runs if usable(r)]
    if not errors:
        return "stopped" if stopped else "useless"
    return f"({percent(min(errors))}{', then stopped' * stopped})"


def masses(records, problems):
    """A line a problem: with each method the price of its target, and the error on fine cells."""
    names = list(dict.fromkeys(r["method"] for r in records))
    lines = []
    for p in problems:
        ladders = by_method(records, p)
        cells = [f"{_price(p, ladders[name], 0.0)}; {_run(ladders[name][-1])}" for name in names]
        lines.append((f"{p.title}, {100.0 * p.target:g} %", *cells))
    return table(("problem and its error", *names), lines)
