"""The report of a run: sections from its directory, also while it goes on or after a failure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.errors import PgimpError
from pgimp.io.results.history import read_sums
from pgimp.io.rundir import runinfo
from pgimp.running.accuracy.books import edited_functions, energy_book, momentum_books
from pgimp.running.accuracy.find import of_run
from pgimp.running.accuracy.rules import Indicator
from pgimp.running.progress import duration
from pgimp.utilities.plot.runs import PlotRun
from pgimp.utilities.report import citation, drawings, errors, origin, parts
from pgimp.utilities.report.html import (
    Markup,
    block,
    contents,
    facts,
    items,
    join,
    page,
    paragraph,
    section,
    table,
    text,
)

if TYPE_CHECKING:
    from pgimp.case.schema import Case

_CITE = (
    "Cite the program with its version, and the paper of the method; the material models and "
    "features that you used have their sources in the pages of pgimp."
)


def report_of_run(path: Path, field: str | None = None) -> str:
    """Return the page of a run.

    Parameters
    ----------
    path : Path
        The run directory.
    field : str, optional
        The quantity of the pictures, as for ``pgimp plot --field``.

    Raises
    ------
    UsageError
        If there is no run, or no such field.
    """
    shown = PlotRun(path, path.resolve().name.removesuffix(".out") or str(path))
    found = _Found(shown)
    info, data = found.info, found.data
    title = str(data.get("title") or shown.name)
    made = [
        section("Failure", *_failure(path, info)),
        section("Accuracy", found.problem, parts.accuracy_table(found.indicators, found.case)),
        section("Estimated errors", *errors.estimated(shown)),
        section("Error against the exact solution", *_errors(shown, found.history)),
        section("Pictures", drawings.pictures(shown, field)),
        section("History", *_curves(shown, found.history)),
        section("Balances", *_books(shown, found)),
        section("Forces", *_forces(shown, found.history)),
        section("Time by phase", *_timings(info)),
        section("Method as chosen", origin.chosen(path)),
        section("Warnings and notes", origin.told(path)),
        section("Case", *_case(path, data)),
        section("Machine and versions", origin.machine(info), found.starts),
        section("How to cite", *how_to_cite(info)),
    ]
    titles = [one.partition("<h2>")[2].partition("</h2>")[0] for one in made if one]
    return page(
        title,
        Markup(f"<h1>{text(title)}</h1>"),
        paragraph(f"{path.resolve().name}: a run of pgimp, begun {info['began']}", "sub"),
        paragraph(origin.state_of(info, _end(data))),
        contents(titles),
        facts(_glance(info, found)),
        *made,
        footer(),
    )


def footer() -> Markup:
    """Return the last line of a report."""
    version = runinfo.installed("pgimp") or ""
    return Markup(f"<footer>Written {runinfo.now()} by pgimp {version}.</footer>")


class _Found:
    """What is known of a run; what cannot be read is said, and the rest stands."""

    def __init__(self, shown: PlotRun) -> None:
        self.info: dict[str, Any] = shown.run.info
        self.starts = origin.starts_table(origin.starts_of(shown.path))
        self.indicators: list[Indicator] = []
        self.case: Case | None = None
        self.data: dict[str, Any] = {}
        self.history = np.zeros(0)
        problems: list[str] = []
        try:
            self.data = shown.case
            self.case = shown.run.case
        except PgimpError as error:
            problems.append(str(error))
        try:
            dimensions = self.case.dimensions if self.case else 1
            self.history = read_sums(shown.path / "history.csv", dimensions)
            if self.case:
                self.indicators = of_run(shown.run, self.case)
        except PgimpError as error:
            problems.append(str(error))
        self.problem = join(paragraph(text, "alarm") for text in problems)


def _end(data: dict[str, Any]) -> float | None:
    """End of the last stage of a case."""
    time = data.get("time")
    if not isinstance(time, dict):
        return None
    ends = [time.get("end"), *(one.get("end") for one in time.get("stages") or ())]
    known = [float(end) for end in ends if isinstance(end, float | int)]
    return max(known, default=None)


def _glance(info: dict[str, Any], found: _Found) -> list[tuple[object, object]]:
    data = found.data
    grid, method = data.get("grid") or {}, data.get("method") or {}
    cells = " x ".join(
        str(round(size / cell))
        for size, cell in zip(grid.get("size", ()), grid.get("cell", ()), strict=False)
    )
    seconds = info.get("total_seconds") or info.get("seconds")
    wrong = [one for one in found.indicators if not one.well]
    accuracy: object = ""
    if found.indicators:
        accuracy = "all indicators within limits"
    if wrong:
        names = dict.fromkeys(one.rule.label for one in wrong)
        accuracy = Markup(f'<span class="beyond">{text("; ".join(names))}</span>')
    return [
        ("simulated time", f"{info.get('time') or 0.0:.6g} in {info['steps']:,} steps"),
        ("particles", f"{info.get('particles') or 0:,}"),
        ("cells", f"{cells} in {data.get('dimensions', '?')}D" if cells else ""),
        ("method", ", ".join(_method(method))),
        ("ranks", info.get("ranks", "")),
        ("wall time", "" if not seconds else f"{duration(float(seconds))} without set-up"),
        ("speed", origin.speed(info, found.indicators)),
        ("outside limits" if wrong else "accuracy", accuracy),
    ]


def _method(method: dict[str, Any]) -> list[str]:
    """Return the method's keys in words."""
    each = method.get("particles-per-cell") or ()
    words = [str(method.get("shape", ""))]
    words += [f"{' x '.join(str(n) for n in each)} particles a cell"] if each else []
    words += ["affine"] if method.get("affine") else []
    words += ["B-bar"] if method.get("volumetric") == "b-bar" else []
    return [word for word in words if word]


