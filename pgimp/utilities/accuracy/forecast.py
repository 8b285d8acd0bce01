"""What a run will cost, from what its companions cost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil
from pathlib import Path
from typing import NamedTuple

from pgimp.io.rundir import runinfo
from pgimp.io.rundir.ownfiles import RUN
from pgimp.running.progress import duration
from pgimp.running.stop import clock
from pgimp.utilities.accuracy.estimate import edges


class Cost(NamedTuple):
    """The cost of a companion: particles, steps, and seconds of its steps."""

    particles: float
    steps: float
    seconds: float


def cost_of(path: Path) -> Cost | None:
    """Return the cost of a run that is done, over all its starts; None if it is not known."""
    content = runinfo.read(path / RUN)
    starts = content["starts"] if content else []
    seconds = [one.get("seconds") for one in starts]
    if not starts or any(one is None for one in seconds) or not starts[-1]["steps"]:
        return None
    particles, steps = starts[-1].get("particles") or 0, starts[-1]["steps"]
    return Cost(float(particles), float(steps), float(sum(seconds)))


def seconds_of(known: Sequence[tuple[float, Cost]], dimensions: int) -> float | None:
    """Return the seconds of the steps of a run.

    A step costs a time of its own, and one for each particle. Both follow from two companions; of
    one alone all goes with the particles.

    Parameters
    ----------
    known : sequence of (float, Cost)
        Cells over those of the run, and cost, of its companions.
    """
    if not known:
        return None
    (ratio, fine), *more = sorted(known, key=lambda one: one[0])
    step = fine.seconds / fine.steps
    each = step / max(fine.particles, 1.0)
    if more and fine.particles > more[0][1].particles:
        coarse = more[0][1]
        slope = (step - coarse.seconds / coarse.steps) / (fine.particles - coarse.particles)
        if 0.0 < slope < each:
            each = slope
    fixed = step - each * fine.particles
    return fine.steps * ratio * (fixed + each * fine.particles * ratio**dimensions)


def foretold(path: Path, ranks: int, limit: float) -> Iterator[str]:
    """Yield what ``--forecast`` has left in a run directory, for a job.

    Parameters
    ----------
    path : Path
        The run directory, which need not exist.
    ranks, limit : int, float
        Ranks of the job, and its time in seconds.
    """
    content = runinfo.read(path / RUN)
    known = content["starts"][-1].get("forecast") if content else None
    try:
        assert isinstance(known, dict)
        seconds, most = (
            float(known[key]) * int(known["ranks"]) / ranks
            for key in ("seconds", "most" if "most" in known else "seconds")
        )
        cells = edges([float(cell) for cell in known["cell"]])
    except (AssertionError, KeyError, TypeError, ValueError):
        return

    def jobs(seconds: float) -> str:
        count = max(1, ceil(seconds / limit))
        return f"{count} job{'s' * (count > 1)} of {clock(limit)}"

    yield (
        f"{path} has a forecast: cells of {cells}, {duration(seconds)} on {ranks} "
        f"rank{'s' * (ranks > 1)} if they share the work evenly: {jobs(seconds)}"
    )
    if most > seconds:
        yield (
            f"if its own error is then more than asked for, it runs once more, for "
            f"{duration(most)} at most: {jobs(most)}"
        )
