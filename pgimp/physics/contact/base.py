"""Base of the laws of contact, and the kernels' view of one."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

from pgimp.schema.base import Model

#: Ways in which bodies act on each other, as `Pairs.way` numbers them: they pass through each
#: other, move as one, or cannot penetrate and part freely.
IGNORE, TIED, UNILATERAL = range(3)


class ContactLaw(Model):
    """Base of the laws ``contact.ENTRY.law``."""

    #: How bodies act on each other: `IGNORE`, `TIED` or `UNILATERAL`.
    way: ClassVar[int] = UNILATERAL

    #: Keys of the entry that the law has.
    keys: ClassVar[tuple[str, ...]] = ("friction", "adhesion")

    def parameters(self, entry: Any) -> Any:
        """Parameters of the kernels of a unilateral law, all numbers.

        Parameters
        ----------
        entry : ContactEntry
            Whose law this is; it has the coefficients of friction.
        """
        raise NotImplementedError


class Sliding(NamedTuple):
    """Parameters of a law, with its kernels as static methods, for surfaces that may slide.

    Its fields are floats. ``sliding_part(law, cohesion, pressed, stress, sticking)`` is the part of
    the tangential impulse of sticking that is transmitted, 1 where the surfaces stick.
    ``slope(law, pressed, stress)`` is the derivative of the impulse while they slide, by `pressed`.

    `cohesion` is the greatest tangential impulse without pressure, `pressed` the normal impulse, at
    least 0, and `sticking` the tangential impulse that would stop all slip. `stress` is the
    impulse of a unit of stress, area times dt; inf where the area is not known.
    """
