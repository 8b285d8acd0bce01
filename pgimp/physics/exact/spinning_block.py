"""A block that stretches and shrinks along its edges while it spins and flies.

With Z the initial position from the block's centre and L_i its sides, x = centre + v t + Q(t) y,

    y_i = Z_i + A_i sin(pi t/T)^2 f_i,  f_i = (Z_i + L_i/(2 pi) sin(2 pi Z_i/L_i))/2

and Q a rotation at a constant rate. The stretches F_i = 1 + A_i sin(pi t/T)^2 f_i' are 1 on the
block's faces, for f_i' = (1 + cos(2 pi Z_i/L_i))/2. For the neo-Hookean solid without lambda
(poisson = 0) the first Piola stress is Q diag(mu (F_i - 1/F_i)). The faces are free of traction.
The balance of momentum gives the body force per mass

    b = Q (w x (w x y) + 2 w x y_t + y_tt - mu/rho0 (1 + 1/F_i^2) dF_i/dZ_i)

b does not follow a block that lags behind. Where the sum of b.x over the mass is negative, as for
a block that only spins, an error in the angle grows as exp(rate t). In every plane of rotation the
stretching should outweigh the spin: mu (F^2 - 1), summed over both directions, should exceed
rho0 (rate r)^2. F is the mean stretch and r the radius of gyration.
"""

from collections.abc import Iterator
from math import cos, hypot, pi, sin
from typing import Annotated, Any, ClassVar, NamedTuple

from pydantic import Field

from pgimp.geometry.regions import Box
from pgimp.jit.algebra import rotate
from pgimp.jit.kernel import kernel
from pgimp.jit.tuples import three
from pgimp.physics.exact.base import Solution, no_gravity
from pgimp.physics.materials.base import lame
from pgimp.schema.base import Number, Positive, Vector
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem

Triple = tuple[float, float, float]

OptionalVector = Annotated[
    tuple[float, ...] | None, Either("one number a direction", {tuple: Vector, None: None})
]


@kernel
def rotation(n, angle):
    """Rotation about the unit vector `n`, row-major (Rodrigues)."""
    c, s = cos(angle), sin(angle)
    d = 1.0 - c
    x, y, z = n[0], n[1], n[2]
    return (
        c + d * x * x,
        d * x * y - s * z,
        d * x * z + s * y,
        d * x * y + s * z,
        c + d * y * y,
        d * y * z - s * x,
        d * x * z - s * y,
        d * y * z + s * x,
        c + d * z * z,
    )


@kernel
def turned(Q, a):
    """Q a."""
    return tuple(sum(Q[3 * i + k] * a[k] for k in range(3)) for i in range(3))


@kernel
def cross(a, b):
    """Cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def stretching(solution, Z, d):
    """A f, A f' and A f'' along direction `d`."""
    a, k, z = solution.stretch[d], solution.wave[d], Z[d]
    return (0.5 * a * (z + sin(k * z) / k), 0.5 * a * (1.0 + cos(k * z)), -0.5 * a * k * sin(k * z))


class SpinningBlockParameters(NamedTuple):
    """Centre, amplitudes A, wave numbers 2 pi/L, frequency 2 pi/T, mu, rho0, axis, rate, flight.

    In 2D the third amplitude is zero and the axis is z.
    """

    centre: Triple
    stretch: Triple
    wave: Triple
    frequency: float
    mu: float
    density: float
    axis: Triple
    rate: float
    translation: Triple

    def scale(self, t: float) -> float:
        """Return Young's modulus, 2 mu, times the largest of the amplitudes A."""
        return 2.0 * self.mu * max(map(abs, self.stretch))

    @staticmethod
    def state(solution, X, x, t):
        """Displacement, velocity and stress of the material point."""
        P, o, n = three(X), solution.centre, solution.axis
        Z = P[0] - o[0], P[1] - o[1], P[2] - o[2]
        p, q, r = stretching(solution, Z, 0), stretching(solution, Z, 1), stretching(solution, Z, 2)
        k = solution.frequency
        g, rate = 0.5 - 0.5 * cos(k * t), 0.5 * k * sin(k * t)
        y = Z[0] + g * p[0], Z[1] + g * q[0], Z[2] + g * r[0]
        Q = rotation(n, solution.rate * t)
        turn = cross(n, y)
        w = solution.rate
        v = turned(
            Q, (w * turn[0] + rate * p[0], w * turn[1] + rate * q[0], w * turn[2] + rate * r[0])
        )
        arm, fly = turned(Q, y), solution.translation
        u = (t * fly[0] + arm[0] - Z[0], t * fly[1] + arm[1] - Z[1], t * fly[2] + arm[2] - Z[2])
        F, G, H = 1.0 + g * p[1], 1.0 + g * q[1], 1.0 + g * r[1]
        f = solution.mu / (F * G * H)
        along = (f * (F * F - 1.0), f * (G * G - 1.0), f * (H * H - 1.0), 0.0, 0.0, 0.0)
        return (
            u[: len(X)],
            tuple(fly[d] + v[d] for d in range(len(X))),
            rotate(Q, along)[: 2 * len(X)],
        )

    @staticmethod
    def force(solution, X, t):
        """Body force per mass on the material point."""
        P, o, n = three(X), solution.centre, solution.axis
        Z = P[0] - o[0], P[1] - o[1], P[2] - o[2]
        p, q, r = stretching(solution, Z, 0), stretching(solution, Z, 1), stretching(solution, Z, 2)
        k, w = solution.frequency, solution.rate
        g, rate, growth = 0.5 - 0.5 * cos(k * t), 0.5 * k * sin(k * t), 0.5 * k * k * cos(k * t)
        y = Z[0] + g * p[0], Z[1] + g * q[0], Z[2] + g * r[0]
        inward = cross(n, cross(n, y))
        aside = cross(n, (rate * p[0], rate * q[0], rate * r[0]))
        stiffness = solution.mu / solution.density
        F, G, H = 1.0 + g * p[1], 1.0 + g * q[1], 1.0 + g * r[1]
        b = (
            w * w * inward[0]
            + 2.0 * w * aside[0]
            + growth * p[0]
            - stiffness * (1.0 + 1.0 / (F * F)) * g * p[2],
            w * w * inward[1]
            + 2.0 * w * aside[1]
            + growth * q[0]
            - stiffness * (1.0 + 1.0 / (G * G)) * g * q[2],
            w * w * inward[2]
            + 2.0 * w * aside[2]
            + growth * r[0]
            - stiffness * (1.0 + 1.0 / (H * H)) * g * r[2],
        )
        return turned(rotation(n, w * t), b)[: len(X)]


