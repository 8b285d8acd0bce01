"""A line of the report with its remedy."""

from __future__ import annotations

from typing import NamedTuple


class Finding(NamedTuple):
    """A line of the report."""

    part: str  #: The checked part.
    found: str  #: The result.
    cure: str = ""  #: The remedy; empty if there is no problem.
    broken: bool = False  #: Whether pgimp does not work without the remedy.

    @property
    def mark(self) -> str:
        """``ok``, ``note`` or ``WRONG``."""
        return "WRONG" if self.broken else "note" if self.cure else "ok"
