"""Loads and prescribed motion: their entries in the case, and what kernels get of them.

A body force is one file here: the entry of the case (a `BodyForceEntry`) whose ``parameters()``
gives a NamedTuple with a kernel as static method:

- ``acceleration(force, x, v, t) -> b``: force per mass (17) on the particle that is at x and moves
  at v at the beginning of a step, at time t; tuples of three numbers, zero in the directions that
  the case does not have.
"""

from pgimp.physics.loads.bodyforce import BodyForceEntry
from pgimp.physics.loads.rotating_frame import RotatingFrame

#: The body forces by their name in the case, ``body_force: {NAME: {...}}``.
BODY_FORCES: dict[str, type[BodyForceEntry]] = {
    "rotating-frame": RotatingFrame,
}
