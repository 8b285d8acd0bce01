"""Overlaps of a file's particles with each other, another body, or another file's particles.

Of two bodies only the common box is examined; without one, nothing is read. Only certain mistakes
are errors, such as the same file twice: bodies in contact may overlap a little.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.points.block import Block
from pgimp.geometry.regions.base import Bounds
from pgimp.scene.bodies.clouds.point_cloud import Cloud
from pgimp.scene.bodies.lattice_body import LatticeBody

Reals = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Allowed depth in another body, and least distance from another file's particle; over the size.
_DEEP, _CLOSE = 0.25, 0.1

#: Distance, over a lattice box, below which a file's particles coincide; most rows in a message.
_SAME, _NAMED = 1e-6, 10

#: Distances to parts of a region: most in total, and per block.
_LOOKS, _BLOCK = 100_000_000, 1_000_000

#: Hash multiplier, from the golden ratio: combines the numbers of a cell with few collisions.
_MIX = np.int64(0x1E3779B97F4A7C15)


class _CloudParticles(NamedTuple):
    """Particles of a file: their rows, positions (n, D) and volumes."""

    rows: Ints
    x: Reals
    volume: Reals


def overlaps(
    names: Sequence[str],
    bodies: Sequence[LatticeBody | Cloud],
    box: Sequence[float],
    planes: tuple[int, int],
    stages: Sequence[int],
) -> Iterator[tuple[tuple[int, int], str]]:
    """Yield the first overlap along x of each body from a file, and of each pair with one.

    Parameters
    ----------
    names, bodies : sequence
        All bodies.
    box : sequence of float
        Size of a box of the lattice by direction.
    planes : (int, int)
        Range of the lattice's planes to search; findings in a plane do not depend on it.
    stages : sequence of int
        The stage in which each body comes; a negative one: it does not matter.

    Yields
    ------
    (int, int), str
        The bodies' numbers, equal for a single body, and the problem as text, with the key.

    Raises
    ------
    CaseError
        If a file is no longer readable.
    """
    for a, cloud in enumerate(bodies):
        if stages[a] < 0 or not isinstance(cloud, Cloud):
            continue
        if found := _coincident(cloud, planes, _SAME * min(box)):
            yield (a, a), f"bodies.{names[a]}.region: {found}; leave all but one out of the file"
    clouds = [isinstance(each, Cloud) for each in bodies]
    from_files = [b for b, cloud in enumerate(clouds) if cloud]
    for a in range(len(bodies)):
        every = range(a + 1, len(bodies)) if clouds[a] else (b for b in from_files if b > a)
        others = (b for b in every if stages[a] == stages[b] >= 0)
        yield from _overlaps_of(a, others, names, bodies, box, planes)


def _overlaps_of(
    a: int,
    others: Iterable[int],
    names: Sequence[str],
    bodies: Sequence[LatticeBody | Cloud],
    box: Sequence[float],
    planes: tuple[int, int],
) -> Iterator[tuple[tuple[int, int], str]]:
    """As `overlaps`, of a body with others behind it, one of each pair from a file."""
    first = bodies[a]
    for b in others:
        second = bodies[b]
        low, high = _common(first.region.bounds(), second.region.bounds())
        if (low > high + min(box)).any() or planes[0] >= planes[1]:
            continue
        if isinstance(first, Cloud) and isinstance(second, Cloud):
            if _apart_in_run(first, second):
                continue
            found = _close(first, second, (low, high), planes, min(box))
        elif isinstance(first, Cloud):
            assert isinstance(second, LatticeBody)
            found = _inside(first, second, (low, high), planes, min(box), names[b])
        else:
            assert isinstance(second, Cloud)
            found = _inside(second, first, (low, high), planes, min(box), names[a])
        if found:
            yield (
                (a, b),
                f"bodies.{names[b]}.region: {found}: bodies '{names[a]}' and '{names[b]}' "
                "overlap; move or cut one of them, or leave such particles out of the file",
            )


def _apart_in_run(first: Cloud, second: Cloud) -> bool:
    """Whether both go on from one file of a run, in which they were two bodies."""
    one, other = first.region.summary.saved, second.region.summary.saved
    same = first.region.file == second.region.file
    return bool(same and one and other and one.number != other.number)


def _common(first: Bounds, second: Bounds) -> tuple[Reals, Reals]:
    """Corners of the intersection of two boxes; low above high where it is empty."""
    low, high = np.maximum(first[0], second[0]), np.minimum(first[1], second[1])
    return low, high


def _inside(
    cloud: Cloud,
    body: LatticeBody,
    box: tuple[Reals, Reals],
    planes: tuple[int, int],
    size: float,
    name: str,
) -> str:
    """Name the first particle that lies in a body on the lattice, called `name`."""
    here = _taken(cloud, box, planes, None)
    # Of many particles and parts only a sample is tested, the same on any number of ranks.
    some = here.rows % (1 + cloud.region.summary.number * body.region.parts // _LOOKS) == 0
    here = _CloudParticles(*(column[some] for column in here))
    found = [np.zeros(0, np.int64)]
    block = max(1, _BLOCK // body.region.parts)
    for begin in range(0, len(here.x), block):
        distance = body.region.distance(here.x[begin : begin + block])
        found.append(begin + np.flatnonzero(distance < -_DEEP * size))
    deep = np.concatenate(found)
    if len(deep) == 0:
        return ""
    i = deep[_first(here.x[deep])]
    where = "".join(cloud.region.lines([int(here.rows[i])]))
    return f"the particle at {_place(here.x[i])} ({where} of {cloud.region.file}) lies in '{name}'"


def _close(
    first: Cloud, second: Cloud, box: tuple[Reals, Reals], planes: tuple[int, int], size: float
) -> str:
    """Name the first two particles of two files at nearly the same position."""
    reach = _CLOSE * size
    wide = (box[0] - reach, box[1] + reach)
    one, other = (_taken(cloud, wide, planes, 4.0 * reach) for cloud in (first, second))
    if len(one.x) == 0 or len(other.x) == 0:
        return ""
    x = np.concatenate([one.x, other.x])
    # Files may be finer than the lattice.
    limit = _CLOSE * np.concatenate([one.volume, other.volume]) ** (1.0 / x.shape[1])
    limit = np.minimum(limit, reach)
    found = []
    for left, right in _pairs(x, reach):
        # The first body's particles precede the second's.
        apart = (left < len(one.x)) & (right >= len(one.x))
        left, right = left[apart], right[apart]
        away = np.sqrt(np.square(x[left] - x[right]).sum(axis=1))
        close = away < np.minimum(limit[left], limit[right])
        close &= first.between(x[left, 0], planes)
        if close.any():
            left, right = left[close], right[close]
            k = _first(x[left])
            found.append((left[k], right[k]))
    if not found:
        return ""
    i, j = found[_first(x[[pair[0] for pair in found]])]
    pair_of = [
        f"{''.join(cloud.region.lines([int(row)]))} of {cloud.region.file}, at {_place(at)}"
        for cloud, row, at in (
            (first, one.rows[i], x[i]),
            (second, other.rows[j - len(one.x)], x[j]),
        )
    ]
    return f"two particles are at nearly the same place ({'; '.join(pair_of)})"


def _coincident(cloud: Cloud, planes: tuple[int, int], limit: float) -> str:
    """Name the particles of a file at the first shared position.

    Only zero distance between particles of a file is an error: how they were made is unknown.
    """
    if planes[0] >= planes[1]:
        return ""
    here = _taken(cloud, cloud.region.bounds(), planes, 4.0 * limit)
    shared = [np.zeros(0, np.int64)]
    for left, right in _pairs(here.x, limit):
        same = np.sqrt(np.square(here.x[left] - here.x[right]).sum(axis=1)) < limit
        shared.append(left[same & cloud.between(here.x[left, 0], planes)])
    some = np.unique(np.concatenate(shared))
    if len(some) == 0:
        return ""
    x = here.x[some[_first(here.x[some])]]
    rows = np.sort(here.rows[np.sqrt(np.square(here.x - x).sum(axis=1)) < limit])
    lines = ", ".join(cloud.region.lines(rows[:_NAMED].tolist()))
    more = f" and {len(rows) - _NAMED:,} more" if len(rows) > _NAMED else ""
    return f"{len(rows):,} particles of {cloud.region.file} are at {_place(x)}: {lines}{more}"


def _pairs(x: Reals, reach: float) -> Iterator[tuple[Ints, Ints]]:
    """Yield pairs of rows, the lower row first, including all points closer than `reach`.

    The points are sorted into cells of twice that size, on lattices that are shifted by half a cell
    in every combination of directions. Two points so close share a cell of at least one lattice.
    Of many points in a cell, each is paired with its neighbour in the list.
    """
    for shift in product((0.0, 0.5), repeat=x.shape[1]):
        # One hash per cell; where two cells have the same, the distance decides.
        cell = np.zeros(len(x), np.int64)
        for d, by in enumerate(shift):
            along = np.floor(x[:, d] / (2.0 * reach) + by).astype(np.int64)
            cell = cell * _MIX + along
        order = np.argsort(cell, kind="stable")
        left, right = order[:-1], order[1:]
        same = cell[left] == cell[right]
        yield left[same], right[same]


def _taken(
    cloud: Cloud, box: Bounds | tuple[Reals, Reals], planes: tuple[int, int], beyond: float | None
) -> _CloudParticles:
    """Particles in a box and in a range of planes, or up to a distance beyond these along x."""
    edges = cloud.edges[0]

    def near(block: Block) -> NDArray[np.bool_]:
        x = np.ascontiguousarray(block.position[:, 0])
        inside = (box[0][0] <= x) & (x <= box[1][0])
        if beyond is None:
            return inside & cloud.between(x, planes)
        return inside & (edges[planes[0]] - beyond <= x) & (x <= edges[planes[1]] + beyond)

    parts = [_CloudParticles(np.zeros(0, np.int64), np.zeros((0, len(cloud.edges))), np.zeros(0))]
    for rows, block in cloud.region.chosen(near):
        keep = ((box[0] <= block.position) & (block.position <= box[1])).all(axis=1)
        parts.append(_CloudParticles(rows[keep], block.position[keep], block.volume[keep]))
    return _CloudParticles(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _first(x: Reals) -> int:
    """Row of the first point by x, then y, then z; of equal points the first row."""
    rows = np.arange(len(x))
    for along in x.T:
        rows = rows[along[rows] == along[rows].min()]
    return int(rows[0])


def _place(x: Reals) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in x) + ")"
