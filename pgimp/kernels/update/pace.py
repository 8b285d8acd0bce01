"""The speed that limits a step: how fast waves and particles cross cells."""

from pgimp.jit.kernel import inlined


@inlined
def pace(controlled, c, speed):
    """Speed in the Courant number, for a particle with wave speed c.

    It is c + |v|, or, where `controlled` is a number and not just true, the greater of c and this
    number times |v|. A body's displacement in a step does not affect stability as long as it is
    less than a cell (``scripts/hard moving``).
    """
    if isinstance(controlled, float):
        return max(c, controlled * speed)
    return c + speed
