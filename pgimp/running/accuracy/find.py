"""Indicators of a run, from its files and its case; and of a case before it runs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.case.choices.facts import kind_of
from pgimp.case.motion.moving_boxes import held_at
from pgimp.errors import PgimpError
from pgimp.geometry.regions.ball import Ball
from pgimp.geometry.regions.box import Box
from pgimp.io.results.history import read_sums
from pgimp.running.accuracy.books import edited_functions, energy_book, momentum_books
from pgimp.running.accuracy.particles import BodyState, body_states
from pgimp.running.accuracy.rules import RULES, Indicator
from pgimp.running.accuracy.thickness import thickness
from pgimp.scene.checks.locking import locked
from pgimp.scene.checks.validity.tearing import flows
from pgimp.solver.time.stability import stable_courant

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.io.results.frame import Frame
    from pgimp.io.results.reader import Run

Array = np.ndarray
Boxes = Mapping[str, tuple[Sequence[float], Sequence[float]]]

#: Energy set in motion over the greatest, from which a loss is compared with both.
_TO_AND_FRO = 2.0
#: Cells from a face within which a body lies at it.
_AT = 0.5
AXES = "xyz"


def of_run(run: Run, case: Case | None = None) -> list[Indicator]:
    """Return what the files of a run show of its accuracy, also while it goes on.

    Parameters
    ----------
    run : Run
        Its directory.
    case : Case, optional
        Its case, if known already.

    Raises
    ------
    PgimpError
        If a file cannot be read.
    """
    case = run.case if case is None else case
    history = read_sums(run.path / "history.csv", case.dimensions)
    last = case.stages[-1]
    edited = edited_functions(run.starts)
    found = [
        *of_history(case, history, edited),
        *of_case(last, boxes_of(case), run.info.get("courant")),
    ]
    frames = run.frames
    if frames:
        found += of_frames(last, history, [frames[len(frames) // 2], frames[-1]])
    return found


def of_history(case: Case, history: Array, edited: Collection[str] = ()) -> Iterator[Indicator]:
    """Yield the indicators of a history; for `edited` see `edited_functions`."""
    names = history.dtype.names or ()
    if not len(history):
        return
    if "error" in names and np.isfinite(history["error"][-1]):
        # Not the greatest: the stress to which it refers may have begun at zero.
        yield Indicator("error", float(history["error"][-1]))
    if book := energy_book(history):
        lost = np.nan_to_num(book.lost)
        if book.gained > 0.0:
            yield Indicator("gained", book.gained)
        part, of = max(float(lost[-1]), 0.0), ""
        if part > 0.0 and book.moved > _TO_AND_FRO * book.scale:
            share = RULES["lost"].number(part * book.scale / book.moved)
            of = f", {share} of what was set in motion"
        yield Indicator("lost", part, of=of)
    if case.time.mass_scaling != 1.0 and float(history["strain-energy"][-1]) > 0.0:
        part = float(history["kinetic-energy"][-1]) / float(history["strain-energy"][-1])
        yield Indicator("inertia", part)
    books, _ = momentum_books(case, history, edited)
    scale = max((book.scale for book in books), default=0.0)
    if scale > 0.0:
        yield Indicator("momentum", max(abs(book.rest) for book in books) / scale)
    past = [history[name] for name in names if name.startswith("overlap-mass.")]
    mass = np.asarray(history["mass"], float)
    if past and (mass > 0.0).any():
        most = np.max(np.nan_to_num(past), axis=0)[mass > 0.0] / mass[mass > 0.0]
        yield Indicator("walls", float(most.max()))
    for name in names:
        if carried := re.fullmatch(r"volume\.(.*)\.particles", name):
            fills, holds = history[f"volume.{carried[1]}"], history[name]
            known = np.isfinite(fills) & (np.nan_to_num(holds) > 0.0)
            if known.any():
                ratio = float(fills[known][-1] / holds[known][-1])
                yield Indicator("volume", abs(ratio - 1.0), carried[1])


def boxes_of(case: Case) -> dict[str, tuple[Sequence[float], Sequence[float]]]:
    """Return the corners of the bodies' regions; none of particles from files."""
    found = {}
    for name, body in case.bodies.items():
        try:
            low, high = body.region.bounds()
        except (AttributeError, OSError, PgimpError):
            continue
        if np.isfinite([*low, *high]).all():
            found[name] = (low, high)
    return found


