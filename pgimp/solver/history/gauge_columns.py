"""Columns of history.csv of gauges; `pgimp.solver.history.columns` has the others."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.case.gauges import CutGauge, FluxGauge, Gauge, LevelGauge, WallGauge
from pgimp.solver.history.totals import Column, Group, Totals

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

Value = Callable[[Totals, np.ndarray], Any]

_KINDS: dict[type[Gauge], tuple[tuple[str, str, str, Value], ...]] = {
    CutGauge: (
        ("force-AXIS", "force",
            "for each gauge with a `cut`: force on the material inside by what is outside, the sum "
            "of the internal forces of the vertices inside, now",
            lambda s, found: s.along(found, 0)),
        ("moment-AXIS", "energy",
            "its moment, counter-clockwise positive; about z alone in 2D, none in 1D",
            lambda s, found: s.about_axes(found[3:6]))),
    FluxGauge: (
        ("mass-flux", "mass/time",
            "for each gauge with a `flux`: mass that has left the region per time since the last "
            "line, counted by the particles' ways; in a first line by their velocities",
            lambda s, found: found[0]),
        ("momentum-flux-AXIS", "force", "momentum that leaves with it: of a jet rho A v^2",
            lambda s, found: s.along(found, 1))),
    WallGauge: (
        ("force", "force",
            "for each gauge with a `wall`: force of stresses and weight on it along its normal, "
            "positive in compression; what stops material that hits it is in `reaction.FACE` alone",
            lambda s, found: found[0]),
        ("pressure", "stress", "this force over the area of the wall in the domain and in `within`",
            lambda s, found: found[1])),
    LevelGauge: (
        ("height", "length",
            "for each gauge with a `level`: volume over area of the material above the place, in "
            "linear weights of a cell around it",
            lambda s, found: found[0]),
        ("top", "length",
            "coordinate of the highest point there, drops included; nan where nothing is",
            lambda s, found: found[1])),
}  # fmt: skip


def _names(kind: type[Gauge], mean: bool) -> Callable[[Scene], list[str]]:
    def names(scene: Scene) -> list[str]:
        entries = scene.case.gauges.items()
        return [n for n, entry in entries if isinstance(entry, kind) and (entry.mean or not mean)]

    return names


def _group(kind: type[Gauge], mean: bool) -> Group:
    names = _names(kind, mean)

    def of(value: Value) -> Callable[[Totals, int], Any]:
        def found(totals: Totals, k: int) -> Any:
            known = totals.means if mean else totals.gauges
            return value(totals, known.get(names(totals.scene)[k], np.full(6, np.nan)))

        return found

    columns = [
        Column(
            f"gauge.NAME.mean.{name}" if mean else f"gauge.NAME.{name}",
            unit,
            f"with `mean`: its mean over that time; {meaning.partition(': ')[2] or meaning}"
            if mean
            else meaning,
            of(value),
        )
        for name, unit, meaning, value in _KINDS[kind]
        if not mean or name != "top"
    ]
    return Group(names, tuple(columns))


GAUGES = tuple(_group(kind, mean) for kind in _KINDS for mean in (False, True))
"""Groups of columns of gauges, in their order."""
