"""Pairs of bodies, rigid bodies and walls that may touch, with their ends."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.memory import structure
from pgimp.kernels.contact.data import PAIR_STATE
from pgimp.kernels.data.particles import FloatArray

#: Last of the numbers that stand for the vertex of a patch's pair, of its first side.
SIDES = -(1 << 20)

#: Ends of a pair: the row of each in `Coupling`, or -1 - n for a rigid end. Then the body of each;
#: the entry of the law; the vertex, or what stands for it in `find_patch_pairs`; the velocity at
#: which patches parted before the step, see `pgimp.kernels.contact.surfaces.patches.rows`.
ENDS = structure(
    ("rows", "i8", 2), ("bodies", "i8", 2), ("law", "i8"), ("vertex", "i8", 3), ("parted", "f8")
)


class ContactPairs(NamedTuple):
    """Candidate pairs."""

    ends: NDArray  #: (pairs,) ENDS: The bodies, their place, and their law.
    states: NDArray  #: (pairs,) PAIR_STATE: As in `Contact`: normal, gap, and accumulated impulses.
    #: (pairs, 3, 3) float64: Velocities of rigid ends, first and second; where the pair is.
    rigid: FloatArray

    @classmethod
    def empty(cls, count: int) -> Self:
        """Allocate for `count` pairs."""
        return cls(np.empty(count, ENDS), np.empty(count, PAIR_STATE), np.empty((count, 3, 3)))

    def chosen(self, which: slice | np.ndarray) -> Self:
        """Return the pairs at some offsets or in a slice."""
        return type(self)(self.ends[which], self.states[which], self.rigid[which])


class SeparatingWalls(NamedTuple):
    """Unilateral walls, which count as rigid bodies."""

    first: int  #: Number of the first one among the bodies.
    planes: NDArray  #: (walls,) FACE_PLANE: The faces.
