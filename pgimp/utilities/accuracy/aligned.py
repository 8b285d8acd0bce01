"""Curves of runs at the same times: columns of histories and probes."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

Array = np.ndarray

#: Columns that are means since the line before.
_MEANS = re.compile(
    r"(reaction|constraint|traction|torque)\..*|contact\.[^.]*(\.moment)?-[xyz]|"
    r"rigid\..*\.(force|torque)-[xyz]|gauge\..*\.(mass|momentum)-flux.*"
)
#: Columns without errors of their own.
_UNSEEN = re.compile(
    r"time|step|dt|mass-scaling|stages\.settling-time|volume|"  # of a particle
    r"rigid\..*\.penetrating-particles"
)


class Curve(NamedTuple):
    """A column over time."""

    times: Array  #: (lines,), ascending.
    values: Array  #: (lines,)
    mean: bool  #: Whether values are means since the line before.


def has_error(column: str) -> bool:
    """Whether a column means the same on all cells, as times and volumes of particles do not."""
    return _UNSEEN.fullmatch(column) is None


def curve_of(table: Array, column: str) -> Curve:
    """Return a column of a history, or a probe; of lines of the same time the last one."""
    times, last = np.unique(np.asarray(table["time"], float)[::-1], return_index=True)
    values = np.asarray(table[column], float)[::-1][last]
    return Curve(times, values, _MEANS.fullmatch(column) is not None)


def aligned(curve: Curve, to: Curve) -> Array:
    """Return the values of a curve at the times of another one, (lines,); nan after its end.

    Means since the line before are means over the other's lines, from their integral.
    """
    times, values = curve.times, curve.values
    if not len(times):
        return np.full(len(to.times), np.nan)
    if not curve.mean or len(to.times) < 2 or len(times) < 2:
        return np.interp(to.times, times, values, right=np.nan if _ends(times, to) else None)
    integral = np.concatenate([[0.0], np.cumsum(values[1:] * np.diff(times))])
    found = np.interp(to.times, times, integral, right=np.nan if _ends(times, to) else None)
    return np.concatenate([values[:1], np.diff(found) / np.diff(to.times)])


def _ends(times: Array, to: Curve) -> bool:
    """Whether a curve ends before another one."""
    return bool(times[-1] < to.times[-1] - 1e-9 * abs(to.times[-1]))
