"""Centrifugal force of a body that is spun up about the axis of rings, for ``--import``."""

import pgimp


@pgimp.body_force
def spin(x, t, rate, duration):
    """Force per mass at the radius x[0], as the angular velocity grows to `rate`."""
    s = min(t / duration, 1.0)
    w = rate * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    return w * w * x[0], 0.0
