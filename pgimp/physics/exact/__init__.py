"""Exact solutions, one file each.

A solution is the entry of the case (a `Solution`) whose ``parameters(case)`` gives a NamedTuple.
The tuple has ``scale(t)``, the reference stress of the error (47), and kernels as static methods:

- ``state(solution, X, x, t) -> (u, v, sigma)``: displacement, velocity and Cauchy stress of the
  particle with initial position X and present position x;
- ``force(solution, X, t) -> b``: body force per mass, where the solution is `forced`.
"""

from pgimp.physics.exact.base import Solution
from pgimp.physics.exact.compaction import Compaction
from pgimp.physics.exact.generalized_vortex import GeneralizedVortex
from pgimp.physics.exact.own import OwnSolution
from pgimp.physics.exact.plane_wave import PlaneWave
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
    "plane-wave": PlaneWave,
    "function": OwnSolution,
}
