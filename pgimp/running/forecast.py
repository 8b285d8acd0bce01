"""Size of a run's output, and warnings of output requested for times beyond its end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import floor
from typing import TYPE_CHECKING, Any

from pgimp.case.output import WallTime
from pgimp.physics.fields import ALWAYS, Field
from pgimp.scene.checks.warned import Warned, warned
from pgimp.schema.base import Steps

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Tolerance, relative to the interval, within which the end is a multiple of it.
_ROUNDING = 1e-9
#: A number of frames that is probably a mistake.
_MANY = 10_000


def frames(case: Case, steps: float, settling: Sequence[float] = ()) -> int:
    """Number of frames of a run of `steps` steps, including the first and the last.

    `settling` are the steps in which its stages come to rest. Of the start these write none.
    """
    last = case.time.last
    times = {0.0, *case.output.at, *(stage.time.end for stage in case.stages)}
    between = 0.0
    for stage in case.stages:
        length = stage.time.end - stage.staged.start
        every = stage.output.every
        between += _between(every, length, steps * length / last)
        if isinstance(every, Steps) and stage.staged.number and settling:
            between += settling[stage.staged.number] // every.steps
    rests = sum(stage.rests for stage in case.stages)  # a frame more at the same time
    return int(min(steps + sum(settling[1:]) + 1, len(times) + between)) + rests


def frame_size(case: Case, fields: Mapping[str, Field], particles: int) -> float:
    """Bytes of a frame of particles, uncompressed; `fields` are all known fields."""
    real = 4 if case.output.precision == "float32" else 8
    total = 0
    for field in (*ALWAYS.values(), *(fields[name] for name in case.output.fields)):
        width = real if field.dtype == "<f8" else int(field.dtype[-1])
        total += width * max(1, field.columns)
    return float(total) * particles


def _between(every: Any, end: float, steps: float) -> float:
    """Number of times an interval ends before the end of the run."""
    if every is None:
        return 0.0
    many = steps / every.steps if hasattr(every, "steps") else end / every
    if many > steps:
        return max(0.0, steps - 1.0)
    return max(0.0, float(floor(many * (1.0 - _ROUNDING))))


def warnings(case: Case, steps: float) -> Iterator[Warned]:
    """Yield warnings of requests without effect: intervals of output that end after the run.

    Parameters
    ----------
    steps : float
        Approximate number of steps.
    """
    ends = "at the start and at the end"
    requested = [
        ("output.every", case.output.every, f"frames only {ends}"),
        ("checkpoint.every", case.checkpoint.every, "no checkpoints but the last"),
    ]
    # The default interval of lines may exceed a short run.
    if "every" in case.history.model_fields_set:
        requested.append(("history.every", case.history.every, f"lines only {ends}"))
    for name, probe in case.probes.items():
        requested.append((f"probes.{name}.every", probe.every, f"lines only {ends}"))
    end = case.time.last
    # Nobody knows the number of steps to rest before. They count, but those of the start write
    # checkpoints alone.
    rests = [stage.start.equilibrate is not None for stage in case.stages]
    for key, every, what in requested:
        if every is None or isinstance(every, WallTime):
            continue
        settles = any(rests if key == "checkpoint.every" else rests[1:])
        if settles and isinstance(every, Steps):
            continue
        count = every.steps if isinstance(every, Steps) else 0
        if not isinstance(every, Steps) and every > end * (1.0 + _ROUNDING):
            text = f"{every:g} is beyond the end at {end:g}"
        elif count > steps:
            text = f"{count:,} steps are more than the run takes, about {steps:,.0f}"
        else:
            continue
        yield warned("idle-interval", f"{key}: {text}; there are {what}")
    number = frames(case, steps)
    if number > _MANY:
        yield warned(
            "many-frames",
            f"output.every: {number:,} frames; is it in the unit of time that time.end is in?",
        )


def notes(case: Case, steps: float) -> Iterator[str]:
    """Yield intervals of output that are shorter than steps; parameters as of `warnings`."""
    dt = case.time.last / max(steps, 1.0)
    requested = [("output.every", case.output.every, "frames")]
    if "every" in case.history.model_fields_set:
        requested.append(("history.every", case.history.every, "lines"))
    for name, probe in case.probes.items():
        requested.append((f"probes.{name}.every", probe.every, "lines"))
    for key, every, what in requested:
        if isinstance(every, float | int) and every < dt * (1.0 - _ROUNDING):
            yield (
                f"{key}: {every:g} is shorter than a step, about {dt:.3g}: {what} come at the ends "
                "of steps, fewer and at uneven times; take {steps: 1}, or a shorter time.step"
            )
