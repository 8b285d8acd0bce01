"""Tearing on the grid: how far grips stretch a body, and where its particles lose each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.supports import AXES, Support, supports
from pgimp.scene.checks.warned import Warned, warned
from pgimp.schema.pages import page

if TYPE_CHECKING:
    from pgimp.case.schema import Case

Array = np.ndarray[Any, np.dtype[np.float64]]

#: Stretch at which a bar tore in a plane (`cases/hard/stretch.yaml`, and broader ones), and one to
#: warn at, by the fewest particles a cell along a direction; the last also for more.
_TORE = [(1.1, 1.05), (1.6, 1.5), (1.9, 1.8)]
_WIDE_TORE = [(1.1, 1.05), (1.7, 1.6), (2.5, 2.3), (3.2, 3.0)]
_JOINED_TORE = [(2.0, 1.8), (3.0, 2.7)]
_BEGINS = 1
#: Instants of a stage at which the ways of grips are compared.
_INSTANTS = 129


class Stretch(NamedTuple):
    """How far two supports stretch the part of a body between them."""

    #: Greatest change of their distance over the distance at the start; negative: compression.
    strain: float
    #: length, way: Their distance at the start, and how far it changes.
    length: float
    way: float
    time: float  #: When it is the greatest.
    axis: int  #: Direction.
    between: tuple[str, str]  #: The supports, the one that moves farther first.


def flows(material: Any) -> bool:
    """Whether a material is a liquid, a gas or loose soil, whose deformation has no end."""
    return bool(
        material.LIQUID or material.VOLUME_ONLY or material.RESTS or material.flow_speed > 0.0
    )


def tearing_stretch(case: Case, name: str) -> tuple[float, float] | None:
    """Stretch at which a body tears on the grid, and a lower one to warn at; None if it does not.

    Parameters
    ----------
    case : Case
        The case, or its stage.
    name : str
        A body of a material.
    """
    body = case.bodies[name]
    if body.formulation != "updated-lagrangian" or flows(case.materials[body.material]):
        return None
    method = case.method
    known = _JOINED_TORE if method.ends else _WIDE_TORE if method.wide else _TORE
    return known[min(*case.method.particles_per_cell, len(known)) - 1]


def advice(case: Case, name: str) -> str:
    """What keeps a body from tearing, and the page with the figures."""
    elastic = case.materials[case.bodies[name].material].ELASTIC
    ways = ["formulation: total-lagrangian, which never tears"] if elastic else []
    ways += [] if case.method.ends else ["method.shape: cpdi, to nearly 3 times"]
    ways += ["more particles a cell along the stretch"]
    return f"take {'; or '.join(ways)} ({page('hard-cases.md#reasons')})"


def particles_of(case: Case) -> str:
    """Shape and number of particles, as messages name what tears."""
    n = min(case.method.particles_per_cell)
    return f"{case.method.shape} and {n} particle{'s' * (n != 1)} a cell and direction"


def stretches(stages: Sequence[Case], body: BodyFacts) -> list[Stretch]:
    """Greatest extension and greatest compression of a body by its grips, over all stages.

    Faces and constraints that hold the same direction are compared in pairs. Not known are the
    ways of grips that forces move, and those of what turns.

    Parameters
    ----------
    stages : sequence of Case
        The cases of all stages.
    body : BodyFacts
        One of their bodies.
    """
    found = [
        one
        for case in stages
        if body.name in case.bodies and body.name not in case.staged.removed
        for one in _of_stage(case, body)
    ]
    ends = max(found, default=None), min(found, default=None)
    return [one for one, sign in zip(ends, (1, -1), strict=True) if one and sign * one.strain > 0]


def warnings(stages: Sequence[Case], body: BodyFacts) -> Iterator[Warned]:
    """Yield the warning of a body that its grips pull so far that it tears on the grid."""
    case = stages[0]
    limit = tearing_stretch(case, body.name)
    for one in stretches(stages, body):
        if limit and 1.0 + one.strain > limit[_BEGINS]:
            grip, other = one.between
            key = grip.replace("constraint ", "constraints.")
            yield warned(
                "tearing",
                f"{key}: it pulls '{body.name}' away from {other} by {one.way:.3g} along "
                f"{AXES[one.axis]} until t = {one.time:.4g}, to {1.0 + one.strain:.3g} times the "
                f"length {one.length:.3g} between them; with {particles_of(case)} bodies tear "
                f"from {limit[0]:g} times on, though no material breaks: {advice(case, body.name)}",
            )


def _of_stage(case: Case, body: BodyFacts) -> Iterator[Stretch]:
    times = np.linspace(case.staged.start, case.time.end, _INSTANTS)
    held = []
    for one in supports(case, body):
        ways = _ways(case, one, times)
        if ways is not None:
            held.append((one, ways))
    for axis in range(case.dimensions):
        for (low, first), (high, second) in permutations(held, 2):
            length = high.low[axis] - low.high[axis]
            if not (low.held[axis] and high.held[axis] and length > 0.0):
                continue
            apart = second[:, axis] - first[:, axis]
            for k in {int(apart.argmax()), int(apart.argmin())}:
                if apart[k]:
                    far = abs(second[k, axis]) >= abs(first[k, axis])
                    names = (high.name, low.name) if far else (low.name, high.name)
                    way, time = float(apart[k]), float(times[k])
                    yield Stretch(way / length, float(length), way, time, axis, names)


def _ways(case: Case, one: Support, times: Array) -> Array | None:
    """Displacement of a support from the start of the run, (instants, D); None if not known."""
    kind, _, name = one.name.partition(" ")
    if kind != "constraint":
        condition = case.boundaries[kind]
        # Some walls let go, or give way; what one that moves pulls along is its own no longer.
        if condition.approaches or condition.absorbs or hasattr(condition, "velocity"):
            return None
        return np.zeros((len(times), case.dimensions))
    entry: ConstraintEntry = case.constraints[name]
    if entry.rotation or any(f is not None for f in entry.force):
        return None
    before = np.array(case.staged.displacements.get(name, (0.0,) * case.dimensions))
    if entry.field:
        return _by_function(entry, np.add(one.low, one.high) / 2.0, times, before)
    rows = [[way or 0.0 for way in entry.displacement(float(t))] for t in times]
    return np.array(rows, float) + before


def _by_function(entry: ConstraintEntry, place: Array, times: Array, before: Array) -> Array | None:
    """Displacement by a function of one's own, of its velocity at a place; None if it fails."""
    assert entry.field is not None
    function, parameters = entry.field.registered, entry.field.source().parameters
    x = tuple(place.tolist())
    try:
        v = np.array(
            [
                function.function(
                    *({"x": x, "t": float(t)}[name] for name in function.given), *parameters
                )
                for t in times
            ],
            float,
        ).reshape(len(times), len(x))
    except Exception:  # it is meant for kernels, and what it can't do here a run shows
        return None
    steps = 0.5 * (v[1:] + v[:-1]) * np.diff(times)[:, None]
    return before + np.concatenate([np.zeros((1, len(x))), np.cumsum(steps, axis=0)])
