"""Fuzzy particles (Fig. 3): chi_p is a tent, so that neighbours overlap and weights are cubic.

`fuzzy-nearest` has the half-width d = L/(particles per cell): a particle overlaps its neighbours
only, and chi_p(x_p) = 1. `fuzzy-constant` has d = L and the height 1/(particles per cell). In both
the tents of a lattice sum to one inside a body. S_vp, normalised by V_p, is the convolution of the
grid's tent with a tent of unit area.

At a body's surface the tents sum to only one half, and reach equally far beyond it. Nothing is
added there, so the surface is smeared over d; the mass stays exact. Beyond a wall the grid loses
this mass (``wall: ghost``) or gets it back by reflection (``wall: mirror``).
"""

from typing import ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.jit.kernel import inlined
from pgimp.physics.shapes.base import WideShape, beyond_walls
from pgimp.physics.shapes.stretch import FixedSize, TrackedSize


@inlined
def tents(half, f):
    """Weights and gradients of a tent of unit area, for f in [half, 1 + half); half at most 1."""
    t, u, s = 1.0 + half - f, max(1.0 - f, 0.0), max(1.0 - half - f, 0.0)
    b1 = max(f - 1.0, 0.0)
    a1, a2 = max(f + half - 1.0, 0.0), max(f + half - 2.0, 0.0)
    T, U, S, B1, A1, A2 = t * t, u * u, s * s, b1 * b1, a1 * a1, a2 * a2
    r = 1.0 / (half * half)
    q = r / 6.0
    w0 = q * (T * t - 2.0 * (U * u) + S * s)
    w2 = q * (A1 * a1 - 2.0 * (B1 * b1) - 2.0 * (A2 * a2))
    w3 = q * (A2 * a2)
    h = 0.5 * r
    g0 = -h * (T - 2.0 * U + S)
    g2 = h * (A1 - 2.0 * B1 - 2.0 * A2)
    g3 = h * A2
    return (w0, 1.0 - w0 - w2 - w3, w2, w3), (g0, -g0 - g2 - g3, g2, g3)


class _Tents:
    """Base of the two kinds of parameters."""

    @staticmethod
    def vertices():
        """Vertices a direction in a support."""
        return 4

    @staticmethod
    def weights(shape, half, f):
        """See `pgimp.physics.shapes`."""
        return tents(half, f)


class FixedFuzzyParameters(_Tents, FixedSize):
    """Half-widths of the particles' tents by direction, in cells."""


class TrackedFuzzyParameters(_Tents, TrackedSize):
    """Initial half-widths of the particles' tents by direction, in cells."""


class _Fuzzy(WideShape):
    """Base of the two fuzzy shapes."""

    size: Literal["tracked", "fixed"] = Field(
        default="tracked",
        description="whether the tents follow the deformation (tracked), which gives second-order "
        "convergence for any number of particles per cell",
    )
    wall: Literal["ghost", "mirror", "auto"] = beyond_walls("mirror")

    vertices: ClassVar[int] = FixedFuzzyParameters.vertices()
    chi: ClassVar[Literal["point", "box", "tent"]] = "tent"

    @property
    def follows(self) -> bool:
        """See `Shape.follows`."""
        return self.size == "tracked"

    def fixed(self, cell: tuple[float, ...]) -> FixedFuzzyParameters:
        """See `Shape.fixed`."""
        return FixedFuzzyParameters(self.parameters(cell).half)

    def _parameters(self, half: tuple[float, ...]) -> FixedFuzzyParameters | TrackedFuzzyParameters:
        return (TrackedFuzzyParameters if self.size == "tracked" else FixedFuzzyParameters)(half)


class FuzzyNearest(_Fuzzy):
    """Tents: the density falls linearly from the centre to zero at the neighbours' centres."""

    shape: Literal["fuzzy-nearest"] = Field(description="name of the shape")

    stable_pointwise: ClassVar[float] = 0.5

    def parameters(self, cell: tuple[float, ...]) -> NamedTuple:
        """Parameters of the kernels: d = L/(particles per cell)."""
        return self._parameters(tuple(1.0 / n for n in self.particles_per_cell))


class FuzzyConstant(_Fuzzy):
    """Tents that reach one cell for any number of particles per cell: locks least, slow waves."""

    shape: Literal["fuzzy-constant"] = Field(description="name of the shape")

    wide: ClassVar[bool] = True
    locks: ClassVar[bool] = False
    stable_pointwise: ClassVar[float] = 0.9

    def parameters(self, cell: tuple[float, ...]) -> NamedTuple:
        """Parameters of the kernels: d = L."""
        return self._parameters(tuple(1.0 for _ in self.particles_per_cell))
