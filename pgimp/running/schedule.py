"""Schedules: an action is due at the first step at or after each of its times."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

# Tolerance for rounding of n * step, in steps: a step that ends just before a time counts as at it.
_ROUNDING = 1e-6


class Schedule:
    """Steps at which an action is due; the schedule never changes the steps.

    Parameters
    ----------
    every : float, object with ``steps``, or None
        Interval in simulated time or in steps; None for no regular action.
    at : sequence of float
        Further times.
    """

    def __init__(self, every: Any = None, at: Sequence[float] = ()) -> None:
        self._steps = getattr(every, "steps", None)
        self._interval = every if self._steps is None else None
        self._at = sorted(at)
        self._next_step: float = math.inf
        self._next_time: float = math.inf
        self.skip(0.0, 0, 0.0)

    def due(self, time: float, step: int, dt: float) -> bool:
        """Return whether the action is due now; call it once after each step.

        Parameters
        ----------
        time, step, dt : float, int, float
            Time, number and length of the last step.

        Returns
        -------
        bool
            Whether one or more times have been reached since the last call.
        """
        if step < self._next_step and time + _ROUNDING * dt < self._next_time:
            return False
        self.skip(time, step, dt)
        return True

    def skip(self, time: float, step: int, dt: float) -> None:
        """Find the next due time after the present."""
        now = time + _ROUNDING * dt
        if self._steps is not None:
            self._next_step = (step // self._steps + 1) * self._steps
        while self._at and self._at[0] <= now:
            self._at.pop(0)
        self._next_time = self._at[0] if self._at else math.inf
        if self._interval is not None:
            following = math.nextafter(now, math.inf)
            if now < 2.0**52 * self._interval:
                number = math.floor(now / self._interval)
                while number * self._interval <= now:
                    number += 1
                following = number * self._interval
            # Else multiples are closer than float64 resolves times: every step is due.
            self._next_time = min(self._next_time, following)