def _failure(path: Path, info: dict[str, Any]) -> list[Markup]:
    message, particles = origin.failure(path, info)
    if not message:
        return []
    parts_: list[Markup] = [Markup(f'<div class="alarm">{block(message)}</div>')]
    if particles and not message.startswith("stopped"):
        parts_ += [paragraph("What failure/report.txt says of it:"), block(particles)]
    return parts_


def _errors(shown: PlotRun, history: np.ndarray) -> list[Markup]:
    names = [name for name in history.dtype.names or () if name.startswith("error")]
    if not names or not len(history):
        return []
    return [
        parts.error_table(history),
        drawings.history_figure(shown, names[:1], "Error of the stress over time"),
    ]


def _curves(shown: PlotRun, history: np.ndarray) -> list[Markup]:
    if not len(history):
        return [paragraph("history.csv has no line.")]
    columns = drawings.energies(history)
    made = [drawings.history_figure(shown, columns, "Energies and works over time")]
    moved = drawings.motions(history)
    if moved:
        made.append(drawings.history_figure(shown, moved, "Prescribed and rigid motion over time"))
    return made


def _books(shown: PlotRun, found: _Found) -> list[Markup]:
    made: list[Markup] = []
    if book := energy_book(found.history):
        made += [Markup("<h3>Energy</h3>"), parts.energy_table(book, shown)]
    if found.case is not None and len(found.history):
        edited = edited_functions(shown.run.starts)
        books, why = momentum_books(found.case, found.history, edited)
        made += [Markup("<h3>Momentum</h3>"), parts.momentum_table(books, why, shown)]
    return made


def _forces(shown: PlotRun, history: np.ndarray) -> list[Markup]:
    columns = drawings.forces(history)
    if not columns:
        return []
    return [
        drawings.history_figure(shown, columns, "The greatest forces over time"),
        parts.force_table(history, columns, shown),
    ]


def _timings(info: dict[str, Any]) -> list[Markup]:
    timings, total = info.get("timings"), info.get("total_seconds")
    if isinstance(timings, dict) and isinstance(total, float | int):
        return [parts.timing_table(timings, float(total))]
    return []


def _case(path: Path, data: dict[str, Any]) -> list[Markup]:
    bodies = data.get("bodies") if isinstance(data.get("bodies"), dict) else {}
    materials = data.get("materials") if isinstance(data.get("materials"), dict) else {}
    rows = []
    for name, body in (bodies or {}).items():
        material = body.get("material") if isinstance(body, dict) else None
        entry = (materials or {}).get(material) or {}
        model = entry.get("model", "rigid") if isinstance(entry, dict) else ""
        rows.append((name, material or "", model, body.get("formulation", "")))
    stages = (data.get("time") or {}).get("stages") or ()
    named = [
        f"{one.get('name')}, "
        + ("to rest" if one.get("equilibrate") is not None else f"to t = {one.get('end')}")
        for one in stages
    ]
    given = origin.file_text(path / "input.yaml")
    resolved = origin.file_text(path / "case.yaml")
    made: list[Markup] = [table(("body", "material", "model", "formulation"), rows, words=4)]
    if named:
        made += [paragraph("Stages after the first:"), items(named)]
    if given:
        made += [paragraph("As it was given (input.yaml):"), block(given)]
    if resolved:
        about = "with every default written out (case.yaml)"
        made.append(
            Markup(
                f'<details class="screen"><summary>The case {about}</summary>\n'
                f"{block(resolved)}</details>"
            )
        )
    return made


def how_to_cite(info: dict[str, Any]) -> list[Markup]:
    """Return the citations of a program's version and of the paper."""
    versions = info.get("versions")
    version = str((versions or {}).get("pgimp") or runinfo.installed("pgimp") or "")
    return [
        paragraph(_CITE),
        items([citation.software(version, str(info.get("commit") or "")), citation.paper()]),
        block(citation.bibtex(version)),
    ]
