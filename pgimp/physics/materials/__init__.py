"""Materials, one file each.

A material is the entry of the case (a `Material`) whose ``parameters()`` gives a NamedTuple with
a ``density`` and three kernels as static methods. `F`, `J` = det F and the velocity gradient `L`
refer to the end of the step. Tensors are tuples as in `pgimp.jit.algebra`:

- ``stress(material, F, J, sigma, L, dt)``: Cauchy stress; `sigma` is the stress before the step;
- ``energy(material, F, J, sigma)``: strain energy per initial volume;
- ``speed(material, F, J)``: speed of the fastest wave through the deformed material.

A material with state variables declares them in a class attribute of the entry,
``STATE: ClassVar = (State("damage", "1", "what it is"),)``. The functions then have one more
argument, ``state``, a tuple of floats in the order of the declaration. ``stress`` returns a pair:
the stress, and the state at the end of the step. `OPTIONAL` of `base.py` lists further quantities.

Functions are evaluated for four particles at once if they have no branches (`choose` replaces
them). They may use + - * /, abs, max, min, math's sqrt and floor, and `pgimp.jit.functions`.
Other functions are evaluated particle by particle. `pgimp.register_material` adds materials.
"""

from pgimp.jit.choose import choose
from pgimp.physics.materials.base import Material, Poisson, State, Young, lame
from pgimp.physics.materials.bingham import Bingham
from pgimp.physics.materials.cam_clay import CamClay
from pgimp.physics.materials.drucker_prager import DruckerPrager
from pgimp.physics.materials.hooke import Hooke
from pgimp.physics.materials.ideal_gas import IdealGas
from pgimp.physics.materials.johnson_cook import JohnsonCook
from pgimp.physics.materials.linear_1d import Linear1d
from pgimp.physics.materials.mohr_coulomb import MohrCoulomb
from pgimp.physics.materials.mu_i import MuI
from pgimp.physics.materials.neo_hookean import NeoHookean
from pgimp.physics.materials.newtonian import Newtonian
from pgimp.physics.materials.registry import MATERIALS
from pgimp.physics.materials.von_mises import VonMises
from pgimp.schema.base import NonNegative, Number, Positive

__all__ = [
    "MATERIALS",
    "Material",
    "NonNegative",
    "Number",
    "Poisson",
    "Positive",
    "State",
    "Young",
    "choose",
    "lame",
]

MATERIALS.update(
    {
        "linear-1d": Linear1d,
        "neo-hookean": NeoHookean,
        "hooke": Hooke,
        "von-mises": VonMises,
        "drucker-prager": DruckerPrager,
        "mohr-coulomb": MohrCoulomb,
        "cam-clay": CamClay,
        "mu-i": MuI,
        "newtonian": Newtonian,
        "bingham": Bingham,
        "ideal-gas": IdealGas,
        "johnson-cook": JohnsonCook,
    }
)
