"""Periodic faces: what leaves the domain at one face of a direction enters at the other.

No vertex is held: vertices on and beyond the high face are those of the low one
(`grid/image_values.py` of the kernels, and the ring of slabs in `pgimp.decomposition`).
"""

from typing import ClassVar, NamedTuple

from pgimp.physics.boundaries.base import Boundary


class Periodic(Boundary):
    """Joined to the opposite face, of which the case says the same."""

    joins: ClassVar[bool] = True

    @property
    def mirrors(self) -> bool:
        """See `Boundary.mirrors`."""
        return False

    def speed(self, axis: int, end: float) -> float | None:
        """See `Boundary.speed`."""
        return None

    def parameters(self, axis: int, side: int, start: float, end: float) -> NamedTuple:
        """Refuse: no kernel is called for these faces."""
        raise NotImplementedError("periodic faces hold no vertex")
