"""Sections of a run's report that are tables: accuracy, books, forces, timings."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.running.accuracy.books import EnergyBook, MomentumBook
from pgimp.running.accuracy.rules import Indicator
from pgimp.running.progress import duration
from pgimp.schema.pages import page
from pgimp.utilities.plot.runs import PlotRun
from pgimp.utilities.report.html import Markup, items, join, paragraph, table

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Decades of the bars on either side of the bound, and their size in pixels.
_DECADES, _WIDTH, _HEIGHT = 2.0, 90, 10
#: The last part of the time over which mean forces are taken.
_TENTH = 0.1
#: Ranks with a column of their own.
_MOST_RANKS = 8


def accuracy_table(found: Sequence[Indicator], case: Case | None = None) -> Markup:
    """Return the indicators, the worst first, and what lowers errors of those outside limits.

    Parameters
    ----------
    found : sequence of Indicator
        The indicators.
    case : Case, optional
        The case, which may do already what would help others.
    """
    ranked = sorted(found, key=lambda one: (one.well, -one.distance))
    rows = [
        (
            _name(one),
            Markup(f'<span class="beyond">{_value(one)}</span>') if not one.well else _value(one),
            f"{'from' if one.rule.least else 'up to'} {one.rule.number(one.rule.bound)}",
            bar(one.distance),
        )
        for one in ranked
    ]
    if not rows:
        return paragraph("Nothing is known of the errors of this run.")
    wrong = [one for one in ranked if not one.well]
    said = (
        f"{len(wrong)} of {len(found)} indicators are outside their limits."
        if wrong
        else f"All {len(found)} indicators are within their limits."
    )
    note = (
        "A bar ends at the middle line where a value is at its bound; on either side it spans two "
        "powers of ten. The bounds and their reasons are in "
        f"{page('report.md')}."
    )
    remedies = {
        one.rule.label: f"{one.rule.label}: {one.rule.remedies(case)} ({page(one.rule.page)})"
        for one in wrong
    }
    head = ("indicator", "value", "limit", "distance")
    return join(
        [
            paragraph(said),
            table(head, rows, words=4),
            paragraph("What lowers the errors:") if remedies else "",
            items(remedies.values()),
            paragraph(note),
        ]
    )


def _name(one: Indicator) -> str:
    return one.rule.label + (f" '{one.where}'" if one.where else "")


def _value(one: Indicator) -> str:
    return one.rule.number(one.value)


def bar(distance: float) -> Markup:
    """Return a bar for a value over its bound, on a logarithmic scale with the bound in the middle.

    Parameters
    ----------
    distance : float
        Value over bound.
    """
    part = math.log10(max(distance, 1e-12)) / _DECADES if distance > 0.0 else -1.0
    end = round(0.5 * _WIDTH * (1.0 + min(max(part, -1.0), 1.0)), 1)
    colour = "#a32a00" if distance > 1.0 + 1e-9 else "#00684c"
    middle = 0.5 * _WIDTH
    return Markup(
        f'<svg class="bar" width="{_WIDTH}" height="{_HEIGHT}" role="img" '
        f'aria-label="{min(distance, 9999.0):.2g} of the bound">'
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#eceff3"/>'
        f'<rect width="{max(end, 1.0)}" height="{_HEIGHT}" fill="{colour}"/>'
        f'<line x1="{middle}" x2="{middle}" y2="{_HEIGHT}" stroke="#1a1a1a"/></svg>'
    )


def energy_table(book: EnergyBook, shown: PlotRun) -> Markup:
    """Return the book of energy at the last line of the history."""
    kind = shown.unit("energy")
    rows: list[tuple[object, ...]] = []
    for name, entries in (("given", book.given), ("there", book.stored), ("taken", book.taken)):
        for entry in entries:
            value = float(entry.values[-1])
            rows.append((name, entry.name, number(value), percent(value / book.scale)))
    least = float(np.nanmin(book.lost))
    note = (
        f"At the last line of the history{units(kind)}. Per cent are of the greatest energy that "
        "was there or given. What the method lost closes the balance, so that given = there + "
        "taken; artificial viscosity is a part of it."
    )
    if least < 0.0:
        note += f" The most that had come from nothing at a time is {percent(-least)}."
    return join([table(("", "", "energy", "of all"), rows, words=2), paragraph(note)])


def momentum_table(books: Sequence[MomentumBook], why: str, shown: PlotRun) -> Markup:
    """Return the books of momentum over the whole run, a column for each axis."""
    if not books:
        return paragraph(f"There is no balance of momentum: {why}.")
    names = list(dict.fromkeys(name for book in books for name, _ in book.impulses))
    values = [dict(book.impulses) for book in books]
    rows: list[tuple[object, ...]] = [
        (name, *(number(one.get(name, 0.0)) for one in values))
        for name in names
        if any(one.get(name) for one in values)
    ]
    rows += [
        ("change of the momentum", *(number(book.change) for book in books)),
        ("not explained", *(number(book.rest) for book in books)),
    ]
    head = ("impulse on the material", *(book.axis for book in books))
    scale = max(book.scale for book in books)
    rest = max(abs(book.rest) for book in books) / scale if scale > 0.0 else 0.0
    kind = shown.unit("mass length/time")
    note = (
        f"Over the whole run{units(kind)}. What forces do not explain is {rest:.1e} of their "
        "impulses and the greatest momentum of the motion."
    )
    return join([table(head, rows, sums=2), paragraph(note)])


def force_table(history: np.ndarray, columns: Sequence[str], shown: PlotRun) -> Markup:
    """Return forces: at the end, their mean over the last tenth of the time, the greatest."""
    if not columns or len(history) < 2:
        return Markup()
    times = np.asarray(history["time"], float)
    late = times > times[-1] - _TENTH * (times[-1] - times[0])
    late[0] = False
    spans = np.diff(times, prepend=times[0])
    rows = []
    for name in columns:
        values = np.nan_to_num(np.asarray(history[name], float))
        most = int(np.abs(values).argmax())
        weights = spans[late]
        mean = float(values[late] @ weights / weights.sum()) if weights.sum() > 0.0 else values[-1]
        at = f"{times[most]:.4g}"
        rows.append((name, number(values[-1]), number(mean), number(values[most]), at))
    kind = shown.unit("force")
    head = ("force", "in the end", "mean of the last tenth", "greatest", "at t")
    note = (
        f"Of the face, constraint or rigid body, as in history.csv{units(kind)}: means since the "
        "line before."
    )
    return join([table(head, rows), paragraph(note)])


def error_table(history: np.ndarray) -> Markup:
    """Return the errors against the exact solution: in the end, and the greatest."""
    rows = []
    for name in history.dtype.names or ():
        values = np.asarray(history[name], float)
        if re.fullmatch(r"error(\..*)?", name) and np.isfinite(values).any():
            most = int(np.nanargmax(values))
            rows.append(
                (name, number(values[-1]), number(values[most]), f"{history['time'][most]:.4g}")
            )
    if not rows:
        return Markup()
    note = "The reference of cases says what each column is; orders are what a study shows."
    return join([table(("error", "in the end", "greatest", "at t"), rows), paragraph(note)])


def timing_table(timings: Mapping[str, Any], total: float) -> Markup:
    """Return the seconds of each phase: of each rank of few, else least, mean and greatest."""
    sound = {
        str(phase): [float(value) for value in values]
        for phase, values in timings.items()
        if isinstance(values, list) and values
    }
    ranks = max((len(values) for values in sound.values()), default=0)
    if not ranks:
        return Markup()
    spent = [sum(values[r] for values in sound.values() if r < len(values)) for r in range(ranks)]
    sound["other"] = [max(total - each, 0.0) for each in spent]
    whole = max(total * ranks, 1e-12)
    if 1 < ranks <= _MOST_RANKS:
        head = ["phase", "share", *(f"rank {rank}" for rank in range(ranks))]
    else:
        head = ["phase", "share", *(("least", "mean", "greatest") if ranks > 1 else ("seconds",))]
    rows = []
    for phase, values in sound.items():
        part = [*_spread(values, ranks)]
        rows.append((phase, percent(sum(values) / whole), *(f"{value:.3g}" for value in part)))
    rows.append(("total", percent(1.0), *([f"{total:.3g}"] * (len(head) - 2))))
    note = f"Seconds of wall time, of {duration(total)} in all with output, without set-up."
    return join([table(head, rows, sums=1), paragraph(note)])


def _spread(values: Sequence[float], ranks: int) -> Iterator[float]:
    if ranks <= _MOST_RANKS:
        yield from values
    else:
        yield from (min(values), sum(values) / len(values), max(values))


def number(value: float) -> str:
    """Return a number with four digits; 0 for zero."""
    return "0" if value == 0.0 else f"{value:.4g}"


def percent(part: float) -> str:
    """Return a fraction in per cent."""
    return f"{100.0 * part:.2g} %" if abs(part) < 0.995 else f"{100.0 * part:.0f} %"


def units(kind: str) -> str:
    """Return a unit in words behind a quantity; empty without one."""
    plain = re.sub(r"\$\^(\d)\$", r"^\1", kind).replace(" / ", "/")
    return f", in {plain}" if plain else ""
