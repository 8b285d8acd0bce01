"""Warnings of scenes that `pgimp check` and the start of a run give alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.geometry.regions import Points
from pgimp.scene.checks import nearness
from pgimp.scene.checks.locking import locking
from pgimp.scene.checks.rigid_motion import motion_warnings
from pgimp.scene.checks.supports import greatest
from pgimp.scene.checks.validity import low_waves
from pgimp.scene.checks.warned import Warned, warned

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.scene.scene import Scene


def at_start(
    scenes: Sequence[Scene], poisson: Mapping[str, float] | None = None
) -> Iterator[Warned]:
    """Yield them; `poisson` has the greatest Poisson's ratio of bodies where it varies."""
    case = scenes[0].case
    yield from locking(case, poisson)
    yield from nearness.warnings(case, scenes[0].interaction.rigid_bodies)
    yield from unquiet(case)
    yield from low_waves.warnings(case)
    yield from motion_warnings(scenes)


def unquiet(case: Case) -> Iterator[Warned]:
    """Yield warnings of weight that absorbing faces do not bear, of the first stage."""
    start = case.start
    if (
        start.equilibrate is not None
        or start.stress is not None
        or not np.any(greatest(case.gravity, case.dimensions))
    ):
        return
    regions = [body.region for body in case.bodies.values()]
    if any(isinstance(region, Points) and region.summary.stress for region in regions):
        return
    for face, condition in case.boundaries.items():
        if condition.absorbs:
            yield warned(
                "absorbing-weight",
                f"boundaries.{face}: an absorbing face bears what presses on it as the run begins, "
                "and there is no stress then: under gravity the material pushes it outwards and "
                "creeps; with start: {equilibrate: {}} or {stress: {k0: ..}} the run begins at "
                "rest",
            )
