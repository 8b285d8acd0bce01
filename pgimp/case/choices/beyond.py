"""What would be chosen instead, had the strain that a run shows been known."""

from __future__ import annotations

from typing import Any

from pgimp.case.choices.facts import FLOWING, kind_of
from pgimp.case.choices.scene_rules import LARGE

#: Stands for `pgimp.case.schema.Case`, whose module imports the choices.
Case = Any

#: Strain up to which metals in the initial configuration are as accurate as in the current one. A
#: footing bears 9 % more there, Taylor's bar is 2.5 % too wide.
FLOWED = 0.3


def beyond(case: Case, name: str, strain: float) -> str:
    """Return the key that fits a strain of a body, if another was chosen; empty if none would."""
    chosen, body = case.__dict__.get("chosen", {}), case.bodies[name]
    kind = kind_of(case.materials[body.material])
    if body.formulation == "total-lagrangian":
        metal = kind == "metal" and strain > FLOWED
        named = ("bodies", name, "formulation") not in chosen
        return "formulation: updated-lagrangian" if metal and not named else ""
    large = strain > LARGE and case.method.keeps_size and kind not in FLOWING
    return "method.shape: finite-gimp" if large and ("method", "shape") in chosen else ""
