"""Mohr and Coulomb's soil, with dilation and tension cut-off; return map in principal stresses.

The elastic law is Hencky's: the Kirchhoff stress, J times Cauchy's, is linear in the logarithm of
the elastic stretch. The state variable is b_e - 1, b_e = F_e F_e^T, a small tensor. With
principal stresses s1 >= s2 >= s3, S and s the sines of the angles of friction and dilation,

    f_ij = s_i - s_j + (s_i + s_j) S - 2 c cos(friction) <= 0,

the trial stress returns to the plane f_13 = 0, to one of its edges (f_12 or f_23 is zero as
well), or to the apex (De Souza Neto, Peric and Owen, Computational Methods for Plasticity, 2008,
sec. 8.2). All four returns are computed; the first that preserves the order of the stresses is
used. Stresses above the greatest tension are then cut off. Where all three are, the soil opens,
and the open volume has to close before pressure rises (see `drucker_prager`).
"""

from math import cos, radians, sin, sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from pgimp.jit.choose import choose
from pgimp.jit.functions import exp, log
from pgimp.jit.kernel import inlined
from pgimp.jit.series import carry
from pgimp.jit.spectral import eigen, spectral
from pgimp.jit.tuples import scaled
from pgimp.physics.materials.base import State, lame
from pgimp.physics.materials.exact.friction import edge, path_of_soil
from pgimp.physics.materials.laws.friction import PLASTIC_WORK, Soil

#: Tension of a soil without an apex.
_BOUNDLESS = 1e200


@inlined
def returned(material, s1, s2, s3, J):
    """Principal Kirchhoff stresses on or within the pyramid, from ordered trial stresses."""
    A, B, E = material.first, material.second, material.third
    S, c, a = material.sine, material.strength * J, material.plane
    rise = (1.0 - material.flow) * s1 - 2.0 * s2 + (1.0 + material.flow) * s3
    right = rise > 0.0
    f13 = s1 - s3 + (s1 + s3) * S - c
    f12 = s1 - s2 + (s1 + s2) * S - c
    f23 = s2 - s3 + (s2 + s3) * S - c
    # Plane.
    g = f13 / a
    p1, p2, p3 = s1 - A * g, s2 + B * g, s3 + E * g
    # Edges: with s2 = s3 on the right, s1 = s2 on the left.
    b = choose(right, material.right, material.left)
    other = choose(right, f12, f23)
    part = 1.0 / (a * a - b * b)
    g, h = (a * f13 - b * other) * part, (a * other - b * f13) * part
    e1 = choose(right, s1 - A * (g + h), s1 - A * g + B * h)
    e3 = choose(right, s3 + E * g + B * h, s3 + E * (g + h))
    e2 = choose(right, e3, e1)
    on_plane = (p1 >= p2) & (p2 >= p3)
    apex = material.apex * J
    on_edge = e1 >= e3
    r1 = choose(on_plane, p1, choose(on_edge, e1, apex))
    r2 = choose(on_plane, p2, choose(on_edge, e2, apex))
    r3 = choose(on_plane, p3, choose(on_edge, e3, apex))
    sound = f13 <= 0.0
    return choose(sound, s1, r1), choose(sound, s2, r2), choose(sound, s3, r3)


@inlined
def choose_all(condition, a, b):
    """Entries of tuple `a` where the condition is true, else entries of `b`."""
    return tuple(choose(condition, one, other) for one, other in zip(a, b, strict=True))


@inlined
def stretched(material, m, a, b, c):
    """Principal values of b_e - 1 under principal Kirchhoff stresses a, b, c with the mean m."""
    twice = 2.0 * material.mu
    third = m / (3.0 * material.bulk) - m / twice
    return (
        exp(2.0 * (a / twice + third)) - 1.0,
        exp(2.0 * (b / twice + third)) - 1.0,
        exp(2.0 * (c / twice + third)) - 1.0,
    )


