"""How far a case moves in stages with `equilibrate`: what slid, and rests as a heap, is told."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from pgimp.case.checks.periodic import periodic_axes
from pgimp.case.schema import Case
from pgimp.errors import RunError
from pgimp.io.results.frame import Frame
from pgimp.io.results.reader import Run
from pgimp.utilities.study.bisect_entry import CELLS, Bisection

#: State in run.json of a run that has reached its end; of an outcome, too.
DONE = "done"
Fields = Frame | Mapping[str, np.ndarray]


def stage_of(entry: Bisection) -> int:
    """Return the number of the first stage that the key changes; 0 if it changes the whole case."""
    parts = entry.key.split(".")
    if parts[:2] == ["time", "stages"] and len(parts) > 2 and parts[2].isdecimal():
        return int(parts[2]) + 1
    return 0


def watched(entry: Bisection, case: Case) -> list[int]:
    """Return the numbers of the stages whose displacements count: those that the key changes.

    None before time 0, where displacements begin anew.
    """
    first = stage_of(entry)
    return [number for number, one in enumerate(case.stages) if one.rests and number >= first]


def unwatched(entry: Bisection, case: Case) -> bool:
    """Whether the case may slide unseen: before time 0, by a key that acts there."""
    return not watched(entry, case) or (stage_of(entry) == 0 and case.start.equilibrate is not None)


def limit(entry: Bisection, case: Case) -> float | None:
    """Return the greatest displacement of a case at rest; None if any is one."""
    return (
        CELLS * min(case.grid.cell)
        if entry.failure_displacement == "auto"
        else entry.failure_displacement
    )


def known(entry: Bisection, case: Case, info: Mapping[str, Any]) -> bool:
    """Whether run.json has the steps at which the stages began, as older runs have not."""
    steps = info.get("stages") or []
    numbers = watched(entry, case)
    if info.get("state") != DONE:
        numbers = [number for number in numbers if number <= len(steps)]
    return all(number <= len(steps) and steps[number - 1] is not None for number in numbers)


def slid(entry: Bisection, run: Run, way: float | None) -> float | None:
    """Return the limit that the displacement of a run at rest is above; None if it is not."""
    most = limit(entry, run.case)
    return most if run.state == DONE and most is not None and (way or 0.0) > most else None


def moved(entry: Bisection, run: Run) -> float | None:
    """Return the greatest displacement of a particle in a stage that settles.

    It is that between the frames at both ends of the stage; in a run that has found no rest, to
    its end.

    Parameters
    ----------
    entry : Bisection
        Of the study.
    run : Run
        Which has ended.

    Returns
    -------
    float or None
        None if the run has not come to such a stage.

    Raises
    ------
    RunError
        If a frame is missing.
    """
    info, case = run.info, run.case
    begun = [0, *(info.get("stages") or [])]
    ends = [*begun[1:], info["steps"]]
    frames = {frame.step: frame for frame in run}
    found = []
    for number in watched(entry, case):
        if number >= len(begun):
            break
        try:
            first, last = frames[begun[number]], frames[ends[number]]
        except KeyError as error:
            raise RunError(f"{run.path} has no frame of step {error}, where a stage ends") from None
        found.append(greatest(first, last, case))
    return max(found, default=None)


def greatest(first: Fields, last: Fields, case: Case) -> float:
    """Return the greatest displacement of a particle between two frames.

    Particles of bodies that have come between them count where `displacement` tells their way;
    what has left does not.

    Parameters
    ----------
    first, last : Frame or mapping of str to ndarray
        With `id` and `position`, or `displacement`.
    case : Case
        Its periodic faces: without `displacement` the shortest way across them is taken.
    """
    told = "displacement" in first and "displacement" in last
    name = "displacement" if told else "position"
    joined: Iterable[int] = () if told else periodic_axes(case.boundaries)
    ids, old = np.asarray(last["id"]), np.asarray(first["id"])
    _, rows, before = np.intersect1d(ids, old, assume_unique=True, return_indices=True)
    way = np.array(last[name], dtype=float)
    way[rows] -= np.asarray(first[name], dtype=float)[before]
    if not told:
        way = way[rows]
    for axis in joined:
        size = case.grid.size[axis]
        way[:, axis] -= size * np.round(way[:, axis] / size)
    return float(np.sqrt(np.square(way).sum(axis=1).max(initial=0.0)))
