"""study.csv and study.md: a row for every run."""

from __future__ import annotations

import csv
import datetime
import io
from collections.abc import Iterable, Iterator, Sequence

from pgimp.running.progress import duration
from pgimp.schema.instants import TimeMean
from pgimp.utilities.study.limits import Limit, limit
from pgimp.utilities.study.measure_entry import LIMIT, measure_of
from pgimp.utilities.study.measures import number, orders, pareto
from pgimp.utilities.study.plan import Plan
from pgimp.utilities.study.runs import DONE, FAILED, Outcome
from pgimp.utilities.study.schema import COSTS

_VERSIONS = ("pgimp", "numba", "numpy")


def compare(plan: Plan, outcomes: Sequence[Outcome]) -> None:
    """Set the observed orders along the curves, and the runs on a Pareto front."""
    if plan.study.measure.reference == LIMIT:
        _from_limits(plan, outcomes)
    done = [one for one in outcomes if one.state == DONE and one.error is not None]
    for runs in curves(done).values():
        points = [(one.plan.x, one.error or 0.0) for one in runs]
        for one, order in zip(runs, orders(points), strict=True):
            one.order = order
    for cost in plan.study.cost:
        for i in pareto([(one.costs[cost], one.error or 0.0) for one in done]):
            done[i].fronts.append(cost)


def _from_limits(plan: Plan, outcomes: Sequence[Outcome]) -> None:
    """Replace the values of the runs by differences from the limits of their curves."""
    done = [one for one in outcomes if one.state == DONE and one.value is not None]
    for runs in curves(done).values():
        found = limit([(one.plan.x, one.value or 0.0) for one in runs])
        for one in runs:
            one.error, value = None, one.value or 0.0
            if found is None:
                one.message = "the only one of its curve: there is no limit to compare with"
            elif not plan.study.measure.relative:
                one.error = abs(value - found.value)
            elif found.value != 0.0:
                one.error = abs(value / found.value - 1.0)
        if found is not None:
            runs[-1].message = verdict(plan, runs, found)


def verdict(plan: Plan, runs: Sequence[Outcome], found: Limit) -> str:
    """Describe the accuracy of a curve's finest run, the last one."""
    finest, label = runs[-1], plan.study.measure.label
    if len({one.value for one in runs}) == 1:
        return (
            f"{label} is {finest.value:.5g} in all runs, which says nothing of their errors: take "
            "a later time.end (set), by which there is something to compare, or another column"
        )
    part = "" if finest.error is None else f"{finest.error:.2g}"
    if plan.study.measure.relative and finest.error is not None:
        part = f"{100.0 * finest.error:.2g} %"
    text = f"{label} is {finest.value:.5g}, its limit about {found.value:.5g}"
    if found.order is None:
        return f"{text}: an error of {part} if the order is 1; the values do not tell the order"
    return f"{text}: an error of {part}, with the order {found.order:.1f}"


def curves(outcomes: Sequence[Outcome]) -> dict[str, list[Outcome]]:
    """Return the runs of each curve, the largest x first."""
    found: dict[str, list[Outcome]] = {}
    for one in outcomes:
        found.setdefault(one.plan.curve, []).append(one)
    return {curve: sorted(runs, key=lambda one: -one.plan.x) for curve, runs in found.items()}


def as_csv(plan: Plan, outcomes: Sequence[Outcome]) -> str:
    """Return study.csv: numbers with all digits, runs in the order of the sweep."""
    study = plan.study
    keys = list(dict.fromkeys(key for run in plan.runs for key in run.values))
    columns = list(dict.fromkeys(measure_of(entry).label for entry in study.columns))
    stream = io.StringIO()
    table = csv.writer(stream, lineterminator="\n")
    head = ["run", "state", "curve", *keys, f"x: {study.plot.x}", "error", "order", "ranks"]
    head += ["particles", *COSTS, *(f"front: {cost}" for cost in study.cost)]
    head += [f"history: {column}" for column in columns]
    table.writerow([*head, "reused", "message"])
    for one in outcomes:
        run, info = one.plan, one.info
        row: list[object] = [run.name, one.state, run.curve, *(run.values.get(key) for key in keys)]
        row += [run.x, one.error, one.order, info.get("ranks"), info.get("particles")]
        row += [one.costs.get(cost) for cost in COSTS]
        row += [int(cost in one.fronts) if one.state == DONE else None for cost in study.cost]
        row += [one.columns.get(column) for column in columns]
        table.writerow([*row, int(one.reused), one.message])
    return stream.getvalue()


