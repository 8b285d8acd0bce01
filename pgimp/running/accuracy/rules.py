"""Indicators of accuracy: quantity, limit, page with the figures, remedy.

The bounds and their reasons are in docs/report.md, which a test compares with these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from pgimp.case.body import any_means
from pgimp.case.choices.beyond import FLOWED
from pgimp.schema.pages import page

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Most quantities that a line names.
_NAMED = 3
#: What energies are relative to, see docs/report.md.
_GREATEST = " of the greatest energy in the run"


class Rule(NamedTuple):
    """An indicator's quantity and its bound."""

    label: str  #: The quantity, as messages and reports name it.
    bound: float  #: The limit: the greatest, or the least if `least`.
    unit: str  #: ``%`` for a fraction that is shown in per cent; else a word, or nothing.
    page: str  #: The page, with its section, that has the figures.
    remedy: str  #: What lowers the error.
    least: bool = False  #: Whether values below the bound are outside.
    of: str = ""  #: What the value is relative to, where the quantity does not say it.

    def remedies(self, case: Case | None = None) -> str:
        """Return the remedy, without what a case does already."""
        parts = self.remedy.split("; ")
        method = None if case is None else case.method
        if method is not None and method.affine:
            parts = [part for part in parts if not part.startswith("method.affine: true")]
        if case is not None and any_means(case):
            parts = [part for part in parts if not part.startswith("method.volumetric: b-bar")]
        return "; ".join(parts)

    def beyond(self, value: float) -> str:
        """Return a value with its unit, in as many digits as tell it from the bound."""
        shown = self.number(value)
        if shown != self.number(self.bound) or value == self.bound:
            return shown
        factor = 100.0 if self.unit == "%" else 1.0
        digits = next(n for n in range(3, 18) if f"{value:.{n}g}" != f"{self.bound:.{n}g}")
        return f"{factor * value:.{digits}g} {self.unit}".rstrip()

    def number(self, value: float) -> str:
        """Return a value with its unit."""
        if self.unit == "%":
            if 0.0 < abs(value) < 1e-6:
                return "below 0.0001 %"
            return f"{100.0 * value:{'.2g' if abs(value) < 0.995 else '.0f'}} %"
        return f"{value:.3g} {self.unit}".rstrip()


#: All indicators, the most telling ones first.
RULES = {
    "error": Rule("error against the exact solution", 0.01, "%",
        "error-against-cost.md#what-an-error-costs",
        "smaller cells, or a method that is cheaper for its error"),
    "gained": Rule("energy that came from nothing", 0.05, "%",
        "hard-cases.md#the-largest-stable-steps", "time.step: {courant: 0.2}; smaller cells",
        of=_GREATEST),
    "lost": Rule("energy lost by the method", 0.05, "%", "methods.md#reasons",
        "smaller cells; method.affine: true; formulation: total-lagrangian for elastic bodies",
        of=_GREATEST),
    "momentum": Rule("momentum that no force explains", 0.01, "%", "report.md#balances",
        "more lines of the history (history.every)"),
    "inertia": Rule("kinetic over strain energy with mass-scaling", 0.02, "%",
        "case-file.md#mass-scaling", "a lower time.mass-scaling; slower loads, by smooth ramps"),
    "step": Rule("Courant number over the stable one", 1.0, "",
        "hard-cases.md#the-largest-stable-steps", "time.step: {courant: auto}"),
    "cells": Rule("cells across", 8.0, "", "hard-cases.md#locking", "smaller cells (grid.cell)",
        least=True),
    "locked": Rule("Poisson's ratio with pointwise volumes", 0.45, "", "hard-cases.md#locking",
        "method.volumetric: b-bar"),
    "per-cell": Rule("particles a cell and direction", 2.0, "", "methods.md#reasons",
        "method.particles-per-cell: 2 in each direction", least=True),
    "stretch": Rule("stretch of boxes", 1.5, "", "hard-cases.md#reasons",
        "method.shape: cpdi, or formulation: total-lagrangian: the body may tear where it should "
        "not"),
    "size": Rule("strain of boxes that keep their size", 0.15, "%", "methods.md#reasons",
        "method.shape: finite-gimp"),
    "flowed": Rule("strain of a metal in the initial configuration", FLOWED, "%",
        "metals.md#in-runs", "formulation: updated-lagrangian"),
    "locked-in": Rule("possibly locked-in energy", 0.03, "%", "hard-cases.md#locked-in-stress",
        "an entry of contact for bodies that meet; formulation: total-lagrangian"),
    "checkerboard": Rule("stress that varies within cells", 0.2, "%", "hard-cases.md#locking",
        "read means over cells; method.volumetric: b-bar for solids"),
    "noise": Rule("pressure that varies within cells", 0.2, "%", "limits.md#further-limits",
        "read means over cells, and over some hundredths of a second"),
    "walls": Rule("mass past walls", 1e-3, "%", "limits.md#further-limits",
        "method.shape: finite-gimp, or wall: mirror"),
    "volume": Rule("error of the volume of what flows", 0.06, "%", "soils-and-fluids.md#measured",
        "smaller cells"),
}  # fmt: skip


class Indicator(NamedTuple):
    """A value of an indicator."""

    name: str  #: One of `RULES`.
    value: float
    where: str = ""  #: The body or rigid body that it is about; may be empty.
    #: What else the value is relative to, with the value in that measure; may be empty.
    of: str = ""

    @property
    def rule(self) -> Rule:
        """Its rule."""
        return RULES[self.name]

    @property
    def distance(self) -> float:
        """Value over bound, or bound over value: above 1 it is outside."""
        rule, value = self.rule, abs(self.value)
        if rule.least:
            return rule.bound / value if value > 0.0 else float("inf")
        return value / rule.bound

    @property
    def well(self) -> bool:
        """Whether the value is within its limit."""
        return self.distance <= 1.0 + 1e-9

    @property
    def text(self) -> str:
        """Quantity, value and bound: ``cells across 'bar' 4 (well from 8)``."""
        rule = self.rule
        of = f" '{self.where}'" if self.where else ""
        bound = f"{'from' if rule.least else 'up to'} {rule.number(rule.bound)}"
        return f"{rule.label}{of} {rule.beyond(self.value)}{rule.of}{self.of} (well {bound})"


def line(found: list[Indicator]) -> str:
    """Return a line on values outside limits, the worst first, with a page; empty without any."""
    wrong = sorted((one for one in found if not one.well), key=lambda one: -one.distance)
    if not wrong:
        return ""
    kinds: dict[str, Indicator] = {}
    for one in wrong:
        kinds.setdefault(one.name, one)
    named = [*kinds.values()]
    shown = "; ".join(one.text for one in named[:_NAMED])
    more = f"; and {len(named) - _NAMED} more" if len(named) > _NAMED else ""
    return f"{shown}{more}: {page(named[0].rule.page)}"
