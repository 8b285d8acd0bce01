"""The speed that limits a step: how fast waves and particles cross cells."""

from pgimp.jit.kernel import specialise


def pace(controlled, c, speed):
    """Speed that the Courant number refers to, of a particle with wave speed c.

    That is c + |v|, or, where `controlled` is a number and not just true, the greater of c and that
    times |v|: the distance that a body moves in a step does not affect stability as long as it is
    less than a cell (``scripts/hard moving``).
    """


@specialise(pace)
def _pace(controlled, c, speed):
    if hasattr(controlled, "bitwidth"):  # a number
        return lambda controlled, c, speed: max(c, controlled * speed)
    return lambda controlled, c, speed: c + speed
