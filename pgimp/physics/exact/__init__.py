"""Exact solutions, one file each.

A solution is the entry of the case (a `Solution`) whose ``parameters(case)`` gives a NamedTuple
with kernels as static methods and ``scale(t)``, the stress that the error (47) refers to:

- ``state(solution, X, x, t) -> (u, v, sigma)``: displacement, velocity and Cauchy stress of the
  particle with initial position X that is now at x;
- ``force(solution, X, t) -> b``: body force per mass, where the solution is `forced`.
"""

from pgimp.physics.exact.base import Solution
from pgimp.physics.exact.compaction import Compaction
from pgimp.physics.exact.generalized_vortex import GeneralizedVortex
from pgimp.physics.exact.shock import Shock
from pgimp.physics.exact.spinning_block import SpinningBlock
from pgimp.physics.exact.vibrating_bar import VibratingBar

#: The solutions by their name in the case, ``exact: NAME`` or ``exact: {NAME: {...}}``.
EXACT: dict[str, type[Solution]] = {
    "compaction": Compaction,
    "shock": Shock,
    "vibrating-bar": VibratingBar,
    "generalized-vortex": GeneralizedVortex,
    "spinning-block": SpinningBlock,
}
