"""Estimate of the steps in which a case or a stage comes to rest.

The slowest mode is at its static place after half of its period, and what begins anew after that
takes little (docs/case-file.md#how-it-comes-to-rest). Half a period is some travel times of a wave
along a compact body. It is as many more as the body is slender where it bends, and more in a liquid
that sloshes. Bodies that touch move together: what stands on others sways with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, inf, log10, pi, sqrt, tanh
from typing import NamedTuple

import numpy as np

from pgimp.case.schema import Case
from pgimp.geometry.sweep import close_pairs
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.supports import greatest
from pgimp.solver.time.clock import Step, settling_clock

#: Transits along the body in which it rests: of a compact one the fewest and the most, and the
#: most over the slenderness of one that bends. Half periods in which a liquid rests. Measured by
#: `scripts/quiet settle`, rounded outwards.
_FEWEST, _COMPACT, _BENDING, _SLOSHING = 4.0, 8.0, 9.0, 3.0

#: Tolerance of those measurements, and steps that each further tenth of it takes, as a part.
_TOLERANCE, _DECADE = 1e-4, 0.5


class Settling(NamedTuple):
    """Fewest and most steps that are probable."""

    low: float = 0.0
    high: float = 0.0

    def __add__(self, other: Settling) -> Settling:  # type: ignore[override]
        """Steps of both."""
        return Settling(self.low + other.low, self.high + other.high)

    def text(self) -> str:
        """Both, in two digits."""
        return f"{_rounded(self.low):,.0f} to {_rounded(self.high):,.0f}"


def settling_steps(case: Case, bodies: Sequence[BodyFacts]) -> Settling:
    """Return the probable number of steps in which a stage comes to rest; none if it does not.

    Parameters
    ----------
    case : Case
        The stage.
    bodies : sequence of BodyFacts
        All bodies, as the start of the run has them.
    """
    settle = case.start.equilibrate
    there = [body for body in bodies if body.name in case.bodies]
    if settle is None or not there:
        return Settling()
    rate = max(body.rest_rate for body in there)
    dt = settling_clock(case).next(Step(0, 0.0, 0.0, 0.0), rate).dt
    low, high = 0.0, 0.0
    for body in there:
        low = max(low, _FEWEST * body.extent / body.wave_speed)
        high = max(high, _sloshing(case, body))
    for some in _together(there, case.grid.cell):
        sizes = np.max([b.high for b in some], axis=0) - np.min([b.low for b in some], axis=0)
        slender = max(max(each) / min(each) for each in (sizes, *(body.sizes for body in some)))
        transit = sizes.max() / min(body.wave_speed for body in some)
        high = max(high, max(_COMPACT, _BENDING * slender) * transit)
    high *= 1.0 + _DECADE * max(0.0, log10(_TOLERANCE / settle.tolerance))
    low, high = (float(min(max(time / dt, 1.0), settle.steps)) for time in (low, high))
    return Settling(low, high)


def _together(bodies: Sequence[BodyFacts], cell: Sequence[float]) -> list[list[BodyFacts]]:
    """Groups of bodies whose boxes touch, up to a cell."""
    low, high = (np.array([getattr(body, end) for body in bodies]) for end in ("low", "high"))
    group = np.arange(len(bodies))
    first, second = close_pairs(low, high, np.array(cell)).T
    apart = np.maximum(low[first] - high[second], low[second] - high[first])
    touch = (apart <= cell).all(axis=1)
    for a, b in zip(first[touch], second[touch], strict=True):
        group[group == group[b]] = group[a]
    return [[bodies[n] for n in np.flatnonzero(group == g).tolist()] for g in np.unique(group)]


def _sloshing(case: Case, body: BodyFacts) -> float:
    """Time in which the slowest wave on a liquid rests; zero without a liquid or gravity."""
    pull = np.abs(greatest(case.gravity, case.dimensions))
    if case.dimensions == 1 or not pull.any():
        return 0.0
    if not case.materials[case.bodies[body.name].material].VOLUME_ONLY:
        return 0.0
    down = int(pull.argmax())
    along = max(size for d, size in enumerate(body.sizes) if d != down)
    wave = pi / along
    return _SLOSHING * pi / sqrt(float(pull[down]) * wave * tanh(wave * body.sizes[down]))


def _rounded(number: float) -> float:
    return number if number in (0.0, inf) else round(number, 1 - floor(log10(number)))
