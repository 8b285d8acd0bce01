"""Time: its entry in the case, with end, steps and stages."""

from __future__ import annotations

from typing import Annotated, Any, cast

from pydantic import Field

from pgimp.case.stages import Stage
from pgimp.case.stepping.steps import AnyStep, CourantStep
from pgimp.schema.base import Model, Number, Positive, chosen
from pgimp.schema.sizes import whole


class Time(Model):
    """How long is simulated, and in which steps."""

    end: Positive = Field(
        description="simulated time at which the run is done, or its first stage, the case as it "
        "is, where there are `stages` [time]"
    )
    step: AnyStep = Field(
        default=cast(Any, None),
        description="a fixed time step, of which end is a whole number [time], or {courant: ..}",
        json_schema_extra=chosen,
    )
    mass_scaling: Annotated[Number, Field(ge=1.0)] = Field(
        default=1.0,
        alias="mass-scaling",
        description="factor on inertia for quasi-static runs, whose steps are longer by its root: "
        "all accelerate as if masses were larger by it, while gravity and other forces stay what "
        "they are. Masses, densities, momenta and kinetic energies in results are those of this "
        "inertia; for all stages [1]",
    )
    stages: tuple[Stage, ...] = Field(
        default=(),
        max_length=100,
        description="stages that follow, each as a run that goes on where the one before has "
        "ended, with changes: of materials' parameters, boundaries, constraints, loads, and "
        "without bodies that are removed, and with bodies that come",
    )

    @property
    def last(self) -> float:
        """Simulated time at the end of the last stage."""
        return float([self.end, *(each.end for each in self.stages if each.end)][-1])

    @property
    def steps(self) -> int | None:
        """Number of steps to `end`; None if the step is not fixed."""
        return None if isinstance(self.step, CourantStep) else whole(self.end, self.step)[0]
