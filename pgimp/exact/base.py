"""What the entries of all exact solutions have in common, and the kernels' view of a solution."""

from abc import abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar, NamedTuple

from pgimp.case.base import Model
from pgimp.case.problems import Problem
from pgimp.kernels.jit import specialise


class Solution(Model):
    """Base of the entries ``exact``."""

    #: Whether the motion needs a body force of its own: a manufactured solution.
    forced: ClassVar[bool] = False
    #: Whether the solution gives the particles their initial velocity.
    moves: ClassVar[bool] = False

    @abstractmethod
    def misfits(self, case: Any) -> Iterator[Problem]:
        """Yield what in the parts of a case the solution does not fit; paths from the case's top.

        Parameters
        ----------
        case : Case
            Or any object with its parts, each sound for itself.
        """

    @abstractmethod
    def parameters(self, case: Any) -> Any:
        """Parameters of the kernels, from a case that fits."""


class BodyForce(NamedTuple):
    """Body force of a manufactured solution at a time."""

    solution: Any
    time: float


def state(solution, X, x, t):
    """Exact displacement, velocity and Cauchy stress of the particle from `X`, now at `x`.

    Positions and vectors are tuples of D numbers; the stress is one as ``particles.sigma``.
    """


@specialise(state)
def _state(solution, X, x, t):
    return solution.instance_class.state


def body_force(solution, X, t):
    """Body force per mass on the particle from `X`, a tuple of D numbers."""


@specialise(body_force)
def _body_force(solution, X, t):
    return solution.instance_class.force
