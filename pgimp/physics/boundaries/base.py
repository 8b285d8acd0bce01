"""Base of the entries of boundary conditions, and the kernels' view of one."""

from abc import abstractmethod
from typing import ClassVar, NamedTuple

from pgimp.jit.kernel import class_of, inlined
from pgimp.schema.base import Model


class Boundary(Model):
    """Base of the entries ``boundaries.FACE``."""

    #: Whether nothing moves on the face, neither across it nor along it.
    sticks: ClassVar[bool] = False

    #: Whether the material may leave the face.
    releases: ClassVar[bool] = False

    #: Whether the kernel is ``approach(face, v, a, clearance)`` in place of
    #: ``constrain(face, v, a)``; the clearance is the distance of bodies from the face [length].
    approaches: ClassVar[bool] = False

    #: Whether the face is joined to the opposite one: the domain is periodic along its axis.
    joins: ClassVar[bool] = False

    #: Whether waves leave through the face, see `pgimp.kernels.grid.absorbing`.
    absorbs: ClassVar[bool] = False

    @property
    def mirrors(self) -> bool:
        """Whether the face reflects the part of supports beyond it, if walls do."""
        return True

    @property
    def varies(self) -> bool:
        """Whether the parameters depend on time and are computed for every step."""
        return False

    @property
    def at_rest(self) -> "Boundary":
        """The condition while the run settles."""
        return self

    def speed(self, axis: int, end: float) -> float | None:
        """Normal velocity of the face along `axis` at time `end`.

        None if the face does not prescribe the material's normal motion.
        """
        return 0.0

    def motion(self, end: float) -> tuple[float, float, float] | None:
        """Velocity that the face prescribes at time `end`; None if a component is free."""
        return None

    @abstractmethod
    def parameters(self, axis: int, side: int, start: float, end: float) -> NamedTuple:
        """Parameters of the kernel for one step.

        Parameters
        ----------
        axis, side
            Direction of the face, 0 to 2; -1 at the low end or 1 at the high end.
        start, end
            Times at the step's beginning and end.
        """


@inlined
def constrain(face, v, a, clearance):
    """Velocity and acceleration of a vertex on the face or beyond, by the face's condition.

    `clearance`, a length, is for conditions that bodies approach, see `Boundary.approaches`.
    """
    if hasattr(class_of(face), "approach"):
        return class_of(face).approach(face, v, a, clearance)
    return class_of(face).constrain(face, v, a)