def of_case(case: Case, boxes: Boxes, courant: Any = None) -> Iterator[Indicator]:
    """Yield the indicators that are known before a run.

    Parameters
    ----------
    case : Case
        The case, or its stage.
    boxes : mapping
        Low and high corner of each body.
    courant : float, optional
        Courant number of the first of fixed steps; by default that of the case.
    """
    courant = case.courant if case.courant is not None else courant
    if isinstance(courant, float | int) and courant > 0.0 and not case.watched:
        yield Indicator("step", float(courant) / stable_courant(case))
    for name, (low, high) in boxes.items():
        across = _cells_across(case, np.array(low, float), np.array(high, float))
        region = case.bodies[name].region
        if case.dimensions > 1 and not isinstance(region, Ball | Box):
            across = min(across, thickness(case, region, _going_on(case)))
        if np.isfinite(across):
            yield Indicator("cells", across, name)
    for name, ratio in locked(case):
        yield Indicator("locked", ratio, name)
    if any(body.formulation == "updated-lagrangian" for body in case.bodies.values()):
        if not case.method.ends and not case.method.is_point:
            yield Indicator("per-cell", float(min(case.method.particles_per_cell)))


def _cells_across(case: Case, low: Array, high: Array) -> float:
    """Cells across the thinnest direction of a body; inf if it reaches from face to face in all.

    At a face that holds only the velocity into it, and at the axis of rings, it goes on beyond.
    """
    least = np.inf
    for axis in range(case.dimensions):
        cell = case.grid.cell[axis]
        gaps = low[axis] - case.grid.origin[axis], case.grid.corner[axis] - high[axis]
        on = [_goes_on(case, axis, side) for side, gap in enumerate(gaps) if gap <= _AT * cell]
        held = [each for each in on if each is not None]
        if len(held) < 2:
            across = float(high[axis] - low[axis]) / cell
            least = min(least, 2.0 * across if any(held) else across)
    return least


def _going_on(case: Case) -> Array:
    """Faces beyond which bodies go on, (D, 2) bool; see `_goes_on`."""
    return np.array(
        [[bool(_goes_on(case, axis, side)) for side in (0, 1)] for axis in range(case.dimensions)]
    )


def _goes_on(case: Case, axis: int, side: int) -> bool | None:
    """Whether a body at a face goes on beyond it, mirrored or repeated; None at an open face."""
    condition = case.boundaries.get(f"{AXES[axis]}-{('min', 'max')[side]}")
    if condition is None:
        return True if case.axisymmetric and (axis, side) == (0, 0) else None
    if condition.joins:
        return True
    held = held_at(condition, axis, 2 * side - 1)[: case.dimensions]
    return not condition.approaches and sum(held) == 1


def of_frames(case: Case, history: Array, frames: Sequence[Frame]) -> list[Indicator]:
    """Return the indicators of frames; the last one is the present state.

    Raises
    ------
    RunError
        If a frame cannot be read.
    """
    different = {frame.number: frame for frame in frames}
    states = [body_states(case, frame) for frame in different.values()]
    if not states:
        return []
    found = [one for state in states[-1] for one in _stretched(case, state)]
    for state in states[-1]:
        # Where a body is almost free of stress at the end, another time tells more.
        every = [one for other in states for one in other if one.name == state.name]
        loaded = max(every, key=lambda one: one.square)
        fluid = state.name in case.bodies and _flows(case, state.name)
        if np.isfinite(loaded.within_cells):
            name = "noise" if fluid else "checkerboard"
            found.append(Indicator(name, loaded.within_cells, state.name))
        frozen = _frozen(history, state)
        if np.isfinite(frozen) and not fluid and _is_current(case, state.name):
            found.append(Indicator("locked-in", frozen, state.name))
    return found


def _flows(case: Case, name: str) -> bool:
    return flows(case.materials[case.bodies[name].material])


def _is_current(case: Case, name: str) -> bool:
    return name in case.bodies and case.bodies[name].formulation == "updated-lagrangian"


def _stretched(case: Case, state: BodyState) -> Iterator[Indicator]:
    """Yield the indicators of the deformation of a solid."""
    if not np.isfinite(state.stretch) or _flows(case, state.name) or state.name not in case.bodies:
        return
    strain = max(state.stretch - 1.0, 1.0 - state.squeeze, 0.0)
    if not _is_current(case, state.name):
        if kind_of(case.materials[case.bodies[state.name].material]) == "metal":
            yield Indicator("flowed", strain, state.name)
        return
    if not case.method.ends:
        yield Indicator("stretch", state.stretch, state.name)
    if case.method.keeps_size:
        yield Indicator("size", strain, state.name)


def _frozen(history: Array, state: BodyState) -> float:
    """Upper bound of a body's locked-in energy, over the run's: what of it varies within cells."""
    column = f"body.{state.name}.strain-energy"
    book = energy_book(history)
    if book is None or column not in (history.dtype.names or ()):
        return np.nan
    return state.within_cells * float(history[column][-1]) / book.scale
