"""Accuracy asked for: its entry in the case, with the quantity and the error that it may have."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import AfterValidator, Field, StringConstraints

from pgimp.case.time import Time
from pgimp.schema.base import Model, Number, Positive, one_line
from pgimp.schema.dispatch import Either
from pgimp.schema.instants import AT, At, label_of, last_of
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem, problem
from pgimp.schema.sizes import Problems

#: How a column of a probe is named; probes' names have no dots.
_OF_A_PROBE = re.compile(r"probe\.([^.]*)\.(.+)")
_PERCENT = re.compile(r"(\d+\.?\d*|\.\d+) ?%", re.ASCII)
_SAME_TIME = 1e-9


def _percent(value: str) -> str:
    found = _PERCENT.fullmatch(value)
    if not found or not 0.0 < float(found[1]) <= 100.0:
        raise problem(f"expected a part of the value, as 2 %, or an error above zero, got {value}")
    return value


class Accuracy(Model):
    """The error that a quantity may have, for which pgimp chooses the cells."""

    of: Annotated[
        str, StringConstraints(strict=True, min_length=1, max_length=1000), AfterValidator(one_line)
    ] = Field(
        description="a column of history.csv, as `reaction.x-min-x`, or of a probe, as "
        "`probe.tip.displacement-y`"
    )
    at: At = Field(default="end", description=AT)
    within: Annotated[
        str | float,
        Either(
            "an error above zero, or a part of the value, as 2 %",
            {float: Positive, str: Annotated[str, AfterValidator(_percent)]},
        ),
    ] = Field(
        description="the error that the value may have: a part of it, 2 %, or in its unit, 0.05"
    )
    finest: Annotated[Number, Field(gt=0, le=1)] = Field(
        default=0.25,
        description="the smallest cells that may be chosen, over those of the case (`grid.cell`), "
        "which are the largest; a run that needs smaller ones is not begun [1]",
    )

    @property
    def label(self) -> str:
        """Name of the quantity in messages."""
        return f"{self.of}{label_of(self.at)}"

    @property
    def probe(self) -> str:
        """The probe of which it is; empty for a column of the history."""
        found = _OF_A_PROBE.fullmatch(self.of)
        return found[1] if found else ""

    @property
    def column(self) -> str:
        """The column, of the history or the probe."""
        found = _OF_A_PROBE.fullmatch(self.of)
        return found[2] if found else self.of

    def allowed(self, value: float) -> float:
        """Return the error that the quantity may have, in its unit."""
        if isinstance(self.within, str):
            return 0.01 * float(self.within.rstrip("% ")) * abs(value)
        return float(self.within)

    @property
    def asked(self) -> str:
        """The error that it may have, for messages."""
        return self.within if isinstance(self.within, str) else f"{self.within:g}"


def check_accuracy(accuracy: Accuracy | None, time: Time, probes: Mapping[str, Any]) -> Problems:
    """Check that the quantity has its probe, and a time before the end."""
    if accuracy is None:
        return
    if accuracy.of.startswith("probe.") and accuracy.probe not in probes:
        name = accuracy.probe or accuracy.of.removeprefix("probe.")
        text = unknown("probe", name, probes) if probes else f"there is no probe {name}"
        yield Problem(("accuracy", "of"), text)
    if last_of(accuracy.at) > time.last * (1.0 + _SAME_TIME):
        text = f"{last_of(accuracy.at):.15g} is after the end at {time.last:.15g} (time.end)"
        yield Problem(("accuracy", "at"), text)
