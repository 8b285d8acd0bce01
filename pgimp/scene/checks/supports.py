"""Supports of a body at the start, and its strain under its own weight."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.case.motion.moving_boxes import held_at
from pgimp.scene.checks.facts import BodyFacts
from pgimp.schema.tables import VectorFunction

if TYPE_CHECKING:
    from pgimp.case.schema import Case

AXES = "xyz"

#: Cells from a face with a condition within which a body counts as held by it.
_AT = 0.5
#: Part of the body's height that a constraint at its end must hold to clamp it.
_CLAMPED = 0.5


class Support(NamedTuple):
    """A held part of a body."""

    name: str
    #: low, high: Corners of its bounding box.
    low: tuple[float, ...]
    high: tuple[float, ...]
    held: tuple[bool, ...]  #: Directions in which the body is held there.


def supports(case: Case, body: BodyFacts) -> Iterator[Support]:
    """Yield the supports of a body: adjacent faces with a condition, and constraints.

    Parameters
    ----------
    body : BodyFacts
        One of its bodies.
    """
    grid = case.grid
    for face, condition in case.boundaries.items():
        if condition.joins:
            continue
        axis = AXES.index(face[0])
        low, high = list(body.low), list(body.high)
        if face.endswith("min"):
            side, away, high[axis] = -1, low[axis] - grid.origin[axis], low[axis]
        else:
            side, away, low[axis] = 1, grid.corner[axis] - high[axis], high[axis]
        if away <= _AT * grid.cell[axis]:
            held = held_at(condition, axis, side)[: case.dimensions]
            yield Support(face, tuple(low), tuple(high), held)
    for name, entry in case.constraints.items():
        if entry.body == body.name:
            ends = zip(*entry.region.bounds(), body.low, body.high, strict=True)
            box = [(max(a, low), min(b, high)) for a, b, low, high in ends]
            low, high = [a for a, _ in box], [b for _, b in box]
            held = entry.rigid
            yield Support(f"constraint {name}", tuple(low), tuple(high), held)


def greatest(load: object, dimensions: int) -> np.ndarray:
    """Greatest size over time of each component of a vector, constant or over time; (D,)."""
    if load is None:
        return np.zeros(dimensions)
    rows = [row for _, row in load.rows] if isinstance(load, VectorFunction) else [load]
    return np.abs(np.array(rows, float)).max(axis=0)


def own_weight(case: Case, body: BodyFacts) -> dict[str, float]:
    """Strains of a linear body under its weight, by a description of its support.

    As a column: rho g h/M with the wave modulus M. If clamped at the side, also as a cantilever:
    its end sinks by 1.5 rho g l^4/(E h^2). The strain at its root is 3 rho g l^2/(E h); with both
    ends clamped it is a sixth.

    Parameters
    ----------
    body : BodyFacts
        One of its bodies.
    """
    g, sizes = greatest(case.gravity, case.dimensions), body.sizes
    column = max(float(one) * size for one, size in zip(g, sizes, strict=True))
    found = {"": column / body.wave_speed**2}
    material = case.materials[case.bodies[body.name].material]
    young = getattr(material, "young", body.density * body.wave_speed**2)
    if "young" in body.varies:
        young = body.varies["young"][1]
    most, words = found[""], ""
    held = list(supports(case, body))
    for down in np.flatnonzero(g).tolist():
        weight, height = body.density * float(g[down]), sizes[down]
        for axis in range(case.dimensions):
            if axis == down:
                continue
            ends = _clamped(body, held, axis, down)
            if not ends:
                continue
            names, length = ends
            strain = 3.0 * weight * length**2 / (young * height)
            sag = 1.5 * weight * length**4 / (young * height**2)
            text = f" as a cantilever from {names[0]} (its end sinks by about {sag:.2g})"
            if len(names) > 1:
                strain, text = strain / 6.0, f" as a beam between {names[0]} and {names[1]}"
            if strain > most:
                most, words = strain, text
    if words:
        found = {words: most, " as a column": found[""]}
    return found


def _clamped(
    body: BodyFacts, held: list[Support], axis: int, down: int
) -> tuple[list[str], float] | None:
    """Names of the supports that clamp a body's ends along an axis, and its free length; else None.

    A body that rests on, or hangs from, something over most of its length is not clamped.
    """
    names: dict[int, str] = {}
    low, high = body.low[axis], body.high[axis]
    middle = 0.5 * (low + high)
    for one in held:
        if not one.held[down]:
            continue
        long = one.high[axis] - one.low[axis] > 0.5 * body.sizes[axis]
        tall = one.high[down] - one.low[down] >= _CLAMPED * body.sizes[down]
        if long:
            return None
        if not tall:
            continue
        if one.high[axis] <= middle:
            names[0], low = one.name, max(low, one.high[axis])
        elif one.low[axis] >= middle:
            names[1], high = one.name, min(high, one.low[axis])
    return ([names[end] for end in sorted(names)], high - low) if names else None
