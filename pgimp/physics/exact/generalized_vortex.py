"""Generalized vortex of Kamojjala, Brannon, Sadeghirad and Guilkey (2015): a ring that turns.

Every circle of the ring turns by alpha(R, t) = A sin(2 pi t/T) h(R), h = (1 - 4 s^2)^2 with
s = (R - mean radius)/width. Both radii have h = h' = 0, and stay at rest and free of traction. The
volume does not change. In the basis turned by alpha, with the shear k = R alpha', the stress is
(0, mu k; mu k, mu k^2). The balance of momentum then gives the body force

    b_r     = -R alpha_t^2 + mu/rho0 R alpha'^2
    b_theta = R alpha_tt - mu/rho0 (R alpha'' + 3 alpha')
"""

from collections.abc import Iterator
from math import cos, pi, sin, sqrt
from typing import Any, ClassVar, NamedTuple

from pydantic import Field

from pgimp.geometry.regions import Ball, Difference
from pgimp.jit.kernel import kernel
from pgimp.physics.exact.base import Solution, no_gravity
from pgimp.physics.materials.base import lame
from pgimp.schema.base import Number, Positive
from pgimp.schema.problems import Problem


@kernel
def profile(R, mean, width):
    """Return h and its first two derivatives."""
    s = (R - mean) / width
    q = 1.0 - 4.0 * s * s
    return q * q, -16.0 * s * q / width, 16.0 * (12.0 * s * s - 1.0) / (width * width)


class GeneralizedVortexParameters(NamedTuple):
    """Centre, mean radius and width of the ring, mu, rho0, A, and the angular frequency 2 pi/T."""

    centre: tuple[float, float]
    mean: float
    width: float
    mu: float
    density: float
    amplitude: float
    frequency: float

    def scale(self, t: float) -> float:
        """Return the shear stress at the mean radius for the steepest slope of h."""
        steepest = 32.0 / (3.0 * sqrt(3.0) * 2.0) / self.width
        return self.mu * abs(self.amplitude) * self.mean * steepest

    @staticmethod
    def state(solution, X, x, t):
        """Displacement, velocity and stress of the material point."""
        a, w = solution.amplitude, solution.frequency
        X0, X1 = X[0] - solution.centre[0], X[1] - solution.centre[1]
        R = sqrt(X0 * X0 + X1 * X1)
        h, slope, _ = profile(R, solution.mean, solution.width)
        angle = a * sin(w * t) * h
        C, S = cos(angle), sin(angle)
        x0, x1 = C * X0 - S * X1, S * X0 + C * X1
        rate = a * w * cos(w * t) * h
        k = R * a * sin(w * t) * slope
        shear, hoop = solution.mu * k, solution.mu * k * k
        c, s = x0 / R, x1 / R
        sigma = (
            hoop * s * s - 2.0 * shear * c * s,
            hoop * c * c + 2.0 * shear * c * s,
            0.0,
            shear * (c * c - s * s) - hoop * c * s,
        )
        return (x0 - X0, x1 - X1), (-rate * x1, rate * x0), sigma

    @staticmethod
    def force(solution, X, t):
        """Body force per mass on the material point."""
        a, w = solution.amplitude, solution.frequency
        X0, X1 = X[0] - solution.centre[0], X[1] - solution.centre[1]
        R = sqrt(X0 * X0 + X1 * X1)
        h, slope, bend = profile(R, solution.mean, solution.width)
        g = a * sin(w * t)
        C, S = cos(g * h), sin(g * h)
        c, s = (C * X0 - S * X1) / R, (S * X0 + C * X1) / R
        rate = a * w * cos(w * t) * h
        stiffness = solution.mu / solution.density
        radial = R * (stiffness * g * g * slope * slope - rate * rate)
        hoop = -R * w * w * g * h - stiffness * g * (R * bend + 3.0 * slope)
        return radial * c - hoop * s, radial * s + hoop * c


class GeneralizedVortex(Solution):
    """Ring whose circles turn against one another and back, driven by a body force."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2,)
    forced: ClassVar[bool] = True
    moves: ClassVar[bool] = True
    model: ClassVar[str] = "neo-hookean"

    amplitude: Number = Field(description="greatest angle by which a circle turns, in radians [1]")
    period: Positive = Field(description="time in which it turns to and fro [time]")

    def mismatches(self, case: Any, name: str, body: Any) -> Iterator[Problem]:
        """The region must be a ring, without gravity."""
        yield from no_gravity(case)
        parts = body.region.root if isinstance(body.region, Difference) else ()
        if len(parts) != 2 or not all(isinstance(part, Ball) for part in parts):
            found = False
        else:
            outer, inner = parts
            found = outer.centre == inner.centre and outer.radius > inner.radius
        if not found:
            yield Problem(
                ("bodies", name, "region"),
                "the exact solution needs a ring: difference: [ball, ball], the larger one first, "
                "with one centre",
            )

    def parameters(self, case: Any) -> GeneralizedVortexParameters:
        """Parameters of the kernels."""
        (body,) = case.bodies.values()
        outer, inner = body.region.root
        material = case.materials[body.material]
        return GeneralizedVortexParameters(
            (float(outer.centre[0]), float(outer.centre[1])),
            0.5 * (outer.radius + inner.radius),
            float(outer.radius - inner.radius),
            lame(material.young, material.poisson)[1],
            float(material.density),
            float(self.amplitude),
            2.0 * pi / self.period,
        )
