"""Contact laws, one file each, and the law of each pair of bodies.

A law is an entry of the case (a `ContactLaw`). If it is unilateral its ``parameters(entry)`` gives
a NamedTuple of floats with two kernels as static methods, see `pgimp.physics.contact.base.Sliding`.
"""

from pgimp.physics.contact.base import ContactLaw
from pgimp.physics.contact.friction import Coulomb
from pgimp.physics.contact.ignore import Ignore
from pgimp.physics.contact.tied import Tied

#: The laws by their name in the case, ``law: NAME`` or ``law: {NAME: ...}``.
LAWS: dict[str, type[ContactLaw]] = {"friction": Coulomb, "tie": Tied, "ignore": Ignore}
