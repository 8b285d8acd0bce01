"""The contact law of bodies that pass through each other."""

from typing import ClassVar

from pgimp.physics.contact.base import IGNORE, ContactLaw


class Ignore(ContactLaw):
    """They pass through each other."""

    kind: ClassVar[int] = IGNORE
    keys: ClassVar[tuple[str, ...]] = ()
