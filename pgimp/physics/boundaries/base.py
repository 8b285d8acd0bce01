"""Base of the entries of boundary conditions, and the kernels' view of one."""

from abc import abstractmethod
from typing import ClassVar, NamedTuple

from pgimp.jit.kernel import specialise
from pgimp.schema.base import Model


class Boundary(Model):
    """Base of the entries ``boundaries.FACE``."""

    #: Whether the face reflects what particles carry beyond it, where their shape asks for that.
    mirrors: ClassVar[bool] = True

    #: Whether nothing moves on the face, neither across it nor along it.
    sticks: ClassVar[bool] = False

    #: Whether the material may leave the face.
    releases: ClassVar[bool] = False

    #: Whether the parameters have a static method ``approach(face, v, a, clearance)`` in place of
    #: ``constrain(face, v, a)``: with the distance of bodies from the face [m].
    approaches: ClassVar[bool] = False

    @property
    def varies(self) -> bool:
        """Whether the parameters change in time, so that they are computed for every step."""
        return False

    def speed(self, axis: int, end: float) -> float | None:
        """Velocity along direction `axis` at time `end` of what the face holds in.

        None if it does not say how the material moves along its normal.
        """
        return 0.0

    def motion(self, end: float) -> tuple[float, float, float] | None:
        """Velocity at time `end` of what the face holds; None where it leaves a component free."""
        return None

    @abstractmethod
    def parameters(self, axis: int, side: int, start: float, end: float) -> NamedTuple:
        """Parameters of the kernel for one step.

        Parameters
        ----------
        axis, side
            The face: direction 0 to 2, and -1 for its low end or 1 for its high end.
        start, end
            Times at which the step begins and ends.
        """


def constrain(face, v, a, clearance):
    """Velocity and acceleration of a vertex on the face or beyond, by its condition.

    `clearance`, a length, is for those that let bodies come near, see `Boundary.approaches`.
    """


@specialise(constrain)
def _constrain(face, v, a, clearance):
    if hasattr(face.instance_class, "approach"):
        return face.instance_class.approach
    return lambda face, v, a, clearance: _constrain_all(face, v, a)


def _constrain_all(face, v, a):
    """As `constrain`, where the clearance does not matter."""


@specialise(_constrain_all)
def _constrain_vertices(face, v, a):
    return face.instance_class.constrain
