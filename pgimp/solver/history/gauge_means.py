"""Means over time of what gauges measure, from line to line."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.case.gauges import CutGauge, FluxGauge, Gauge, LevelGauge, WallGauge
from pgimp.errors import DamagedError

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

#: Numbers of a gauge that have means: all but the highest point, which there may be none of.
_AVERAGED = {CutGauge: 6, FluxGauge: 4, WallGauge: 2, LevelGauge: 1}
#: Name of the lines in a checkpoint.
NAME = "gauge-lines"
#: Numbers of a line in a checkpoint: gauge, time, and what it measured.
WIDTH = 2 + max(_AVERAGED.values())


def _averaged(gauge: Gauge) -> int:
    return next(n for kind, n in _AVERAGED.items() if isinstance(gauge, kind))


class Means:
    """The means of a run; of use on rank 0.

    Attributes
    ----------
    lines : dict of str to list of (float, ndarray)
        Times and numbers of the lines within each gauge's time, and of the one before.
    """

    def __init__(self) -> None:
        self.lines: dict[str, list[tuple[float, np.ndarray]]] = {}

    def add(self, scene: Scene, time: float, found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Take the numbers of a line; return the means."""
        means = {}
        for name, gauge in scene.case.gauges.items():
            if gauge.mean is None:
                continue
            lines = self.lines.setdefault(name, [])
            if lines and lines[-1][0] >= time:
                lines.pop()
            lines.append((time, found[name][: _averaged(gauge)].copy()))
            while len(lines) > 1 and lines[1][0] <= time - gauge.mean:
                lines.pop(0)
            means[name] = _mean(lines, time - gauge.mean, isinstance(gauge, FluxGauge))
        return means

    def rows(self, scene: Scene) -> np.ndarray:
        """Return the lines as rows for a checkpoint: number of the gauge, time, numbers."""
        found = []
        for number, name in enumerate(scene.case.gauges):
            for time, values in self.lines.get(name, ()):
                found.append([number, time, *values, *[0.0] * (WIDTH - 2 - len(values))])
        return np.array(found).reshape(-1, WIDTH)

    def restore(self, scene: Scene, rows: np.ndarray | None) -> None:
        """Put the lines of a checkpoint back, if it has any."""
        gauges = list(scene.case.gauges.items())
        for row in () if rows is None else rows:
            name, gauge = gauges[int(row[0])]
            values = row[2 : 2 + _averaged(gauge)].copy()
            self.lines.setdefault(name, []).append((float(row[1]), values))


def stored_lines(
    scene: Scene, source: Any, whole: Callable[[Any, str, tuple[int, ...]], np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the lines in a checkpoint by their name in it; none in other scenes.

    Raises
    ------
    DamagedError
        If they are not of the scene's gauges.
    """
    if NAME not in source.whole:
        return {}
    rows = whole(source, NAME, (*source.whole[NAME][1][:1], WIDTH))
    if not np.isin(rows[:, 0], range(len(scene.case.gauges))).all():
        raise DamagedError("what it has of gauges is not of its case")
    return {NAME: rows}


def _mean(lines: list[tuple[float, np.ndarray]], begin: float, since_last: bool) -> np.ndarray:
    """Return the mean from `begin`, or the first line, to the last one.

    By the trapezoidal rule, or exactly of values that are means `since_last`, the line before.
    """
    (t, value), total, length = lines[0], np.zeros_like(lines[0][1]), 0.0
    for end, last in lines[1:]:
        if since_last:
            value = last
        if t < begin < end:  # the window begins between two lines
            value, t = value + (last - value) * ((begin - t) / (end - t)), begin
        total = total + 0.5 * (end - t) * (value + last)
        length, t, value = length + (end - t), end, last
    return total / length if length > 0.0 else lines[-1][1]
