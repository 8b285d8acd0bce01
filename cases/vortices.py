"""Initial velocity of the vortices of Taylor and Green, for ``--import``."""

from math import cos, pi, sin

import pgimp


@pgimp.velocity
def vortices(x, speed, side):
    """Velocity at x, two vortices to a side each way: no divergence, and zero in their middles."""
    k = 2.0 * pi / side
    return speed * sin(k * x[0]) * cos(k * x[1]), -speed * cos(k * x[0]) * sin(k * x[1])
