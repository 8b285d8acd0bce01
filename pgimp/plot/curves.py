"""Curves of the history: a panel for each kind of quantity, or, of several runs, each quantity."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from pgimp.case.messages import unknown
from pgimp.errors import UsageError
from pgimp.plot.runs import Shown
from pgimp.plot.style import COLOURS, DASHES
from pgimp.plot.tables import Table
from pgimp.plot.units import kind_of_column

Array = np.ndarray

_ALWAYS = ("kinetic-energy", "strain-energy")
_IF_ANY = r"external-work|reaction\.([xyz])-(min|max)-\1|constraint\..*|error(\..*)?"
_PATTERN = re.compile(r"[*?\[]")
_MOST_COLUMNS = 24
_WIDTHS = (5.4, 8.4, 9.9)


def curves(
    runs: Sequence[Shown], columns: Sequence[str], across: str, logarithmic: bool
) -> tuple[Any, Table, list[str]]:
    """Draw the history.

    Parameters
    ----------
    runs : sequence of Shown
        The runs, overlaid.
    columns : sequence of str
        Columns of history.csv, or patterns of their names; those that most want to see if empty.
    across : str
        The column along the horizontal axis.
    logarithmic : bool
        Whether the vertical axes are logarithmic.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.
    table : Table
        What it shows.
    remarks : list of str
        What it does not.

    Raises
    ------
    UsageError
        If a run has no history, or none has such a column.
    """
    histories = [shown.run.history for shown in runs]
    remarks = []
    for shown, history in zip(runs, histories, strict=True):
        if not len(history):
            more = " yet" if shown.run.state == "running" else "; history.every makes one"
            raise UsageError(f"{shown.path} has no line of history{more}")
        if across not in _columns(history):
            raise UsageError(
                f"{shown.path}: --x: {unknown('column', across, _columns(history), 'it has')}"
            )
    names = _named(histories, columns) if columns else _default(histories)
    if len(names) > _MOST_COLUMNS:
        raise UsageError(f"{len(names)} columns in one figure; {_MOST_COLUMNS} is the most")
    for shown, history in zip(runs, histories, strict=True):
        missing = [name for name in names if name not in _columns(history)]
        if missing:
            remarks.append(f"{shown.path} has no {', '.join(missing)}")
    table = Table(["run", across, *names])
    for shown, history in zip(runs, histories, strict=True):
        blank = np.full(len(history), np.nan)
        there = _columns(history)
        table.add(
            [shown.name],
            [history[across], *(history[name] if name in there else blank for name in names)],
        )
    return _draw(runs, histories, names, across, logarithmic), table, remarks


def _columns(history: Array) -> tuple[str, ...]:
    """Return the columns of a history."""
    return history.dtype.names or ()


def _named(histories: Sequence[Array], columns: Sequence[str]) -> list[str]:
    """Return the columns that names and patterns stand for, in the order of the command line."""
    known = list(dict.fromkeys(name for history in histories for name in _columns(history)))
    found: list[str] = []
    for column in columns:
        matching = [name for name in known if fnmatchcase(name, column)]
        if column not in known and not (_PATTERN.search(column) and matching):
            raise UsageError(f"--columns: {unknown('column', column, known, 'there are')}")
        found += [column] if column in known else matching
    return list(dict.fromkeys(found))


def _default(histories: Sequence[Array]) -> list[str]:
    """Return the energies, and of works, forces and errors what is not zero throughout."""
    known = list(dict.fromkeys(name for history in histories for name in _columns(history)))
    names = [name for name in _ALWAYS if name in known]
    for name in known:
        if re.fullmatch(_IF_ANY, name) and any(
            np.nan_to_num(history[name]).any() for history in histories if name in _columns(history)
        ):
            names.append(name)
    return (names or [name for name in known if name not in ("time", "step")])[:_MOST_COLUMNS]


def _draw(
    runs: Sequence[Shown],
    histories: Sequence[Array],
    names: Sequence[str],
    across: str,
    logarithmic: bool,
) -> Any:
    from matplotlib.figure import Figure

    single = len(runs) == 1
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(kind_of_column(name) or name if single else name, []).append(name)
    wide = 2 if len(groups) == 4 else min(len(groups), 3)
    rows = -(-len(groups) // wide)
    size = (_WIDTHS[wide - 1], 2.7 * rows + 0.4)
    figure = Figure(figsize=size)
    axes = figure.subplots(rows, wide, squeeze=False).ravel()
    for axis, (kind, members) in zip(axes, groups.items(), strict=False):
        alone = len(members) == 1
        for i, (shown, history) in enumerate(zip(runs, histories, strict=True)):
            for j, name in enumerate(members):
                if name not in _columns(history):
                    continue
                number = j if single else i
                axis.plot(
                    history[across],
                    history[name],
                    color=COLOURS[number % len(COLOURS)],
                    ls=DASHES[(number if not single else number // len(COLOURS)) % len(DASHES)],
                    lw=1.4,
                    label=shown.name if not single else _words(name, members),
                )
        text = _words(members[0], []) if alone else _common(members, kind)
        axis.set(
            xlabel=runs[0].label(_words(across, []), kind_of_column(across)),
            ylabel=runs[0].label(text, kind_of_column(members[0])),
        )
        if logarithmic:
            axis.set_yscale("log", nonpositive="mask")
        if not alone and single:
            axis.legend(
                fontsize=8.5,
                ncol=3,
                loc="lower left",
                bbox_to_anchor=(0.0, 0.98),
                borderpad=0.0,
                handlelength=1.4,
                columnspacing=1.2,
            )
    for axis in axes[len(groups) :]:
        axis.set_visible(False)
    if not single:
        lines: dict[str, Any] = {}
        for axis in axes[: len(groups)]:
            for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
                lines.setdefault(label, handle)
        figure.legend(
            list(lines.values()), list(lines), loc="outside upper center", ncol=min(len(lines), 4)
        )
    return figure


def _common(members: Sequence[str], kind: str) -> str:
    """Return the words that several columns share: ``energy``, ``reaction``."""
    first = {name.split(".")[0] for name in members}
    if kind.isalpha():
        return kind
    return first.pop() if len(first) == 1 else ""


def _words(name: str, among: Sequence[str]) -> str:
    """Return a column's name as a label; without the last word if all of `among` share it."""
    ends = {one.rpartition("-")[2] for one in among if "." not in one}
    if len(ends) == 1 and len(among) > 1 and all("." not in one for one in among):
        name = name.rpartition("-")[0]
    if "." in name:
        return name
    return name.replace("-", " ")
