"""The section of a run's report on estimated errors, from its companions."""

from __future__ import annotations

from math import isfinite

from pgimp.errors import PgimpError
from pgimp.utilities.accuracy.found import Companions, Line, tells, with_error
from pgimp.utilities.accuracy.quantity import of_run
from pgimp.utilities.plot.runs import PlotRun
from pgimp.utilities.report.html import Markup, paragraph, table

#: Rows of the table; errors.csv has all quantities.
_MOST = 24


def estimated(shown: PlotRun) -> list[Markup]:
    """Return the section: the quantity that the case asks for, and the most telling others."""
    try:
        known = Companions(shown.path)
        lines = list(known.lines())
        if not lines:
            return []
        made = [paragraph(asked)] if (asked := of_run(known, shown.run.case)) else []
    except PgimpError as error:
        return [paragraph(str(error), "alarm")]
    probes = [line for line in lines if line.quantity.startswith("probe.") and line.greatest]
    rows = [_row(line) for line in [*(x for x in lines if tells(x, lines)), *probes]]
    head = ("quantity", "in the end", "greatest", "of it", "order")
    note = (
        "Errors are estimated from runs on cells "
        f"{' and '.join(f'{ratio:.3g}' for ratio, _ in known.runs[:2])} times as long, in coarse/. "
        "Where two runs tell no order it is taken as 1. Bands around curves are such errors. "
        f"errors.csv has all {len(lines)} quantities."
    )
    return [*made, table(head, list(dict.fromkeys(rows))[:_MOST]), paragraph(note)]


def _row(line: Line) -> tuple[str, ...]:
    return (
        line.quantity,
        with_error(line.last, line.last_error),
        with_error(line.greatest, line.greatest_error),
        _percent(line.part),
        f"{line.order:.2g}" if isfinite(line.order) else "1 (taken)",
    )


def _percent(part: float) -> str:
    return f"{100.0 * part:.2g} %" if isfinite(part) else ""
