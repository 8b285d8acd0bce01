"""Advice of ``pgimp check``, ordered by saved time."""

from collections.abc import Sequence

from pgimp.case.schema import Case
from pgimp.case.stepping.courant import largest_courant
from pgimp.case.stepping.steps import AUTO
from pgimp.scene.checks.advice import advice
from pgimp.scene.checks.facts import BodyFacts
from pgimp.utilities.check.prepare import pace_of

#: Approximate fraction of the time that advice on a key saves at the same error; the least known
#: (docs/error-against-cost.md). Advice that makes results correct, not quick, comes first.
_SAVES = {"method.affine": 1.0, "bodies": 0.6, "method.shape": 0.5}


def ordered_advice(
    case: Case, bodies: Sequence[BodyFacts], crossing: float, dt: float, quick: float = 0.0
) -> list[str]:
    """Return advice on the case, the largest savings first.

    `quick` has the cells that rigid bodies cross in a unit of time, which limits all steps.
    """
    found = []
    for text in advice(case, bodies):
        part = next((part for key, part in _SAVES.items() if text.startswith(key)), 0.0)
        part = 1.0 if case.method.is_point and text.startswith("method.shape") else part
        found.append((part, text))
    courant = AUTO * largest_courant(case)
    longest = courant / max(pace_of(courant, bodies, crossing), quick)
    chosen = ("time", "step") in case.__dict__.get("chosen", {})  # shorter, for a reason
    if not (case.watched or chosen) and longest > 1.05 * dt:
        saved = 1.0 - dt / longest
        found.append(
            (
                saved,
                f"time.step: {{courant: auto}} would begin with {longest:.4g} (Courant number "
                f"of waves {courant:.2g}): {100.0 * saved:.0f} % fewer steps",
            )
        )
    return [text for _, text in sorted(found, key=lambda item: -item[0])]
