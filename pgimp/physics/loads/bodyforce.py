"""Base of the entries of body forces, and the kernels' view of one."""

from abc import abstractmethod
from typing import NamedTuple

from pgimp.jit.kernel import class_of, inlined
from pgimp.schema.base import Model
from pgimp.schema.sizes import Problems, length


class BodyForceEntry(Model):
    """Base of the entries ``body-force``."""

    @property
    def initial(self) -> bool:
        """Whether the force depends on particles' initial positions."""
        return False

    @abstractmethod
    def parameters(self) -> NamedTuple:
        """Parameters of the kernels, see `pgimp.physics.loads`."""

    def check(self, dimensions: int) -> Problems:
        """Yield problems with the dimensions of the case; paths from the entry."""
        for name in type(self).model_fields:
            yield from length((name,), getattr(self, name), dimensions)


@inlined
def acceleration(force, x, v, t):
    """Force per mass on a particle with position x and velocity v: tuples of three numbers."""
    return class_of(force).acceleration(force, x, v, t)
