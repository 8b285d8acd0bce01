"""Materials, one file each.

A material is the entry of the case (a `Material`) whose ``parameters()`` gives a NamedTuple with
a ``density`` and three kernels as static methods. `F`, `J` = det F and the velocity gradient `L`
are those at the end of the step, tensors are tuples as in `pgimp.kernels.algebra`:

- ``stress(material, F, J, sigma, L, dt)``: Cauchy stress, `sigma` the one before the step;
- ``energy(material, F, J, sigma)``: strain energy per initial volume;
- ``speed(material, F, J)``: speed of the fastest wave through the deformed material.
"""

from pgimp.materials.hooke import Hooke
from pgimp.materials.linear_1d import Linear1d
from pgimp.materials.neo_hookean import NeoHookean

#: The materials by their name in the case, ``materials: {NAME: {model: ...}}``.
MATERIALS = {"linear-1d": Linear1d, "neo-hookean": NeoHookean, "hooke": Hooke}
