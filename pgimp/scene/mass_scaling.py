"""Mass scaling: a case with larger inertia, and the same forces.

All densities are larger by a factor, and forces per mass smaller by it. So weights, the pressures
of liquids and the buoyancy of water are what they were. Waves are slower by the factor's root.
"""

from __future__ import annotations

from typing import Any

from pgimp.case.schema import Case
from pgimp.schema.tables import VectorFunction

#: Marks a case that is scaled already.
_DONE = "mass_scaled"


class WeakerVector(VectorFunction):
    """A vector over time, divided by a factor."""

    whole: Any
    factor: float

    def value(self, t: float) -> tuple[float, ...]:
        """See `VectorFunction`."""
        return tuple(each / self.factor for each in self.whole.value(t))

    def integral(self, t: float) -> tuple[float, ...]:
        """See `VectorFunction`."""
        return tuple(each / self.factor for each in self.whole.integral(t))

    @property
    def rows(self) -> list[tuple[float, tuple[float, ...]]]:
        """See `VectorFunction`."""
        return [(t, tuple(each / self.factor for each in row)) for t, row in self.whole.rows]


def is_scaled(case: Case) -> bool:
    """Whether a case has its larger inertia already."""
    return _DONE in case.__dict__


def scaled(case: Case) -> Case:
    """Return the case with its inertia times `time.mass-scaling`; itself without a factor."""
    factor = case.time.mass_scaling
    if factor == 1.0 or is_scaled(case):
        return case
    gravity: Any = case.gravity
    if isinstance(gravity, VectorFunction):
        gravity = WeakerVector(whole=gravity, factor=factor)
    elif gravity is not None:
        gravity = tuple(each / factor for each in gravity)

    def heavier(entry: Any, key: str = "density") -> Any:
        return entry and entry.model_copy(update={key: factor * getattr(entry, key)})

    tractions = {
        name: entry.model_copy(update={"hydrostatic": heavier(entry.hydrostatic)})
        for name, entry in case.tractions.items()
    }
    changes = {
        "materials": {name: heavier(entry) for name, entry in case.materials.items()},
        "constraints": {name: heavier(entry, "mass") for name, entry in case.constraints.items()},
        "tractions": tractions,
        "water": heavier(case.water),
        "gravity": gravity,
    }
    found = case.model_copy(update=changes)
    found.__dict__[_DONE] = True
    return found


def inertia_factor(case: Case) -> float:
    """Factor by which the densities of a case are scaled already; 1 for a case as written."""
    return case.time.mass_scaling if _DONE in case.__dict__ else 1.0


def scaling_notes(case: Case) -> list[str]:
    """Return the note of a run whose inertia is scaled."""
    factor = case.time.mass_scaling
    if factor == 1.0:
        return []
    return [
        f"time.mass-scaling: inertia times {factor:g}, steps longer by {factor**0.5:.3g}; masses, "
        "densities, momenta and kinetic energies are those of this inertia"
    ]
