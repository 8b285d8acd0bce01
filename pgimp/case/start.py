"""The start of a run: the state in which it begins at time 0."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pgimp.schema.base import Count, Model, Number


class Settle(Model):
    """Steps before time 0 until all bodies are at rest under the loads of time 0."""

    tolerance: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default=1e-4,
        description="at rest is where the sum over the vertices of the magnitude of the unbalanced "
        "force is below this part of the sum for the forces of stresses and tractions [1]",
    )
    steps: Count = Field(
        default=100000, description="most steps; without rest after them the run ends with an error"
    )


class StartEntry(Model):
    """The start of a run."""

    settle: Settle | None = Field(
        default=None,
        description="before time 0 the run comes to rest, with the case's `damping` (by default "
        "kinetic) and the loads of time 0; then time, velocities, displacements and history begin "
        "at 0, with the stresses found. {} takes the defaults; null: none",
    )
