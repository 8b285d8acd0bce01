"""Base of the laws of contact, and the kernels' view of one."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

from pgimp.schema.base import Model

#: Kinds of interaction, as `Pairs.kind` numbers them: bodies pass through each other, move as one,
#: or cannot penetrate and part freely.
IGNORE, TIED, UNILATERAL = range(3)


class ContactLaw(Model):
    """Base of the laws ``contact.ENTRY.law``."""

    #: Kind of interaction: `IGNORE`, `TIED` or `UNILATERAL`.
    kind: ClassVar[int] = UNILATERAL

    #: Keys of the entry that the law uses.
    keys: ClassVar[tuple[str, ...]] = ("friction", "adhesion", "restitution")

    def parameters(self, entry: Any) -> NamedTuple:
        """Parameters of the kernels of a unilateral law, all numbers.

        Parameters
        ----------
        entry : ContactEntry
            Entry with this law and the coefficients of friction.
        """
        raise NotImplementedError


class Sliding(NamedTuple):
    """Parameters of a unilateral law, floats, with its kernels as static methods.

    - ``sliding_part(law, cohesion, pressed, stress, sticking, slip)``: transmitted fraction of the
      tangential impulse of sticking, 1 where the surfaces stick.
    - ``slope(law, pressed, stress, slip)``: derivative of the sliding impulse with respect to
      `pressed`.

    `cohesion` is the pair's shear adhesion (key ``adhesion``) as an impulse, 0 beyond its reach;
    `pressed` the normal impulse, at least 0. `sticking` is the tangential impulse that would stop
    all slip. `slip` is the velocity at which the surfaces slide at the end of the step if they
    transmit none; with a fraction f they slide at (1 - f) `slip`. `stress` is the impulse of a
    unit of stress, area times dt; inf where the area is unknown. Kernels are called for every
    pair, also apart and without pressure. A law with a function ``only_pressed(law)`` as well is
    one that then transmits nothing without cohesion, and need not be called.
    """
