"""Length of steps: its entry in the case."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pgimp.schema.base import Model, Number, Positive
from pgimp.schema.dispatch import Either

#: Fraction of the largest stable Courant number that `auto` uses.
AUTO = 0.9

CourantNumber = Annotated[Number, Field(gt=0, le=1)]


class CourantStep(Model):
    """A step that follows the fastest wave: dt = courant min(cell)/(wave speed + velocity)."""

    courant: Annotated[
        float | Literal["auto"],
        Either("a number up to 1 or auto", {float: CourantNumber, str: Literal["auto"]}),
    ] = Field(
        description="Courant number: cells that the fastest wave crosses in a step; smaller steps "
        "lose less energy of waves, but without method.affine more of slow vibrations and of spin. "
        "auto: nine tenths of the largest that has been found stable with the method, see the "
        "page 'Hard cases'; what moves may then cross half a cell, and energy is watched"
    )


#: A step as a case writes it.
AnyStep = Annotated[
    float | CourantStep,
    Either("a step above zero or {courant: 0.3}", {float: Positive, dict: CourantStep}),
]
