"""Time: fixed steps, or steps from the Courant number."""

from bisect import bisect_right
from math import ceil

from pgimp.case.schema import Case
from pgimp.errors import RunError
from pgimp.solver.stability import MOST_STEPS


class EndlessError(RunError):
    """Steps have become so short that the run would never end; on every rank together."""


class FixedClock:
    """Steps of one length: t = n * step, never a running sum.

    Parameters
    ----------
    step, end : float
        Length of a step and end of the run, a whole number of steps.
    """

    controlled = False

    def __init__(self, step: float, end: float) -> None:
        self._dt = step
        self._steps = round(end / step)
        self.end = end
        self.step = 0
        self.time = 0.0

    @property
    def finished(self) -> bool:
        """Whether the end is reached."""
        return self.step >= self._steps

    def next(self, rate: float) -> tuple[float, float]:
        """Length of the next step and the time at its end."""
        return self._dt, (self.step + 1) * self._dt

    def advance(self, time: float) -> None:
        """Note that the step to `time` is done."""
        self.restore(self.step + 1, time)

    def restore(self, step: int, time: float) -> None:
        """Go on after `step` steps.

        Only what is told of the end is rounded to the case's: for the loads all steps are alike,
        so that a run that is prolonged has the bits of a longer one.
        """
        self.step = step
        self.time = self.end if step == self._steps else step * self._dt


class CourantClock:
    """Steps of a given Courant number; only `stops` and the end shorten them, evenly.

    Parameters
    ----------
    courant : float
        dt times the largest (c_p + |v_p|)/L.
    end : float
        End of the run.
    stops : tuple of float
        Times that are met exactly.
    """

    controlled = True

    def __init__(self, courant: float, end: float, stops: tuple[float, ...]) -> None:
        self._courant = courant
        self._stops = sorted({t for t in stops if 0.0 < t < end} | {end})
        self.end = end
        self.step = 0
        self.time = 0.0

    @property
    def finished(self) -> bool:
        """Whether the end is reached."""
        return self.time >= self.end

    def next(self, rate: float) -> tuple[float, float]:
        """Length of the next step and the time at its end; `rate` is (c + |v|)/L.

        Raises
        ------
        EndlessError
            If the steps have become so short that the run would never end.
        """
        stop = self._stops[bisect_right(self._stops, self.time)]
        left = stop - self.time
        if not left * rate < self._courant * MOST_STEPS:
            raise EndlessError(
                f"after step {self.step}, at time {self.time:.6g}, waves or particles have become "
                f"so fast, {rate:.3g} cells in a unit of time, that the end would take more than "
                f"{MOST_STEPS:.0e} steps: the solution has blown up\n"
                "  try: a smaller time.step: {courant: ...}, slower loading, finer cells"
            )
        # Rounding must not leave a sliver of a step before a stop.
        count = max(1, ceil(left * rate / self._courant * (1.0 - 1e-12)))
        dt = left / count
        return dt, stop if count == 1 else self.time + dt

    def advance(self, time: float) -> None:
        """Note that the step to `time` is done."""
        self.time = time
        self.step += 1

    def restore(self, step: int, time: float) -> None:
        """Go on after `step` steps, at `time`."""
        self.step, self.time = step, time


def clock_of(case: Case) -> FixedClock | CourantClock:
    """Clock of a case, at its begin."""
    time = case.time
    if isinstance(time.step, float | int):
        return FixedClock(float(time.step), float(time.end))
    return CourantClock(time.step.courant, float(time.end), case.output.at)
