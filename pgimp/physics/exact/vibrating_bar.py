"""A natural vibration of a bar: u = A sin(k Z) sin(c k t), exact for any amplitude.

With s = E (F - 1) the wave equation in the initial coordinate Z is linear for any strain.
"""

from collections.abc import Iterator, Mapping
from math import cos, pi, sin, sqrt
from typing import Any, Literal, NamedTuple

from pydantic import Field

from pgimp.physics.exact.bar import HOLDS, Bar, BarSolution, bar_of
from pgimp.physics.exact.base import no_gravity
from pgimp.schema.base import Count, Number
from pgimp.schema.problems import Problem


class VibratingBarParameters(NamedTuple):
    """Coordinate of the bar's beginning, E, amplitude, wave number k, angular frequency c k."""

    wall: float
    young: float
    amplitude: float
    wave: float
    frequency: float

    def scale(self, t: float) -> float:
        """Return the greatest stress, E A k."""
        return self.young * abs(self.amplitude) * self.wave

    @staticmethod
    def state(solution, X, x, t):
        """Displacement, velocity and stress of the material point."""
        a, k, w = solution.amplitude, solution.wave, solution.frequency
        z = X[0] - solution.wall
        return (
            (a * sin(k * z) * sin(w * t),),
            (a * w * sin(k * z) * cos(w * t),),
            (solution.young * a * k * cos(k * z) * sin(w * t), 0.0, 0.0),
        )


class VibratingBar(BarSolution):
    """Natural vibration of an elastic bar that is held at x-min, and free or held at its end."""

    moves = True

    amplitude: Number = Field(description="greatest displacement A [length]")
    mode: Count = Field(default=1, description="number of the natural vibration, 1 the slowest")
    end: Literal["free", "held"] = Field(
        default="free", description="the end of the bar: free, or held at x-max"
    )

    @property
    def walls(self) -> Mapping[str, tuple[str, ...]]:
        """See `Solution.walls`."""
        return {"x-min": HOLDS} | ({} if self.end == "free" else {"x-max": HOLDS})

    def _wave(self, length: float) -> float:
        return (self.mode - (0.5 if self.end == "free" else 0.0)) * pi / length

    def unlike(self, case: Any, name: str, velocity: float, bar: Bar) -> Iterator[Problem]:
        """There must be no load, and no point of the bar compressed to zero length."""
        yield from no_gravity(case)
        most = 1.0 / self._wave(bar.length)
        if abs(self.amplitude) >= most:
            yield Problem(
                ("exact", "vibrating-bar", "amplitude"),
                f"must be below {most:.6g} in size for this bar and mode, where the strain "
                f"reaches 1, got {self.amplitude:.15g}",
            )

    def parameters(self, case: Any) -> VibratingBarParameters:
        """Parameters of the kernels."""
        bar = bar_of(case)
        wave = self._wave(bar.length)
        frequency = wave * sqrt(bar.young / bar.density)
        return VibratingBarParameters(
            bar.wall, bar.young, float(self.amplitude), wave, float(frequency)
        )
