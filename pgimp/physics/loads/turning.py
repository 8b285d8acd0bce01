"""Prescribed rotation about an axis that moves: the entry in the case, and the motion of a step."""

from __future__ import annotations

from math import cos, hypot, sin

from pydantic import Field, model_validator

from pgimp.schema.base import Model, Vector
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.sizes import Problems, length
from pgimp.schema.tables import Varying
from pgimp.schema.time_functions import TimeFunction

Triple = tuple[float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]

NO_GRADIENT: Matrix = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Turning(Model):
    """Rotation about an axis that moves with what turns."""

    about: Vector = Field(description="a point of the axis, where it is at the start [length]")
    axis: Vector = Field(
        default=(0.0, 0.0, 1.0), description="direction of the axis, of any length; z in 2D"
    )
    rate: Varying = Field(
        description="angular velocity, counter-clockwise about the axis positive [1/time]"
    )

    @model_validator(mode="after")
    def _check_axis(self) -> Turning:
        if len(self.axis) != 3 or not hypot(*self.axis) > 0.0:
            text = "expected a vector of three numbers that is not zero"
            raise_problems("rotation", [Problem(("axis",), text)])
        return self

    @property
    def direction(self) -> Triple:
        """Unit vector of the axis."""
        x, y, z = self.axis
        length = hypot(x, y, z)
        return (x / length, y / length, z / length)

    def angle(self, t: float) -> float:
        """Return the angle of rotation from time 0 to `t`."""
        return self.rate.integral(t) if isinstance(self.rate, TimeFunction) else self.rate * t

    def speed(self, t: float) -> float:
        """Return the angular velocity at time `t`."""
        return self.rate.value(t) if isinstance(self.rate, TimeFunction) else self.rate

    @property
    def greatest(self) -> float:
        """Greatest angular velocity over time."""
        rows = self.rate.rows if isinstance(self.rate, TimeFunction) else [(0.0, self.rate)]
        return max(abs(value) for _, value in rows)

    def gradients(self, start: float, end: float) -> tuple[Matrix, Matrix]:
        """Return the gradients of the mean velocity and acceleration in a step, (3, 3) row-major.

        In a step of the length dt a particle at the arm r from the axis moves to Q r, with
        Rodrigues' rotation matrix Q = 1 + sin(a) K + (1 - cos(a)) K^2 of the angle a. K r is the
        axis times r. The mean velocity is (Q - 1) r/dt, a chord of the circle. The mean
        acceleration is (w1 K Q - w0 K) r/dt, with the angular velocities at both ends.
        """
        x, y, z = self.direction
        first, last = self.speed(start), self.speed(end)
        K = (0.0, -z, y, z, 0.0, -x, -y, x, 0.0)
        K2 = (
            x * x - 1.0, x * y, x * z,
            y * x, y * y - 1.0, y * z,
            z * x, z * y, z * z - 1.0,
        )  # fmt: skip
        if not end > start:
            return _scaled(first, K), NO_GRADIENT
        dt, angle = end - start, self.angle(end) - self.angle(start)
        s, one = sin(angle), 2.0 * sin(0.5 * angle) ** 2
        # K^3 = -K, so that K (Q - 1) = sin(a) K^2 - (1 - cos(a)) K.
        along = (last * (1.0 - one) - first) / dt
        velocity, rate = (
            [a * k + b * k2 for k, k2 in zip(K, K2, strict=True)]
            for a, b in ((s / dt, one / dt), (along, last * s / dt))
        )
        return _matrix(velocity), _matrix(rate)


def turning_problems(path: tuple[str | int, ...], dimensions: int, rotation: Turning) -> Problems:
    """Check that a rotation fits the dimensions."""
    if dimensions == 1:
        yield Problem(path, "there is no rotation in one dimension")
        return
    yield from length((*path, "about"), rotation.about, dimensions)
    if dimensions == 2 and any(rotation.axis[:2]):
        yield Problem((*path, "axis"), "in 2D the axis is z; leave it out")


def rotation_matrix(axis: Triple, angle: float) -> Matrix:
    """Return the rotation matrix of an angle about a unit vector, row-major."""
    x, y, z = axis
    c, s = cos(angle), sin(angle)
    one = 1.0 - c
    return (
        c + x * x * one, x * y * one - z * s, x * z * one + y * s,
        y * x * one + z * s, c + y * y * one, y * z * one - x * s,
        z * x * one - y * s, z * y * one + x * s, c + z * z * one,
    )  # fmt: skip


def _scaled(factor: float, matrix: Matrix) -> Matrix:
    return _matrix([factor * entry for entry in matrix])


def _matrix(entries: list[float]) -> Matrix:
    a, b, c, d, e, f, g, h, i = entries
    return (a, b, c, d, e, f, g, h, i)
