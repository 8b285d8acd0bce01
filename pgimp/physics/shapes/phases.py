"""Order of phases in a step of the current configuration: when stress is updated."""

from typing import Any, Literal

from pydantic import Field

StressOrder = Literal["last", "last-mapped", "average"]

#: Part of a step's strain before the forces, from the velocities at its beginning; the rest is from
#: the new velocities of particles, mapped to the vertices again.
STRAIN_BEFORE: dict[str, float] = {"last-mapped": 0.0, "average": 0.5}

#: Courant number up to which free bodies, at rest and in motion, are stable with `average`: in 1D,
#: 2D and 3D, for all numbers of particles, without `affine` (``scripts/phases steps``).
STABLE_AVERAGE = 0.95

STRESS: Any = Field(
    default="last",
    description="when a step updates stress, in the current configuration: last, from the new "
    "velocities of the vertices, which damps vibrations; last-mapped, from the particles' new "
    "velocities, mapped to the vertices again, which also moves them; average, half before the "
    "forces, from the velocities then, and half after, from the mapped ones: symmetric in time, so "
    "that waves and vibrations keep their energy, at about twice the cost of a step",
)
