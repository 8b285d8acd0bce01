"""Waves on liquids that are lower than the cells resolve."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.choices.facts import boxes_of
from pgimp.case.motion.moving_boxes import clearance
from pgimp.scene.checks.supports import AXES, greatest
from pgimp.scene.checks.warned import Warned, warned
from pgimp.schema.pages import page

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Crest in cells below which waves die, and slow down, and above which there is one.
_LOW, _SOME = 0.5, 1e-6
#: Cells from a face within which a liquid lies at it.
_AT = 1.0


def warnings(case: Case) -> Iterator[Warned]:
    """Yield a warning for each liquid between walls whose own motion or tilted weight is small.

    Its crest at a wall is that of a level across the weight, and u sqrt(h/g) by a velocity u.
    """
    g = greatest(case.gravity, case.dimensions)
    if case.dimensions == 1 or not g.any():
        return
    down = int(g.argmax())
    for box in boxes_of(case):
        low, high = box.low[0], box.high[0]
        body = case.bodies[box.name]
        if not case.materials[body.material].LIQUID or not isinstance(body.velocity, tuple):
            continue
        for along in set(range(case.dimensions)) - {down}:
            if len(_at(case, along, low, high)) < 2 or len(_at(case, down, low, high)) != 1:
                continue
            crest = 0.5 * (high - low)[along] * g[along] / g[down]
            crest += abs(body.velocity[along]) * sqrt((high - low)[down] / g[down])
            cells = float(crest / case.grid.cell[down])
            if _SOME < cells < _LOW:
                yield warned(
                    "low-wave",
                    f"bodies.{box.name}: its waves along {AXES[along]} have crests of about "
                    f"{cells:.2g} cells: below half a cell they slow down and die: of a quarter by "
                    "4 % and a sixth of their height in four swings, of a tenth by 13 % and a "
                    f"half; take cells of {crest / _LOW:.2g} along {AXES[down]} "
                    f"({page('soils-and-fluids.md#measured')})",
                )


def _at(case: Case, axis: int, low: np.ndarray, high: np.ndarray) -> list[str]:
    """Faces with a condition at which a box lies, of an axis."""
    return [
        face
        for face, condition in case.boundaries.items()
        if face[0] == AXES[axis] and not condition.joins
        for side in [-1 if face.endswith("min") else 1]
        if clearance(case, axis, side, low[axis], high[axis]) < _AT
    ]
