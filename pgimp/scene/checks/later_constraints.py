"""Constraints that begin in a later stage, and the particles in their regions at the start."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.case.checks.stages import reselects
from pgimp.case.schema import Case
from pgimp.scene.checks.warned import Warned, warned


class LaterConstraint(NamedTuple):
    """A constraint that selects its particles at the beginning of a later stage."""

    case: Case  #: The stage's.
    name: str
    body: int  #: Number of its body.
    region: Any  #: Region.


def later_constraints(cases: Sequence[Case]) -> list[LaterConstraint]:
    """Later constraints of all stages, given by their cases."""
    return [
        LaterConstraint(now, name, list(now.bodies).index(entry.body), entry.region)
        for before, now in pairwise(cases)
        for name, entry in now.constraints.items()
        if reselects(before, now, name)
    ]


def held(
    later: Sequence[LaterConstraint], body: NDArray[np.int32], x: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Number of particles in the region of each constraint now, (constraints,)."""
    return np.array(
        [np.count_nonzero(one.region.contains(x[body == one.body])) for one in later], np.int64
    )


def idle_warnings(later: Sequence[LaterConstraint], counts: NDArray[np.int64]) -> list[Warned]:
    """Warn of constraints that would hold nothing, by the counts of `held` over all particles."""
    found = []
    for one, count in zip(later, counts, strict=True):
        if count == 0:
            text = (
                f"time.stages.{one.case.staged.number - 1}.constraints.{one.name}.region: where "
                f"the bodies are at the start it contains no particle of "
                f"'{list(one.case.bodies)[one.body]}'; if none comes there by "
                f"t = {one.case.staged.start:.6g}, the run ends as the stage begins"
            )
            found.append(warned("idle-constraint", text))
    return found
