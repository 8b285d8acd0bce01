"""A frictionless wall that lets go: the normal part is held only when moving into the wall."""

from typing import ClassVar, NamedTuple

from pgimp.physics.boundaries.base import Boundary


class SeparatingParameters(NamedTuple):
    """The face."""

    axis: int
    side: int

    @staticmethod
    def constrain(face, v, a):
        """Hold the normal component of a vertex whose new velocity points out of the domain."""
        k = face.axis
        normal = v[0] if k == 0 else (v[1] if k == 1 else v[2])
        hold = normal * face.side > 0.0
        x, y, z = hold and k == 0, hold and k == 1, hold and k == 2
        return (
            (0.0 if x else v[0], 0.0 if y else v[1], 0.0 if z else v[2]),
            (0.0 if x else a[0], 0.0 if y else a[1], 0.0 if z else a[2]),
        )


class Separating(Boundary):
    """Frictionless wall from which the material lifts off freely: a floor, a stop."""

    releases: ClassVar[bool] = True

    def parameters(self, axis: int, side: int, start: float, end: float) -> SeparatingParameters:
        """See `Boundary.parameters`."""
        return SeparatingParameters(axis, side)
