"""study.png: the error against the refined quantity, and against each measure of cost."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pgimp.utilities.plot.style import COLOURS, MARKERS, STYLE, log_ticks, plain
from pgimp.utilities.study.measures import pareto
from pgimp.utilities.study.plan import Plan
from pgimp.utilities.study.runs import DONE, Outcome
from pgimp.utilities.study.tables import curves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

_LABELS = {"wall": "wall time [s]", "core": "wall time x ranks [s]"}
_INCHES = (4.2, 4.2)
_COLUMNS_OF_LEGEND = 6
# Fractions of a panel beyond which an order's label is to the left of its point, and below it.
_RIGHT, _TOP = 0.8, 0.92


def picture(plan: Plan, outcomes: Sequence[Outcome]) -> bytes | None:
    """Draw the panels.

    Parameters
    ----------
    plan : Plan
        The study.
    outcomes : sequence of Outcome
        Its runs. Runs without a result, or without a positive error for the logarithmic axis, are
        counted in the title.

    Returns
    -------
    bytes or None
        A PNG; None if there is nothing to draw.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    costs = plan.study.cost
    drawn = [
        one
        for one in outcomes
        if one.state == DONE
        and (one.error or 0.0) > 0.0
        and min(one.plan.x, *(one.costs[cost] for cost in costs)) > 0.0
    ]
    if not drawn:
        return None
    style: Any = STYLE
    with rc_context(style):
        count = 1 + len(costs)
        figure = Figure(figsize=(_INCHES[0] * count, _INCHES[1]))
        axes: Any = figure.subplots(1, count, sharey=True, squeeze=False)[0]
        for ax in axes:
            ax.set(xscale="log", yscale="log")
        label = plan.study.measure.label
        axes[0].set(
            xlabel=plain(plan.study.plot.x),
            ylabel=plain(label if label == "error" else f"error: {label}"),
        )
        for number, (curve, runs) in enumerate(curves(drawn).items()):
            line = {
                "color": COLOURS[number % len(COLOURS)],
                "marker": MARKERS[(number + number // len(COLOURS)) % len(MARKERS)],
                "label": plain(curve or plan.name),
                "ms": 5,
                "lw": 1.2,
            }
            errors = [one.error for one in runs]
            axes[0].plot([one.plan.x for one in runs], errors, **line)
            for ax, cost in zip(axes[1:], costs, strict=True):
                ax.plot([one.costs[cost] for one in runs], errors, **line | {"lw": 0.6})
        handles, labels = axes[0].get_legend_handles_labels()
        _guides(axes[0], drawn)
        for ax, cost in zip(axes[1:], costs, strict=True):
            ax.set_xlabel(_LABELS.get(cost, cost))
            front = _front(ax, [(one.costs[cost], one.error or 0.0) for one in drawn])
        figure.legend(
            [*handles, front],
            [*labels, "Pareto front"],
            loc="outside upper center",
            ncol=min(len(labels) + 1, _COLUMNS_OF_LEGEND),
            fontsize=9,
        )
        for ax in axes:
            log_ticks(ax.xaxis)
        log_ticks(axes[0].yaxis)
        left_out = len(outcomes) - len(drawn)
        if left_out:
            figure.supxlabel(f"{left_out} of {len(outcomes)} runs have no point", fontsize=8)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=110)
    return stream.getvalue()


def _guides(ax: Axes, drawn: Sequence[Outcome]) -> None:
    """Draw lines of first and second order from the coarsest run with the least error."""
    xs = sorted({one.plan.x for one in drawn})
    if len(xs) < 2:
        return
    low, high = xs[0], xs[-1]
    error = min(one.error or 0.0 for one in drawn if one.plan.x == high)
    limits = ax.get_ylim()
    for order, dashes in ((1, (0, (5, 3))), (2, (0, (1, 2)))):
        end = error * (low / high) ** order
        ax.plot([high, low], [error, end], color="#555555", lw=0.9, ls=dashes, zorder=1)
        inside = max(end, limits[0])
        at = high * (inside / error) ** (1.0 / order)
        right, up = (ax.transScale + ax.transLimits).transform((at, inside))
        ax.annotate(
            f"order {order}",
            (at, inside),
            xytext=(-3 if right > _RIGHT else 3, -4 if up > _TOP else 4),
            textcoords="offset points",
            ha="right" if right > _RIGHT else "left",
            va="top" if up > _TOP else "bottom",
            fontsize=8,
            color="#555555",
            bbox={"color": "white", "alpha": 0.7, "pad": 0.5},
        )
    ax.set_ylim(limits)


def _front(ax: Axes, points: Sequence[tuple[float, float]]) -> Line2D:
    """Draw the Pareto front as a stepped line to the panel's edges, and return it."""
    front = [points[i] for i in pareto(points)]
    limits = ax.get_xlim(), ax.get_ylim()
    (far, high), (_, low) = (limits[0][1], limits[1][1]), front[-1]
    xs = [front[0][0], *(cost for cost, _ in front), far]
    ys = [high, *(error for _, error in front), low]
    (line,) = ax.plot(xs, ys, drawstyle="steps-post", color="black", lw=1.4, alpha=0.55, zorder=1)
    ax.set(xlim=limits[0], ylim=limits[1])
    return line
