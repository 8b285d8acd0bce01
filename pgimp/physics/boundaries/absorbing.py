"""An absorbing face: waves leave the domain through it (Lysmer and Kuhlemeyer, 1969).

Dashpots on the face, rho c_p across it and rho c_s along it, in `pgimp.kernels.grid.absorbing`. As
a condition on velocities the face holds nothing, but while the run settles.
"""

from typing import ClassVar, Literal

from pydantic import Field

from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.boundaries.fixed import Fixed
from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.boundaries.velocity import VelocityParameters


class Absorbing(Boundary):
    """Face through which waves leave; it keeps the force with which it holds what is at rest."""

    held: Literal["slip", "fixed"] = Field(
        default="slip",
        alias="static-force",
        description="the condition on the face while the run comes to rest (start.equilibrate); "
        "its reaction stays then, as a constant force",
    )

    absorbs: ClassVar[bool] = True

    @property
    def mirrors(self) -> bool:
        """See `Boundary.mirrors`."""
        return False

    @property
    def at_rest(self) -> Boundary:
        """See `Boundary.at_rest`."""
        return Fixed() if self.held == "fixed" else Slip()

    def speed(self, axis: int, end: float) -> float | None:
        """See `Boundary.speed`."""
        return None

    def parameters(self, axis: int, side: int, start: float, end: float) -> VelocityParameters:
        """See `Boundary.parameters`: nothing is held."""
        free = (False, False, False)
        return VelocityParameters(axis, side, free, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