class MohrCoulombParameters(NamedTuple):
    """Moduli; sines and strength; stress changes (A, B, E) and edges (a, b, b); tensions.

    Elastic constants lambda and mu, bulk modulus; sines of friction and dilation; 2 c cos;
    A, B, E, a, and b of the right and the left edge, see `returned`; tension at the apex, greatest
    tension, density.
    """

    lam: float
    mu: float
    bulk: float
    sine: float
    flow: float
    strength: float
    first: float
    second: float
    third: float
    plane: float
    right: float
    left: float
    apex: float
    tension: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, state):
        """Stress; b_e - 1, open volume, and plastic shear."""
        lam, twice = material.lam, 2.0 * material.mu
        gap, sheared, work = state[-3], state[-2], state[-1]
        trial = carry(scaled(dt, L), state[:-3])
        values, Q = eigen(trial)
        x = 0.5 * log(1.0 + values[0]) + gap / 3.0
        y = 0.5 * log(1.0 + values[1]) + gap / 3.0
        z = 0.5 * log(1.0 + values[2]) + gap / 3.0
        volume = x + y + z
        a, b, c = lam * volume + twice * x, lam * volume + twice * y, lam * volume + twice * z
        s1, s3 = max(max(a, b), c), min(min(a, b), c)
        s2 = max(min(a, b), min(max(a, b), c))
        r1, r2, r3 = returned(material, s1, s2, s3, J)
        most = material.tension * J
        opens = r3 >= most
        r1, r2, r3 = min(r1, most), min(r2, most), min(r3, most)
        sheared = sheared + ((s1 - s3) - (r1 - r3)) / twice
        kept = (s1 <= r1) & (s3 >= r3) & (s2 <= r2) & (gap == 0.0)
        # Back to the order of the eigenvectors, by the rank of each principal stress.
        ab, ac, bc = choose(a >= b, 1.0, 0.0), choose(a >= c, 1.0, 0.0), choose(b >= c, 1.0, 0.0)
        m = (r1 + r2 + r3) / 3.0
        fallen = (s1 + s2 + s3) / 3.0 - m
        work = work + m * (fallen / material.bulk - gap)
        work = work + (r1 * (s1 - r1) + r2 * (s2 - r2) + r3 * (s3 - r3) - 3.0 * m * fallen) / twice
        open_now = choose(opens, volume - m / material.bulk, 0.0)
        a, b, c = (
            _placed(ab + ac, r1, r2, r3),
            _placed(1.0 - ab + bc, r1, r2, r3),
            _placed(2.0 - ac - bc, r1, r2, r3),
        )
        elastic = choose_all(kept, trial, spectral(stretched(material, m, a, b, c), Q))
        stress = spectral((a / J, b / J, c / J), Q)
        return stress, (*elastic, open_now, sheared, work)

    @staticmethod
    def initial_state(material, F, J, sigma, state):
        """b_e - 1 from the stress; the other states unchanged."""
        values, Q = eigen(sigma)
        a, b, c = J * values[0], J * values[1], J * values[2]
        return (*spectral(stretched(material, (a + b + c) / 3.0, a, b, c), Q), *state[-3:])

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Elastic energy of the stored stretch, per initial volume.

        If a later stage changes the moduli, it changes at once, as the stress does.
        """
        values = eigen(state[:-3])[0]
        x, y, z = (
            0.5 * log(1.0 + values[0]),
            0.5 * log(1.0 + values[1]),
            0.5 * log(1.0 + values[2]),
        )
        volume = x + y + z
        return 0.5 * material.lam * volume * volume + material.mu * (x * x + y * y + z * z)

    @staticmethod
    def losses(material, F, J, sigma, state):
        """Plastic work."""
        return state[-1], 0.0, 0.0

    @staticmethod
    def speed(material, F, J, state):
        """Longitudinal wave, rho0 c^2 = lambda + 2 mu, minus the stress along it."""
        modulus = (material.lam + 2.0 * material.mu) * (1.0 - log(min(J, 1.0)))
        return sqrt(modulus / material.density)


@inlined
def _placed(rank, r1, r2, r3):
    """Select r1, r2 or r3 by rank: the number of other stresses not above, 2, 1 or 0."""
    return choose(rank > 1.5, r1, choose(rank < 0.5, r3, r2))


class MohrCoulomb(Soil):
    """Soil or rock with the strength of Mohr and Coulomb, exact on edges and at the apex."""

    CARRIES_STRESS: ClassVar[bool] = True
    LOSSES: ClassVar[tuple[str, ...]] = ("plastic-work",)
    STATE: ClassVar[tuple[State, ...]] = (
        State("elastic-stretch", "1", "elastic b - 1, b = F_e F_e^T", tensor=True),
        State("gap", "1", "tension-crack volume, over the volume of soil", least=0.0),
        State("plastic-shear", "1", "sum of the plastic parts of the greatest shear strain"),
        PLASTIC_WORK,
    )

    model: Literal["mohr-coulomb"] = Field(description="name of the model")

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`."""
        return path_of_soil(self, (edge(self, -1.0), edge(self, 1.0)), path, value, confine)

    def parameters(self) -> MohrCoulombParameters:
        """Parameters of the kernels."""
        lam, G = lame(self.young, self.poisson)
        K = lam + 2.0 / 3.0 * G
        angle = radians(self.friction_angle)
        S, s = sin(angle), sin(radians(self.dilation_angle))
        apex = min(self.apex, _BOUNDLESS)
        elastic, strength = (lam, G, K), (S, s, 2.0 * self.cohesion * cos(angle))
        directions = (
            2.0 * G * (1.0 + s / 3.0) + 2.0 * K * s,
            (4.0 / 3.0 * G - 2.0 * K) * s,
            2.0 * G * (1.0 - s / 3.0) - 2.0 * K * s,
        )
        slopes = (
            4.0 * G * (1.0 + S * s / 3.0) + 4.0 * K * S * s,
            2.0 * G * (1.0 + S + s - S * s / 3.0) + 4.0 * K * S * s,
            2.0 * G * (1.0 - S - s - S * s / 3.0) + 4.0 * K * S * s,
        )
        ends = apex, min(self.greatest_tension, apex), self.density
        return MohrCoulombParameters(*elastic, *strength, *directions, *slopes, *ends)
