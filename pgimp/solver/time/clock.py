"""Time: fixed steps, or steps from the Courant number."""

from bisect import bisect_right
from math import ceil, inf, isfinite
from typing import NamedTuple

from pgimp.case.schema import Case
from pgimp.case.stepping.courant import vertex_limit
from pgimp.case.stepping.steps import AUTO
from pgimp.errors import EndlessError
from pgimp.solver.time.held_rate import HeldRate
from pgimp.solver.time.stability import BLOWN_UP, BLOWN_UP_STEPS, MOST_STEPS


class Step(NamedTuple):
    """A step: its number, from 1, its beginning, length and end; number 0 is the start of a run."""

    number: int
    start: float
    dt: float
    end: float


#: The step before the first one.
START = Step(0, 0.0, 0.0, 0.0)


class FixedClock:
    """Steps of one length: t = begin + n * step, never a running sum.

    Parameters
    ----------
    step, end : float
        Length of a step and end of the run, a whole number of steps after `begin`.
    begin, before : float, int
        Time from which these steps are counted, and number of steps before it.
    """

    controlled = False
    held = None
    #: Factor on the length of steps, see `pgimp.solver.time.energy_watch`; below 1 only while time
    #: stands still.
    part = 1.0

    def __init__(self, step: float, end: float, begin: float = 0.0, before: int = 0) -> None:
        self._dt = step
        self._begin, self.before = begin, before
        self._steps = before + round((end - begin) / step)
        self.end = end

    def finished(self, done: Step) -> bool:
        """Whether the end is reached."""
        return done.number >= self._steps

    def follow(self, rate: float) -> float:
        """Return `rate`, which has no effect here."""
        return rate

    def next(self, done: Step, rate: float) -> Step:
        """Return the step after `done`."""
        n = done.number
        return Step(n + 1, self._after(n), self._dt, self._after(n + 1))

    def _after(self, n: int) -> float:
        """Time after `n` steps."""
        return self._begin + (n - self.before) * self._dt

    def after(self, number: int, time: float, dt: float) -> Step:
        """Return the last step of a run that is resumed after `number` steps."""
        return Step(number, self._after(number - 1), dt, self._after(number))

    def time(self, done: Step) -> float:
        """Return the reported time at the end of a step.

        The last step reports the case's end exactly. Loads are taken at n dt, so that a prolonged
        run has the bits of a longer one.
        """
        return self.end if done.number == self._steps else done.end


class CourantClock:
    """Steps of a given Courant number; only `stops` and the end shorten them, evenly.

    They shorten at once and lengthen rarely, see `pgimp.solver.time.held_rate`.

    Parameters
    ----------
    courant : float
        dt times the largest (c_p + |v_p|)/L.
    end : float
        End of the run.
    stops : tuple of float
        Times that are met exactly.
    rest_rate : float
        The largest c_p/L at rest; 0 or inf where it limits nothing.
    """

    controlled = True
    before = 0

    def __init__(
        self, courant: float, end: float, stops: tuple[float, ...], rest_rate: float = inf
    ) -> None:
        #: Reduction of the Courant number, see `pgimp.solver.time.energy_watch`.
        self.part = 1.0
        #: The rate of the steps.
        self.held = HeldRate()
        self._courant, self.rest_rate = courant, rest_rate or inf  # 0: dust, a gas at rest
        self._stops = sorted({t for t in stops if 0.0 < t < end} | {end})
        self.end = end

    def finished(self, done: Step) -> bool:
        """Whether the end is reached."""
        return done.end >= self.end

    def follow(self, rate: float) -> float:
        """Return the rate for the next step; once a step."""
        return self.held.follow(rate)

    def next(self, done: Step, rate: float) -> Step:
        """Return the step after `done`; `rate` is (c + |v|)/L, as held.

        Raises
        ------
        EndlessError
            If the steps have become so short that the run would never end.
        """
        start = done.end
        stop = self._stops[bisect_right(self._stops, start)]
        left = stop - start
        courant = self._courant * self.part
        steps = (self.end - start) * rate / courant
        if not steps < (BLOWN_UP_STEPS if rate > BLOWN_UP * self.rest_rate else MOST_STEPS):
            raise EndlessError(
                f"after step {done.number}, at time {start:.6g}, waves or particles have become "
                f"so fast, {rate:.3g} cells in a unit of time ({self.rest_rate:.3g} at rest), "
                f"that the end would take {steps:.0e} steps more: the solution has blown up\n"
                "  try: a smaller time.step: {courant: ...}, slower loading, finer cells"
            )
        # Rounding must not leave a tiny step before a stop.
        count = max(1, ceil(left * rate / courant * (1.0 - 1e-12)))
        dt = left / count
        return Step(done.number + 1, start, dt, stop if count == 1 else start + dt)

    def after(self, number: int, time: float, dt: float) -> Step:
        """Return the last step of a run that is resumed after `number` steps, at `time`."""
        return Step(number, time - dt, dt, time)

    def time(self, done: Step) -> float:
        """Return the reported time at the end of a step."""
        return done.end


