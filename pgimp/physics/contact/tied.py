"""Bodies that are bonded."""

from typing import ClassVar

from pgimp.physics.contact.base import TIED, ContactLaw


class Tied(ContactLaw):
    """They move as one body where they share vertices of the grid.

    From the beginning, or from when they meet.
    """

    kind: ClassVar[int] = TIED
    keys: ClassVar[tuple[str, ...]] = ()
