"""study.csv and study.md of a bisection: a row for every run, and for every result."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from pgimp.running.progress import duration
from pgimp.utilities.study.bisect_entry import Bisection
from pgimp.utilities.study.bisection import UNSEEN, Bracket, result
from pgimp.utilities.study.measures import number
from pgimp.utilities.study.plan import Plan
from pgimp.utilities.study.tables import origin, row

_COSTS = ("particles", "steps", "ranks")


def as_csv(plan: Plan, brackets: Sequence[Bracket], entry: Bisection) -> str:
    """Return study.csv: every run, in the order of the runs."""
    stream = io.StringIO()
    table = csv.writer(stream, lineterminator="\n")
    head = ["run", "variant", f"x: {plan.study.plot.x}", entry.key, "state", "moved"]
    table.writerow([*head, *_COSTS, "wall", "reused", "message"])
    for bracket in brackets:
        for trial in bracket.trials:
            one = trial.outcome
            line = [one.plan.name, bracket.variant.name, bracket.variant.x, trial.value]
            line += [trial.state, one.moved, *(one.info.get(key) for key in _COSTS)]
            table.writerow([*line, one.costs.get("wall"), int(one.reused), one.message])
    return stream.getvalue()


def as_markdown(plan: Plan, brackets: Sequence[Bracket], entry: Bisection) -> str:
    """Return study.md: results, then their runs, machine and versions."""
    study = plan.study
    many = [[bracket.variant.name] if study.sweep else [] for bracket in brackets]
    first = ["variant"] if study.sweep else []
    head = [*first, study.plot.x, entry.key, "at rest with", "not with", "error", "particles"]
    head += ["runs", "steps", "wall time"]
    lines = [f"# {study.title or plan.name}", "", row(head), "|---" * len(head) + "|"]
    for name, bracket in zip(many, brackets, strict=True):
        lines.append(row([*name, *_cells(bracket, entry)]))
    known = "" if entry.reference is None else f", relative to {entry.reference!r}"
    lines += [
        "",
        f"`{entry.key}` is the middle of the last values with which the case came to rest, and did "
        f"not. The error is that of the middle{known}. Steps and wall time are those of all runs "
        f"of a result, without set-up and output. {_slide(brackets, entry)}",
        "",
        *(f"- {result(bracket, entry)}" for bracket in brackets),
        "",
        row(["run", "state", "greatest displacement", "steps", "wall time"]),
        "|---" * 5 + "|",
    ]
    outcomes = []
    for trial in (trial for bracket in brackets for trial in bracket.trials):
        one = trial.outcome
        outcomes.append(one)
        wall = duration(one.costs["wall"]) if one.costs else ""
        steps = f"{one.info['steps']:,}" if one.costs else ""
        lines.append(row([one.plan.name, trial.state, number(one.moved), steps, wall]))
    return "\n".join([*lines, "", *(f"- {line}" for line in origin(outcomes))]) + "\n"


def _slide(brackets: Sequence[Bracket], entry: Bisection) -> str:
    """Say what has slid, and where that is not looked for."""
    text = (
        "The greatest displacement of a particle is that in a stage that settles, of those that "
        "the key changes. "
    )
    if entry.failure_displacement is None:
        text += "Any counts as rest."
    else:
        most = (
            "a tenth of a cell's shortest edge"
            if entry.failure_displacement == "auto"
            else f"{entry.failure_displacement!r}"
        )
        text += f"Where it is above {most} the case has slid, which is not at rest."
    if any(bracket.variant.unseen for bracket in brackets):
        text += f" {UNSEEN[0].upper()}{UNSEEN[1:]}."
    return text


def _cells(bracket: Bracket, entry: Bisection) -> list[str]:
    done = [trial.outcome for trial in bracket.trials if trial.outcome.costs]
    error = bracket.error(entry)
    return [
        number(bracket.variant.x, 6),
        number(bracket.middle, 6),
        number(bracket.rests, 9),
        number(bracket.moves, 9),
        "" if error is None else f"{100.0 * error:.2g} %",
        f"{done[0].info['particles']:,}" if done else "",
        str(len(bracket.trials)),
        f"{sum(one.info['steps'] for one in done):,}",
        duration(sum(one.costs["wall"] for one in done)) if done else "",
    ]
