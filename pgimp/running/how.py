"""How a run begins."""

from __future__ import annotations

from typing import NamedTuple


class How(NamedTuple):
    """How a run begins, as the command line says."""

    overwrite: bool = False  #: In place of an older one.
    resume: bool = False  #: Where an older one stopped.
    error: bool = False  #: After companion runs, from which errors are estimated.
    forecast: bool = False  #: Not at all: only the companion runs, and what it will cost.
