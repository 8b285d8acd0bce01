"""Warnings of scenes that `pgimp check` and the start of a run give alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from pgimp.scene.checks import nearness
from pgimp.scene.checks.locking import locking
from pgimp.scene.checks.quiet import unquiet
from pgimp.scene.checks.warned import Warned
from pgimp.scene.rigid.warnings import motion_warnings

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene


def at_start(
    scenes: Sequence[Scene], poisson: Mapping[str, float] | None = None
) -> Iterator[Warned]:
    """Yield them; `poisson` has the greatest Poisson's ratio of bodies where it varies."""
    case = scenes[0].case
    yield from locking(case, poisson)
    yield from nearness.warnings(case, scenes[0].interaction.rigid_bodies)
    yield from unquiet(case)
    yield from motion_warnings(scenes)
