"""A fixed wall: v = a = 0 on the face and beyond."""

from typing import ClassVar, NamedTuple

from pgimp.physics.boundaries.base import Boundary


class FixedParameters(NamedTuple):
    """The face."""

    axis: int
    side: int

    @staticmethod
    def constrain(face, v, a):
        """Hold every component."""
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


class Fixed(Boundary):
    """Holds the material: no motion on the face."""

    sticks: ClassVar[bool] = True

    def motion(self, end: float) -> tuple[float, float, float] | None:
        """See `Boundary.motion`."""
        return 0.0, 0.0, 0.0

    def parameters(self, axis: int, side: int, start: float, end: float) -> FixedParameters:
        """See `Boundary.parameters`."""
        return FixedParameters(axis, side)
