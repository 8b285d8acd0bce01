"""One line of the report, and the cure that goes with it."""

from __future__ import annotations

from typing import NamedTuple


class Finding(NamedTuple):
    """One line of the report.

    Attributes
    ----------
    part : str
        The thing that was checked.
    found : str
        The result.
    cure : str
        What to do; empty if all is well.
    broken : bool
        Whether it has to be done before pgimp works as installed.
    """

    part: str
    found: str
    cure: str = ""
    broken: bool = False

    @property
    def mark(self) -> str:
        """``ok``, ``note`` or ``WRONG``."""
        return "WRONG" if self.broken else "note" if self.cure else "ok"
