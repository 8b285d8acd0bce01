"""Conditions on faces of the domain, one file each.

A condition is the entry of the case (a `Boundary`) whose ``parameters(axis, side, ...)`` gives a
NamedTuple. It has one kernel as a static method: ``constrain(face, v, a) -> (v, a)``. The kernel is
called after the momentum update, for each vertex on the face and beyond it. Its arguments are the
vertex's new velocity and acceleration, tuples of three. Faces that the case does not name are open.
"""

from pgimp.physics.boundaries.absorbing import Absorbing
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.boundaries.fixed import Fixed
from pgimp.physics.boundaries.periodic import Periodic
from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.boundaries.unilateral import Unilateral
from pgimp.physics.boundaries.velocity import Velocity

#: The conditions by their name in the case, ``boundaries: {FACE: NAME}``.
BOUNDARIES: dict[str, type[Boundary]] = {
    "fixed": Fixed,
    "slip": Slip,
    "unilateral": Unilateral,
    "velocity": Velocity,
    "periodic": Periodic,
    "absorbing": Absorbing,
}
