"""Plane waves in a periodic domain: two that travel against each other.

With the initial coordinate X along the wave, and its length L/n in a domain of length L,

    u = A sin(k (X - X_0)) sin(w t),   k = 2 pi n/L,   w = k c.

That is A/2 (cos(k X - w t) - cos(k X + w t)): two waves at the speed c, which meet again as at
first after each period. All of the body may drift besides, at a constant velocity.

Across the direction of the wave (shear) the neo-Hookean solid keeps its volume, and its first
Piola stress is mu du/dX, whatever the strain: c^2 = mu/rho0, exactly. Along it (longitudinal)
c^2 = (lambda + 2 mu)/rho0 to first order in the strain k A; with s = E (F - 1) of `linear-1d`
c^2 = E/rho0, exactly.
"""

from collections.abc import Iterator
from math import cos, log, pi, sin, sqrt
from typing import Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from pgimp.geometry.regions import Box
from pgimp.jit.kernel import inlined, inner_kernel
from pgimp.physics.exact.base import Solution, no_gravity
from pgimp.physics.materials.base import lame
from pgimp.schema.base import Count, Number
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import WHOLE, faces

_AXES = "xyz"


class PlaneWaveParameters(NamedTuple):
    """A wave along `axis`, with displacements along `swing`, and the solid that it runs through."""

    axis: int
    swing: int
    young: float  #: Of `linear-1d`; else 0.
    #: lam, mu: Lame's constants of the neo-Hookean solid.
    lam: float
    mu: float
    #: low, wave, frequency, amplitude: X_0, k, w and A.
    low: float
    wave: float
    frequency: float
    amplitude: float
    drift: tuple[float, float, float]  #: The uniform velocity.

    def scale(self, t: float) -> float:
        """Return the greatest stress of the wave, to which (47) refers."""
        modulus = self.young or self.mu + (self.lam + self.mu) * (self.axis == self.swing)
        return modulus * self.wave * abs(self.amplitude)

    @staticmethod
    def state(solution, X, x, t):
        """Displacement, velocity and Cauchy stress of a material point."""
        s, phase = solution, solution.wave * (X[solution.axis] - solution.low)
        u = s.amplitude * sin(phase) * sin(s.frequency * t)
        v = s.frequency * s.amplitude * sin(phase) * cos(s.frequency * t)
        strain = s.wave * s.amplitude * cos(phase) * sin(s.frequency * t)
        moved, moves = _vectors(X, s, u, v, t)
        return moved, moves, _stress(X, s, strain)


@inner_kernel
def _one(yes):
    """1 for true, else 0."""
    return 1.0 if yes else 0.0


@inlined
def _vectors(X, solution, u, v, t):
    """Displacement and velocity, a tuple of D numbers each."""
    if len(X) == 1:
        d = solution.drift
        return (u + d[0] * t,), (v + d[0],)
    if len(X) == 2:
        d, k = solution.drift, solution.swing
        x, y = _one(k == 0), _one(k == 1)
        return (x * u + d[0] * t, y * u + d[1] * t), (x * v + d[0], y * v + d[1])
    d, k = solution.drift, solution.swing
    x, y, z = _one(k == 0), _one(k == 1), _one(k == 2)
    moved = x * u + d[0] * t, y * u + d[1] * t, z * u + d[2] * t
    return moved, (x * v + d[0], y * v + d[1], z * v + d[2])


@inner_kernel
def _normal(solution, strain, d):
    """Component `d` of the normal stresses."""
    mu, lam, along = solution.mu, solution.lam, d == solution.swing
    if solution.axis != solution.swing:
        return mu * strain * strain if along else 0.0
    if solution.young > 0.0:
        return solution.young * strain if along else 0.0
    F = 1.0 + strain
    return ((mu * (F * F - 1.0) if along else 0.0) + lam * log(F)) / F


@inner_kernel
def _shear(solution, strain, i, j):
    """Component of the shear stresses."""
    a, b = solution.axis, solution.swing
    return solution.mu * strain if (a == i and b == j) or (a == j and b == i) else 0.0


