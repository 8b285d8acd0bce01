"""The report of a study: its page, its figure, and what its runs show of their accuracy."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from math import ceil
from pathlib import Path
from typing import Any

from pgimp.errors import PgimpError
from pgimp.io.results.reader import Run
from pgimp.io.rundir.ownfiles import REPORT, RUN
from pgimp.running.accuracy.find import of_run
from pgimp.running.accuracy.rules import Indicator, line
from pgimp.storage.plain import read_plain
from pgimp.utilities.plot.runs import PlotRun
from pgimp.utilities.report import drawings, origin
from pgimp.utilities.report.html import (
    Markup,
    block,
    contents,
    figure,
    image,
    join,
    page,
    paragraph,
    section,
    table,
    text,
)
from pgimp.utilities.report.markdown import to_html
from pgimp.utilities.report.run import footer, how_to_cite

TABLE = "study.csv"
_PAGE, _PICTURE, _COPY = "study.md", "study.png", "study.yaml"
_LARGEST = 16 << 20
#: Runs of which a picture is shown, evenly chosen.
_MOST_PICTURES = 8


def report_of_study(folder: Path, field: str | None = None) -> str:
    """Return the page of a study, from its folder.

    Parameters
    ----------
    folder : Path
        The study's folder, with study.md and its runs.
    field : str, optional
        The quantity of the pictures, as for ``pgimp plot --field``.
    """
    title, results = to_html(_text(folder / _PAGE))
    title = title or folder.resolve().name
    runs = [*_runs(folder)]
    last: dict[str, Any] = next((info for _, info, _ in reversed(runs) if info), {})
    picture = _picture(folder / _PICTURE)
    given = _text(folder / _COPY)
    made = [
        section("Results", figure(picture, "Error against cells and cost"), *results),
        section("Runs", _table(folder, runs)),
        section("Last frames", *_pictures(folder, [name for name, info, _ in runs if info], field)),
        section("Study", block(given) if given else ""),
        section("Machine and versions", origin.machine(last) if last else ""),
        section("How to cite", *how_to_cite(last)),
    ]
    titles = [one.partition("<h2>")[2].partition("</h2>")[0] for one in made if one]
    done = sum(info.get("state") == "done" for _, info, _ in runs)
    return page(
        title,
        Markup(f"<h1>{text(title)}</h1>"),
        paragraph(f"{folder.resolve().name}: a study of pgimp", "sub"),
        paragraph(f"{done} of {len(runs)} runs are done."),
        contents(titles),
        *made,
        footer(),
    )


def _errors(folder: Path) -> dict[str, str]:
    """Return the error of each run in study.csv, by name; empty text where there is none."""
    entries = csv.DictReader(_text(folder / TABLE).splitlines())
    return {entry["run"]: entry.get("error") or "" for entry in entries if entry.get("run")}


def _runs(folder: Path) -> Iterator[tuple[str, dict[str, Any], list[Indicator]]]:
    """Yield name, last start and indicators of each run; those are empty where there is none."""
    for name in _errors(folder):
        starts = origin.starts_of(folder / "runs" / name)
        found: list[Indicator] = []
        if starts and starts[-1]["state"] == "done":
            try:
                found = of_run(Run(folder / "runs" / name))
            except PgimpError:
                found = []
        yield name, starts[-1] if starts else {}, found


def _table(folder: Path, runs: list[tuple[str, dict[str, Any], list[Indicator]]]) -> Markup:
    rows, errors = [], _errors(folder)
    for name, info, found in runs:
        own = folder / "runs" / name / REPORT
        shown: object = text(name)
        if own.is_file():
            shown = Markup(f'<a href="runs/{text(name)}/{REPORT}">{text(name)}</a>')
        state = str(info.get("state", "not run"))
        if info.get("state") == "failed":
            state = f"failed: {str(info.get('message')).splitlines()[0]}"
        wrong = line(found)
        well = "all indicators within limits" if found else ""
        try:
            error = f"an error of {float(errors[name]):.3g}"
        except ValueError:
            error = ""
        speed = origin.speed(info, found, error) if info else ""
        rows.append((shown, state, speed, wrong or well))
    return table(("run", "state", "speed and error", "accuracy"), rows, words=4)


def _pictures(folder: Path, names: list[str], field: str | None) -> Iterator[Markup]:
    """Yield a heading and the last frame of some of the runs."""
    for name in names[:: max(1, ceil(len(names) / _MOST_PICTURES))]:
        if not (folder / "runs" / name / RUN).is_file():
            continue
        try:
            shown = PlotRun(folder / "runs" / name, name)
            drawn = drawings.pictures(shown, field, most=1)
        except PgimpError as error:
            drawn = paragraph(str(error))
        yield join([Markup(f"<h3>{text(name)}</h3>"), drawn])


def _picture(path: Path) -> Markup:
    try:
        return image(read_plain(path, _LARGEST), "Error against cells and cost")
    except OSError:
        return Markup()


def _text(path: Path) -> str:
    try:
        return read_plain(path, _LARGEST).decode(errors="replace")
    except OSError:
        return ""
