"""Bands around curves: the estimated errors of their columns, of runs with companions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.utilities.accuracy.found import Companions
from pgimp.utilities.plot.curves.changes import Changes
from pgimp.utilities.plot.curves.series import Series

Array = np.ndarray


def bands(one: Series, names: Sequence[str], times: Array, changes: Changes) -> dict[str, Array]:
    """Return the half width of the band of each column, (lines,); none without companions.

    Quotients and moving means have none.
    """
    known = Companions(one.shown.path)
    if not known.runs or changes.over or changes.mean > 1:
        return {}
    own = [name for name in names if one.probe and name in one.own]
    found = known.errors(times, one.probe, own) if own else {}
    found |= known.errors(times, names=[name for name in names if name not in own])
    return {name: abs(changes.factor) * error for name, error in found.items()}
