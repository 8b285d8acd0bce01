"""A prescribed velocity of one's own, over place and time: the entry in the case."""

from __future__ import annotations

from typing import ClassVar

from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import VELOCITY, Kind


class PrescribedVelocity(FunctionEntry):
    """Prescribed velocity by a function of one's own, of the present place and the time."""

    KIND: ClassVar[Kind] = VELOCITY
