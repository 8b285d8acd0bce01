"""The time that each phase of a step takes."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, thread_time


def stopwatch(timings: dict[str, float], worked: dict[str, float]) -> Callable[[str], None]:
    """Return a function that adds the time since its last call to a phase.

    Parameters
    ----------
    timings : dict of str to float
        Seconds by phase.
    worked : dict of str to float
        CPU seconds; the same dictionary where ranks share no cores.
    """
    last, apart = perf_counter(), worked is not timings
    last_own = thread_time() if apart else 0.0

    def lap(phase: str) -> None:
        nonlocal last, last_own
        now = perf_counter()
        timings[phase] += now - last
        last = now
        if apart:
            own = thread_time()
            worked[phase] += own - last_own
            last_own = own

    return lap
