"""Curves of histories and probes: a panel per kind of quantity; for several, per quantity."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

import numpy as np

from pgimp.errors import UsageError
from pgimp.schema.messages import unknown
from pgimp.schema.words.renamed import new_column
from pgimp.utilities.plot.curves.bands import bands
from pgimp.utilities.plot.curves.changes import Changes, axis_label, times
from pgimp.utilities.plot.curves.series import Series, open_series
from pgimp.utilities.plot.curves.spectra import FREQUENCY, Band, Peak, label_peaks, spectra
from pgimp.utilities.plot.look import Look
from pgimp.utilities.plot.runs import AXES, PlotRun
from pgimp.utilities.plot.style import COLOURS, DASHES, log_ticks, plain
from pgimp.utilities.plot.tables import Table
from pgimp.utilities.plot.units import kind_of_column

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

Array = np.ndarray

_ALWAYS = ("kinetic-energy", "strain-energy")
_IF_ANY = r"(external|plastic|viscous)-work|error(\..*)?"
_FORCE = re.compile(r"((?:reaction|constraint)\..*|rigid\..*\.force)-[xyz]")
_OF_A_PROBE = r"(displacement|velocity)-[xyz]|pressure|von-mises"
_PATTERN = re.compile(r"[*?\[]")
_MOST_COLUMNS = 24
_WIDTHS = (5.4, 8.4, 9.9)
_TICKS = {1: 8, 2: 7, 3: 5}
# Inches: width of a panel beside its axes; of a legend's entry without text, and of a letter.
_BESIDE, _HANDLE, _LETTER = 0.9, 0.5, 0.068
_FEW = 3  # few points, which a line without markers would hide


def curves(
    runs: Sequence[PlotRun],
    probes: Sequence[str],
    columns: Sequence[str],
    across: str,
    logarithmic: bool,
    look: Look = Look(),
    changes: Changes = Changes(),
    band: Band | None = None,
) -> tuple[Figure, Table, list[str]]:
    """Draw the history, or probes, or their spectra.

    Parameters
    ----------
    runs : sequence of PlotRun
        The runs, overlaid.
    probes : sequence of str
        The probes; if empty, the history.
    columns : sequence of str
        Columns of history.csv and of the probes, or patterns of their names; if empty the most
        common ones.
    across : str
        The column along the horizontal axis.
    logarithmic : bool
        Whether the vertical axes are logarithmic.
    look : Look
        Title and width.
    changes : Changes
        Factors, a divisor, and a moving mean of the columns.
    band : Band, optional
        For spectra in place of curves over time.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.
    table : Table
        Data of the figure.
    remarks : list of str
        Remarks on omitted data.

    Raises
    ------
    UsageError
        If there is no history or probe to draw, or none has such a column.
    """
    series = open_series(runs, probes)
    columns, across = [*map(new_column, columns)], new_column(across)
    changes = changes._replace(over=new_column(changes.over))
    for one in series:
        for option, name in (("--x", across), ("--over", changes.over or across)):
            if name not in one.columns:
                text = unknown("column", name, one.columns, "it has")
                raise UsageError(f"{one.shown.path}: {option}: {text}")
    names = _named(series, columns) if columns else _default(series)
    if len(names) > _MOST_COLUMNS:
        raise UsageError(f"{len(names)} columns in one figure; {_MOST_COLUMNS} is the most")
    if band and (across != "time" or changes.factor_x != 1.0):
        raise UsageError("--fft is over time: leave --x and --factor-x out")
    drawn_over = FREQUENCY if band else across
    heads = [times(changes.factor_x, drawn_over), *map(changes.label, names)]
    drawn, remarks, peaks, widths = [], [], [], []
    for one in series:
        missing = [name for name in names if name not in one.columns]
        if missing:
            remarks.append(f"{one.shown.path} has no {', '.join(missing)}")
        values, left_out = one.take([across, *names, *([changes.over] if changes.over else [])])
        over_time = across == "time" and not band
        widths.append(bands(one, names, values[across], changes) if over_time else {})
        values = changes.of(values, names, across)
        if left_out:
            text = f"{left_out:,} lines left out: only of the probe, or only of the history"
            remarks.append(f"{one.shown.path}: {text}")
        if band:
            values, found, told = spectra(one, values, names, band)
            peaks.append(found)
            remarks += told
        drawn.append(values)
    banded = [name for name in names if any(name in one for one in widths)]
    heads += [f"error of {changes.label(name)}" for name in banded]
    table = Table(["run", *(["probe"] if probes else []), *heads])
    for one, values, width in zip(series, drawn, widths, strict=True):
        same = [one.shown.name, *([one.probe] if probes else [])]
        errors = [width.get(name, np.full(len(values[drawn_over]), np.nan)) for name in banded]
        table.add(same, [*(values[name] for name in (drawn_over, *names)), *errors])
    if banded:
        remarks.append("bands are estimated errors, from runs on larger cells")
    if len({one.shown.units for one in series}) > 1:
        remarks.append(f"the runs have different units; those shown are of {series[0].shown.path}")
    figure = _draw(series, drawn, (drawn_over, names), logarithmic, look, changes, peaks, widths)
    return figure, table, remarks


def _known(series: Sequence[Series]) -> list[str]:
    return list(dict.fromkeys(name for one in series for name in one.columns))


def _named(series: Sequence[Series], columns: Sequence[str]) -> list[str]:
    """Return the columns of names and patterns, in the order of the command line."""
    known = _known(series)
    found: list[str] = []
    for column in columns:
        matching = [name for name in known if fnmatchcase(name, column)]
        if column not in known and not (_PATTERN.search(column) and matching):
            raise UsageError(f"--columns: {unknown('column', column, known, 'there are')}")
        found += [column] if column in known else matching
    return list(dict.fromkeys(found))


def _default(series: Sequence[Series]) -> list[str]:
    """Return the energies, and the works, forces and errors that are not always zero.

    For each face and constraint, the component of the force that is greatest in any run. For a
    probe, its displacement, velocity, pressure and von Mises stress.
    """
    known = list(dict.fromkeys(name for one in series for name in one.own))
    if series[0].probe:
        names = [name for name in known if re.fullmatch(_OF_A_PROBE, name)]
    else:
        names = [name for name in _ALWAYS if name in known]
        most = {name: _most(series, name) for name in known}
        for name in known:
            force = _FORCE.fullmatch(name)
            rivals = [f"{force[1]}-{axis}" for axis in AXES] if force else [name]
            best = max(rivals, key=lambda rival: most.get(rival, 0.0))
            shown = best == name if force else re.fullmatch(_IF_ANY, name)
            if shown and most[name] > 0.0:
                names.append(name)
    return (names or [name for name in known if name not in ("time", "step")])[:_MOST_COLUMNS]


def _most(series: Sequence[Series], name: str) -> float:
    """Return the greatest absolute value of a column in any of the series."""
    values = [one.take([name])[0][name] for one in series if name in one.columns]
    return max(float(np.abs(np.nan_to_num(value)).max()) for value in values)


def _draw(
    series: Sequence[Series],
    drawn: Sequence[Mapping[str, Array]],
    columns: tuple[str, Sequence[str]],
    logarithmic: bool,
    look: Look,
    changes: Changes,
    peaks: Sequence[Mapping[str, Sequence[Peak]]],
    widths: Sequence[Mapping[str, Array]],
) -> Figure:
    """Draw columns, the first along the horizontal axis, peaks of spectra, and bands of errors."""
    from matplotlib.figure import Figure

    across, names = columns
    single = len(series) == 1
    shown = series[0].shown
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(kind_of_column(name) or name if single else name, []).append(name)
    wide = 2 if len(groups) == 4 else min(len(groups), 3)
    rows = -(-len(groups) // wide)
    size = (look.width or _WIDTHS[wide - 1], 2.7 * rows + 0.4)
    figure = Figure(figsize=size)
    room = size[0] / wide - _BESIDE
    axes = figure.subplots(rows, wide, squeeze=False).ravel()
    for axis, (kind, members) in zip(axes, groups.items(), strict=False):
        alone = len(members) == 1
        tops: list[tuple[Peak, str]] = []
        for i, (one, values) in enumerate(zip(series, drawn, strict=True)):
            for j, name in enumerate(members):
                if name not in one.columns:
                    continue
                number = j if single else i
                axis.plot(
                    values[across],
                    values[name],
                    color=COLOURS[number % len(COLOURS)],
                    ls=DASHES[number % len(DASHES)],
                    lw=1.4,
                    marker="o" if np.isfinite(values[name]).sum() < _FEW else None,
                    ms=4,
                    label=plain(one.label) if not single else _words(name, members),
                )
                colour = COLOURS[number % len(COLOURS)]
                if name in widths[i]:
                    low, high = (values[name] + sign * widths[i][name] for sign in (-1.0, 1.0))
                    axis.fill_between(values[across], low, high, color=colour, alpha=0.2, lw=0.0)
                tops += [(peak, colour) for peak in peaks[i].get(name, ())] if peaks else []
        text = _words(members[0], []) if alone else _common(members, kind)
        if peaks:
            axis.set_title(changes.label(text) if alone else "", fontsize="medium")
            text = "amplitude"
        of_x, of_y = (shown.unit(kind_of_column(name)) for name in (across, members[0]))
        axis.set(
            xlabel=axis_label(changes.factor_x, _words(across, []), of_x),
            ylabel=changes.labelled(text, of_y),
        )
        if logarithmic:
            axis.set_yscale("log", nonpositive="mask")
            log_ticks(axis.yaxis)
        elif peaks:
            axis.margins(y=0.12)
            axis.set_ylim(bottom=0.0)
        label_peaks(axis, tops, 1 if single else _FEW)
        curves_there = [values[name] for values in drawn for name in members]
        if not any((one > (0.0 if logarithmic else -np.inf)).any() for one in curves_there):
            what = "no positive value" if logarithmic else "no value"
            axis.text(0.5, 0.5, what, transform=axis.transAxes, ha="center", va="center")
        axis.xaxis.get_major_locator().set_params(nbins=_TICKS[wide])
        if not alone and single:
            widest = max(len(_words(name, members)) for name in members)
            axis.legend(
                fontsize=8.5,
                ncol=max(1, min(3, int(room / (_HANDLE + _LETTER * widest)))),
                loc="lower left",
                bbox_to_anchor=(0.0, 0.98),
                borderpad=0.0,
                handlelength=1.8,
                columnspacing=1.2,
            )
    for axis in axes[len(groups) :]:
        axis.set_visible(False)
    if not single:
        lines: dict[str, Artist] = {}
        for axis in axes[: len(groups)]:
            for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
                lines.setdefault(label, handle)
        figure.legend(
            list(lines.values()), list(lines), loc="outside upper center", ncol=min(len(lines), 4)
        )
    if look.title:
        figure.suptitle(look.title, fontsize="large")
    figure.draw_without_rendering()
    for axis in axes[: len(groups)]:
        # A power of ten above the axis needs the space under the legend.
        if axis.get_legend() and axis.yaxis.get_offset_text().get_text():
            axis.get_legend().set_bbox_to_anchor((0.0, 1.06), axis.transAxes)
    return figure


def _common(members: Sequence[str], kind: str) -> str:
    """Return the common words of several columns: ``velocity``, ``energy``, ``reaction``."""
    whole = {re.sub("-[xyz]{1,2}$", "", name) for name in members}
    first = {name.split(".")[0] for name in members}
    if len(whole) == 1:
        return _words(whole.pop(), [])
    if kind.isalpha():
        return kind
    return first.pop() if len(first) == 1 else ""


def _words(name: str, among: Sequence[str]) -> str:
    """Return a column's name as a label; without the last word if all of `among` share it."""
    ends = {one.rpartition("-")[2] for one in among if "." not in one}
    if len(ends) == 1 and len(among) > 1 and all("." not in one for one in among):
        name = name.rpartition("-")[0]
    return plain(name if "." in name else name.replace("-", " "))