@inlined
def _stress(X, solution, strain):
    """Cauchy stress, as in ``particles.sigma``."""
    normal = tuple(_normal(solution, strain, d) for d in range(3))
    pairs = ((0, 1), (1, 2), (0, 2))[: (0, 1, 3)[len(X) - 1]]
    return (*normal, *tuple(_shear(solution, strain, i, j) for i, j in pairs))


class PlaneWave(Solution):
    """Plane waves in an elastic body that fills a periodic domain."""

    moves: ClassVar[bool] = True
    model: ClassVar[tuple[str, ...]] = ("linear-1d", "neo-hookean")

    along: Literal["x", "y", "z"] = Field(default="x", description="direction of the wave")
    swing: Literal["x", "y", "z"] = Field(
        default="x",
        alias="polarization",
        description="direction of the displacement: `along` for a longitudinal wave, another one "
        "for a shear wave",
    )
    amplitude: Number = Field(
        description="greatest displacement [length]; longitudinal waves of the neo-Hookean solid "
        "are exact to first order in it"
    )
    waves: Count = Field(default=1, alias="wavenumber", description="wavelengths in the domain")
    drift: tuple[Number, ...] = Field(
        default=(),
        alias="velocity",
        max_length=3,
        description="uniform velocity of the body besides, by direction; none by default "
        "[length/time]",
    )

    def wrong_walls(self, boundaries: Any) -> Iterator[Problem]:
        """All faces are periodic, so that the body has no end."""
        for axis in sorted({face[0] for face in boundaries} | {self.along}):
            for face in (f"{axis}-min", f"{axis}-max"):
                if face not in boundaries:
                    text = "missing; the exact solution has no faces: periodic"
                    yield Problem(("boundaries", face), text, True)
                elif not boundaries[face].joins:
                    yield Problem(
                        ("boundaries", face), "the exact solution has no faces: take periodic"
                    )

    def mismatches(self, case: Any, name: str, body: Any) -> Iterator[Problem]:
        """The body fills the domain; directions exist."""
        yield from no_gravity(case)
        D, path = case.dimensions, ("exact", "plane-wave")
        for key, axis in (("along", self.along), ("polarization", self.swing)):
            if _AXES.index(axis) >= D:
                yield Problem((*path, key), f"the case has {D} dimensions: {', '.join(_AXES[:D])}")
        for face in faces(D):
            if face not in case.boundaries:
                text = "missing; the exact solution has no faces: periodic"
                yield Problem(("boundaries", face), text, True)
        if self.drift and len(self.drift) != D:
            yield Problem((*path, "velocity"), f"expected {D} entries, one a direction")
        ends = (case.grid.origin, case.grid.corner)
        fills = isinstance(body.region, Box) and all(
            abs(a - b) <= WHOLE * size
            for end, at in zip((body.region.min, body.region.max), ends, strict=True)
            for a, b, size in zip(end, at, case.grid.size, strict=True)
        )
        if not fills:
            text = "the exact solution needs a box that fills the domain"
            yield Problem(("bodies", name, "region"), text)

    def parameters(self, case: Any) -> PlaneWaveParameters:
        """Parameters of the kernels."""
        (body,) = case.bodies.values()
        material, axis = case.materials[body.material], _AXES.index(self.along)
        swing = _AXES.index(self.swing)
        lam, mu, young = 0.0, 0.0, float(material.young)
        if material.model == "neo-hookean":
            (lam, mu), young = lame(material.young, material.poisson), 0.0
        modulus = young or (lam + 2.0 * mu if axis == swing else mu)
        wave = 2.0 * pi * self.waves / case.grid.size[axis]
        x, y, z = (*map(float, self.drift), 0.0, 0.0, 0.0)[:3]
        return PlaneWaveParameters(
            axis,
            swing,
            young,
            float(lam),
            float(mu),
            float(case.grid.origin[axis]),
            wave,
            wave * sqrt(modulus / material.density),
            float(self.amplitude),
            (x, y, z),
        )