def as_markdown(plan: Plan, outcomes: Sequence[Outcome]) -> str:
    """Return study.md: runs by curve from coarse to fine, remarks, machine and versions."""
    study = plan.study
    columns = list(dict.fromkeys(measure_of(entry).label for entry in study.columns))
    many = len({one.plan.curve for one in outcomes}) > 1
    extra = [cost for cost in study.cost if cost not in ("wall", "particle-steps", "steps")]
    head = [*(["curve"] if many else []), study.plot.x, "error", "order", "particles", "steps"]
    head += ["particle-steps", "wall time", *extra, "on the front of", *columns]
    lines = [f"# {study.title or plan.name}", "", row(head), "|---" * len(head) + "|"]
    for curve, runs in curves(outcomes).items():
        for one in runs:
            lines.append(row([*([curve] if many else []), *_cells(one, extra, columns)]))
    lines += ["", *_legend(plan), ""]
    notable = [one for one in outcomes if one.message or one.state != DONE]
    if notable:
        lines += [f"- {one.plan.name}: {one.state}; {one.message}".rstrip("; ") for one in notable]
        lines.append("")
    lines += [f"- {line}" for line in origin(outcomes)]
    return "\n".join(lines) + "\n"


def row(cells: Sequence[str]) -> str:
    """Return a row of a Markdown table."""
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _cells(one: Outcome, extra: Sequence[str], columns: Sequence[str]) -> Iterator[str]:
    yield number(one.plan.x, 6)
    yield one.state if one.error is None else number(one.error)
    yield "" if one.order is None else f"{one.order:.2f}"
    for key in ("particles", "steps"):
        yield f"{one.info[key]:,}" if one.costs else ""
    yield number(one.costs.get("particle-steps"))
    yield duration(one.costs["wall"]) if one.costs else ""
    for cost in extra:
        yield number(one.costs.get(cost))
    yield ", ".join(one.fronts)
    for column in columns:
        yield number(one.columns.get(column), 6)


def _legend(plan: Plan) -> Iterator[str]:
    quantity = plan.study.measure
    at = {"end": "at the end", "max": "at its largest"}.get(
        str(quantity.at), f"at t = {quantity.at}"
    )
    if isinstance(quantity.at, TimeMean):
        at = f"as a mean from t = {quantity.at.mean[0]:g} to {quantity.at.mean[1]:g}"
    less = f" less {quantity.reference!r}" if quantity.reference else ""
    over = ""
    if quantity.reference == LIMIT:
        less = " less what the curve tends to, extrapolated from its three least cells or two"
        over = ", over that" if quantity.relative else ""
    elif quantity.relative:
        over = f", over {abs(float(quantity.reference))!r}"
    yield (
        f"The error is the absolute value of `{quantity.column}`{less} in history.csv{over}, {at}. "
        f"The order is that of the error in "
        f"`{plan.study.plot.x}` since the line above it in the curve. Wall time is that of the "
        "steps, without set-up and output. On the front of a cost are the runs that no other one "
        "beats in both error and that cost."
    )


def origin(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Describe machine and versions of the runs, with lists where they differ."""
    done = [one.info for one in outcomes if one.info]
    if done:
        ranks = " or ".join(_unlike(info["ranks"] for info in done))
        yield f"Ranks: {ranks} on {'; '.join(_unlike(info['cpu'] for info in done))}"
        hosts = _unlike(", ".join(info["hosts"]) for info in done)
        systems = _unlike(info["versions"]["system"] for info in done)
        yield f"Hosts: {'; '.join(hosts)}; {'; '.join(systems)}"
        for name in _VERSIONS:
            yield f"{name}: {'; '.join(_unlike(info['versions'][name] for info in done))}"
        commits = _unlike(info["commit"] for info in done if info["commit"])
        if commits:
            yield f"Commit: {'; '.join(commits)}"
        began = sorted(info["began"][:10] for info in done)
        yield f"Runs of {began[0]}" + (f" to {began[-1]}" if began[-1] != began[0] else "")
    reused = sum(one.reused for one in outcomes)
    failed = sum(one.state == FAILED for one in outcomes)
    runs = f"{len(outcomes)} run{'s' if len(outcomes) > 1 else ''}"
    today = datetime.date.today().isoformat()
    yield f"Written {today}: {runs}, of which {reused} from before, {failed} failed"


def _unlike(values: Iterable[object]) -> list[str]:
    return [str(value) for value in dict.fromkeys(values)]
