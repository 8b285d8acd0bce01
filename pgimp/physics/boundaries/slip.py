"""A frictionless bilateral wall: normal v = a = 0, tangential motion free.

Ghost vertices beyond the face keep their own tangential motion: without them there would be drag
(2 % of the tangential speed).
"""

from typing import NamedTuple

from pgimp.physics.boundaries.base import Boundary


class SlipParameters(NamedTuple):
    """The face."""

    axis: int
    side: int

    @staticmethod
    def constrain(face, v, a):
        """Hold the normal component."""
        k = face.axis
        return (
            (0.0 if k == 0 else v[0], 0.0 if k == 1 else v[1], 0.0 if k == 2 else v[2]),
            (0.0 if k == 0 else a[0], 0.0 if k == 1 else a[1], 0.0 if k == 2 else a[2]),
        )


class Slip(Boundary):
    """Frictionless wall; also a plane of symmetry."""

    def parameters(self, axis: int, side: int, start: float, end: float) -> SlipParameters:
        """See `Boundary.parameters`."""
        return SlipParameters(axis, side)