class StandingClock(FixedClock):
    """Steps of one length while a run comes to rest: simulated time stands still."""

    def finished(self, done: Step) -> bool:
        """Whether the end is reached, if the stage is at rest."""
        return True

    def next(self, done: Step, rate: float) -> Step:
        """Return the step after `done`."""
        return self.after(done.number + 1, self.end, self.part * self._dt)

    def after(self, number: int, time: float, dt: float) -> Step:
        """Return the last step of a run that is resumed after `number` steps."""
        return Step(number, self.end, dt, self.end)


class StandingCourantClock(CourantClock):
    """Steps of a given Courant number while a run comes to rest; see `StandingClock`.

    Parameters
    ----------
    courant, rest_rate : float
        As of `CourantClock`.
    end, before : float, int
        Time of the stage, and number of steps before it.
    longest : float
        Length of steps where there are no waves.
    """

    def __init__(
        self, courant: float, end: float, rest_rate: float, before: int, longest: float
    ) -> None:
        super().__init__(courant, end, (), rest_rate)
        self.before, self._longest = before, longest

    def finished(self, done: Step) -> bool:
        """Whether the end is reached, if the stage is at rest."""
        return True

    def next(self, done: Step, rate: float) -> Step:
        """Return the step after `done`.

        Raises
        ------
        EndlessError
            If the solution has blown up.
        """
        if not rate <= BLOWN_UP * self.rest_rate:
            raise EndlessError(
                f"after step {done.number}, at time {self.end:.6g}, waves or particles have become "
                f"so fast, {rate:.3g} cells in a unit of time ({self.rest_rate:.3g} at rest), "
                "that there is no rest: the solution has blown up\n"
                "  try: a smaller time.step: {courant: ...}, smaller loads, finer cells"
            )
        courant = self._courant * self.part
        longest = inf if rate > 0.0 and isfinite(self.rest_rate) else self._longest
        dt = courant / rate if courant < rate * longest else longest
        return self.after(done.number + 1, self.end, dt)

    def after(self, number: int, time: float, dt: float) -> Step:
        """Return the last step of a run that is resumed after `number` steps."""
        return Step(number, self.end, dt, self.end)


def settling_clock(
    case: Case, rest_rate: float = inf, before: int = 0
) -> StandingClock | StandingCourantClock:
    """Clock of a start, or a stage, that comes to rest; arguments as in `clock_of`.

    Time stands still: with all bodies in the initial configuration steps are as long as is stable,
    those of `courant: auto`. Long steps disturb free surfaces in the current configuration, where
    they stay what they are; so do fixed ones.
    """
    end = case.staged.start
    if isinstance(case.time.step, float | int):
        return StandingClock(float(case.time.step), end, case.staged.counted, before)
    courant, limit = case.courant, vertex_limit(case)
    assert courant is not None
    if limit is not None:
        courant = AUTO * limit
    return StandingCourantClock(courant, end, rest_rate, before, float(case.time.end))


def clock_of(case: Case, rest_rate: float = inf, before: int = 0) -> FixedClock | CourantClock:
    """Clock of a case, or of a stage of one.

    Parameters
    ----------
    rest_rate : float
        The largest c_p/L of its materials at rest.
    before : int
        Number of steps before the first of its steps, for a stage.
    """
    time = case.time
    if case.rests:
        return settling_clock(case, rest_rate, before)
    if isinstance(time.step, float | int):
        return FixedClock(float(time.step), float(time.end), case.staged.counted, before)
    assert case.courant is not None
    return CourantClock(case.courant, float(time.end), case.output.at, rest_rate)
