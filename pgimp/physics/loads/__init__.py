"""Loads and prescribed motion: their entries in the case, and their parameters for kernels.

A body force is one file here: the entry of the case (a `BodyForceEntry`) whose ``parameters()``
gives a NamedTuple with a kernel as static method:

- ``acceleration(force, x, v, t) -> b``: force per mass (17) on a particle with position x and
  velocity v at time t, the beginning of a step. Vectors are tuples of three numbers, zero in
  directions that the case does not have.
"""

from pgimp.physics.functions.over_time import FunctionOfTime
from pgimp.physics.loads.bodyforce import BodyForceEntry
from pgimp.physics.loads.controlled import Controlled
from pgimp.physics.loads.own_force import OwnForce
from pgimp.physics.loads.rotating_frame import RotatingFrame
from pgimp.schema.time_functions import FORMS

#: The body forces by their name in the case, ``body-force: {NAME: {...}}``.
BODY_FORCES: dict[str, type[BodyForceEntry]] = {
    "rotating-frame": RotatingFrame,
    "function": OwnForce,
}

FORMS |= {"function": FunctionOfTime, "control": Controlled}