class SpinningBlock(Solution):
    """Block that stretches along its edges, spins and flies, driven by a body force."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2, 3)
    forced: ClassVar[bool] = True
    moves: ClassVar[bool] = True
    model: ClassVar[str] = "neo-hookean"

    stretch: Vector = Field(
        description="by direction: how much the block's middle is stretched at most, negative: "
        "shrunk; below 1 in size [1]"
    )
    period: Positive = Field(description="time in which it is stretched and comes back [time]")
    rate: Number = Field(description="angular velocity, about z in 2D [1/time]")
    axis: OptionalVector = Field(
        default=None, description="direction of the axis in 3D; null: (1, 2, 3), and z in 2D"
    )
    translation: OptionalVector = Field(
        default=None, description="velocity of the centre; null: at rest [length/time]"
    )

    def mismatches(self, case: Any, name: str, body: Any) -> Iterator[Problem]:
        """The region must be a box, Poisson's ratio zero, vectors of the case's dimension."""
        yield from no_gravity(case)
        if not isinstance(body.region, Box):
            yield Problem(("bodies", name, "region"), "the exact solution needs a box")
        poisson = case.materials[body.material].poisson
        if poisson != 0.0:
            text = f"the exact solution needs 0, so that the faces are free, got {poisson:.15g}"
            yield Problem(("materials", body.material, "poisson"), text)
        D, path = case.dimensions, ("exact", "spinning-block")
        for key in ("stretch", "axis", "translation"):
            value = getattr(self, key)
            if value is not None and len(value) != D:
                yield Problem((*path, key), f"expected {D} entries, one a direction")
        if self.axis and (D == 2 or (len(self.axis) == D and not any(self.axis))):
            text = "in 2D the axis is z; leave this out" if D == 2 else "a direction is not zero"
            yield Problem((*path, "axis"), text)
        for i, a in enumerate(self.stretch):
            if abs(a) >= 1.0:
                yield Problem((*path, "stretch", i), f"must be below 1 in size, got {a:.15g}")

    def parameters(self, case: Any) -> SpinningBlockParameters:
        """Parameters of the kernels."""
        (body,) = case.bodies.values()
        material, D = case.materials[body.material], case.dimensions
        low, high = body.region.min, body.region.max
        axis = (0.0, 0.0, 1.0) if D == 2 else (self.axis or (1.0, 2.0, 3.0))
        length = hypot(*axis)

        def triple(vector: Any, fill: float = 0.0) -> Triple:
            x, y, z = (*map(float, vector), fill)[:3]
            return x, y, z

        return SpinningBlockParameters(
            centre=triple([0.5 * (a + b) for a, b in zip(low, high, strict=True)]),
            stretch=triple(self.stretch),
            wave=triple([2.0 * pi / (b - a) for a, b in zip(low, high, strict=True)], 1.0),
            frequency=2.0 * pi / self.period,
            mu=lame(material.young, material.poisson)[1],
            density=float(material.density),
            axis=triple([a / length for a in axis]),
            rate=float(self.rate),
            translation=triple(self.translation or (0.0,) * D),
        )
