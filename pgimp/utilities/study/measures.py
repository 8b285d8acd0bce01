"""Error, order and cost of runs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import isfinite, log

import numpy as np

from pgimp.schema.instants import TimeMean
from pgimp.schema.messages import unknown
from pgimp.utilities.study.measure_entry import Measure

SAME_TIME = 1e-9
"""Relative to the time that is asked for."""


class MeasureError(Exception):
    """A run's history lacks the measured quantity; the message has the reason."""


def measure(history: np.ndarray, quantity: Measure) -> float:
    """Read a number from a history.

    Parameters
    ----------
    history : ndarray, shape (lines,)
        A structured array with a field for each column, and ``time``.
    quantity : Measure
        The number to read.

    Returns
    -------
    float
        ``|column - reference|``, over ``|reference|`` if relative. If the reference is the limit,
        not known yet, the column itself.

    Raises
    ------
    MeasureError
        If there is no such column or line, or the number is not finite.
    """
    names = history.dtype.names or ()
    if quantity.column not in names:
        raise MeasureError(f"history.csv: {unknown('column', quantity.column, names, 'it has')}")
    values = history[quantity.column]
    if isinstance(quantity.at, TimeMean):
        values = _mean(history, values, quantity.at)
    if isinstance(quantity.reference, float | int):
        values = np.abs(values - quantity.reference)
        if quantity.relative:
            values = values / abs(quantity.reference)
    if len(values) == 0:
        raise MeasureError("history.csv has no lines")
    if quantity.at == "end" or isinstance(quantity.at, TimeMean):
        value = values[-1]
    elif quantity.at == "max":
        value = values[np.abs(values).argmax()]
    else:
        at = float(quantity.at)
        row = int(np.searchsorted(history["time"], at - SAME_TIME * at))
        if row == len(values):
            last = history["time"][-1]
            raise MeasureError(f"history.csv ends before t = {at:.9g}, at {last:.9g}")
        value = values[row]
    if not isfinite(value):
        raise MeasureError(f"{quantity.label} is {value:g}")
    return float(value)


def _mean(history: np.ndarray, values: np.ndarray, over: TimeMean) -> np.ndarray:
    """Return the mean over a time as a column of one line."""
    time, (begin, end) = history["time"], over.mean
    if len(time) == 0 or time[-1] < end * (1.0 - SAME_TIME):
        last = time[-1] if len(time) else 0.0
        raise MeasureError(f"history.csv ends before t = {end:.9g}, at {last:.9g}")
    time, first = np.unique(time, return_index=True)
    values = values[first]
    inside = (time > begin) & (time < end)
    at = np.concatenate([[begin], time[inside], [end]])
    found = np.interp(at, time, values)
    total = 0.5 * (np.diff(at) * (found[1:] + found[:-1])).sum()
    return np.array([total / (end - begin)])


def costs(particles: int, steps: int, ranks: int, seconds: float) -> dict[str, float]:
    """Return every measure of cost of a run, by name."""
    return {
        "wall": seconds,
        "core": seconds * ranks,
        "particle-steps": particles * steps,
        "steps": steps,
    }


def orders(points: Sequence[tuple[float, float]]) -> list[float | None]:
    """Return the observed order between each point of a curve and the next coarser one.

    Parameters
    ----------
    points : sequence of (x, error)
        Cell sizes, or equivalent numbers, and errors, in any order of x.

    Returns
    -------
    list of float or None
        d log(error)/d log(x) for each point, None if there is no coarser point.
    """
    found: list[float | None] = [None] * len(points)
    sound = [i for i, (x, error) in enumerate(points) if x > 0.0 and error > 0.0]
    ranked = sorted(sound, key=lambda i: -points[i][0])
    for coarse, fine in pairwise(ranked):
        (x0, e0), (x1, e1) = points[coarse], points[fine]
        if x0 > x1:
            found[fine] = log(e0 / e1) / log(x0 / x1)
    return found


def pareto(points: Sequence[tuple[float, float]]) -> list[int]:
    """Find the points of the Pareto front.

    Parameters
    ----------
    points : sequence of (cost, error)
        Cost and error, both to be minimised.

    Returns
    -------
    list of int
        Indices of the points that no other point dominates, by ascending cost. A dominating point
        has at most the same cost and error, and less of one.
    """
    front: list[int] = []
    least: tuple[float, float] | None = None
    for i in sorted(range(len(points)), key=lambda i: points[i]):
        if least is None or points[i][1] < least[1] or points[i] == least:
            front.append(i)
            least = points[i]
    return front


def number(value: object, digits: int = 3) -> str:
    """Return a number with few digits, empty for None."""
    return "" if value is None else f"{value:.{digits}g}"
