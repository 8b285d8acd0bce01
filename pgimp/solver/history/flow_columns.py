"""Columns of history.csv for flowing bodies; `pgimp.solver.history.columns` has the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pgimp.kernels.data.ledger import CARRIED, ROOM
from pgimp.kernels.sums.sums import MASS
from pgimp.solver.history.totals import Column, Group, Totals

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene


def _flows(scene: Scene) -> list[tuple[int, str]]:
    """Numbers and names of the flowing bodies."""
    if not scene.interaction.flows:
        return []
    names = enumerate(scene.body_names)
    return [(body, name) for body, name in names if scene.interaction.flows.rates[body] > 0.0]


def _volume(totals: Totals, k: int, column: int) -> float:
    """Volume of the k-th flowing body; nan until it is known, 0 after its removal."""
    body = _flows(totals.scene)[k][0]
    there = totals.bodies[body, MASS] > 0.0
    return float(totals.filled[body, column]) or (np.nan if there else 0.0)


FLOWS = (
    Group(lambda scene: [name for _, name in _flows(scene)], (
        Column("volume.NAME", "length^dimensions",
            "for each body that flows: its volume, less what of it crowds where neighbourhoods of "
            "vertices are more than full; as of the last time that its particles were shifted (the "
            "page 'Soils, fluids and gases'), every few steps; nan before",
            lambda s, k: _volume(s, k, ROOM)),
        Column("volume.NAME.particles", "length^dimensions",
            "sum of J times initial volume of its particles then, of fluids and grains up to J = "
            "1.01, of loose soil less its `gap`: with `volume.NAME` it tells by how much its level "
            "is too low",
            lambda s, k: _volume(s, k, CARRIED)),
    )),
)  # fmt: skip
"""Columns of each body that flows."""
