"""Where the particles of a file lie in another body, or on those of another file.

Only what lies in the common box of two bodies is looked at; where there is none, nothing is read.
What is refused is a mistake for sure, such as the same file twice: bodies in contact may reach into
each other a little.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.scene.filling import Filling
from pgimp.scene.pointscloud import Cloud
from pgimp.scene.regions.base import Bounds

Reals = NDArray[np.float64]
Ints = NDArray[np.int64]

#: How deep in another body a particle may lie, and how close to one of another file, over its size.
_DEEP, _CLOSE = 0.25, 0.1


class _Some(NamedTuple):
    """Particles of a file: their rows, positions (n, D) and volumes."""

    rows: Ints
    x: Reals
    volume: Reals


def overlaps(
    names: Sequence[str],
    bodies: Sequence[Filling | Cloud],
    box: Sequence[float],
    planes: tuple[int, int],
) -> Iterator[tuple[tuple[int, int], str]]:
    """Yield for each pair of bodies, one of them from a file, the first overlap along x.

    Parameters
    ----------
    names, bodies : sequence
        All bodies.
    box : sequence of float
        Size of a box of the lattice by direction.
    planes : (int, int)
        Range of the lattice's planes that is searched; whatever it is, what is found in it is the
        same.

    Yields
    ------
    (int, int), str
        The bodies' numbers and what is wrong, with the key.

    Raises
    ------
    CaseError
        If a file cannot be read any more.
    """
    for a, b in combinations(range(len(bodies)), 2):
        first, second = bodies[a], bodies[b]
        if isinstance(first, Filling) and isinstance(second, Filling):
            continue
        low, high = _common(first.region.bounds(), second.region.bounds())
        if (low > high + min(box)).any() or planes[0] >= planes[1]:
            continue
        if isinstance(first, Cloud) and isinstance(second, Cloud):
            found = _close(first, second, (low, high), planes, min(box))
        elif isinstance(first, Cloud):
            assert isinstance(second, Filling)
            found = _inside(first, second, (low, high), planes, min(box))
        else:
            assert isinstance(second, Cloud)
            found = _inside(second, first, (low, high), planes, min(box))
        if found:
            yield (
                (a, b),
                f"bodies.{names[b]}.region: {found}: '{names[a]}' and '{names[b]}' overlap; move "
                "or cut one of them, or leave such particles out of the file",
            )


def _common(first: Bounds, second: Bounds) -> tuple[Reals, Reals]:
    """Corners of what two boxes have in common; low above high where they are apart."""
    low, high = np.maximum(first[0], second[0]), np.minimum(first[1], second[1])
    return low, high


def _inside(
    cloud: Cloud, body: Filling, box: tuple[Reals, Reals], planes: tuple[int, int], size: float
) -> str:
    """Name the first particle that lies in a body on the lattice."""
    here = _taken(cloud, box, planes, None)
    deep = np.flatnonzero(body.region.distance(here.x) < -_DEEP * size)
    if len(deep) == 0:
        return ""
    i = deep[np.lexsort(here.x[deep].T[::-1])[0]]
    where = cloud.region.line(int(here.rows[i]))
    return f"the particle at {_place(here.x[i])} ({where} of {cloud.region.file}) lies in the other"


def _close(
    first: Cloud, second: Cloud, box: tuple[Reals, Reals], planes: tuple[int, int], size: float
) -> str:
    """Name the first two particles of two files that are at nearly the same place.

    Both are sorted into cells, of twice the distance that counts, on lattices that are shifted
    against each other by half a cell in every combination of directions: two particles so close
    are in one cell of one of them.
    """
    reach = _CLOSE * size
    wide = (box[0] - reach, box[1] + reach)
    one, other = (_taken(cloud, wide, planes, 4.0 * reach) for cloud in (first, second))
    if len(one.x) == 0 or len(other.x) == 0:
        return ""
    x = np.concatenate([one.x, other.x])
    # Files may be finer than the lattice.
    limit = _CLOSE * np.concatenate([one.volume, other.volume]) ** (1.0 / x.shape[1])
    limit = np.minimum(limit, reach)
    best: tuple[tuple[float, ...], int, int] | None = None
    origin = np.array([edges[0] for edges in first.edges])
    for shift in product((0.0, 0.5), repeat=x.shape[1]):
        cells = np.floor((x - origin) / (2.0 * reach) + shift).astype(np.int64)
        order = np.lexsort(cells.T)  # which keeps the first body's before the second's
        left, right = order[:-1], order[1:]
        pair = (left < len(one.x)) & (right >= len(one.x))
        pair &= (cells[left] == cells[right]).all(axis=1)
        left, right = left[pair], right[pair]
        away = np.sqrt(np.square(x[left] - x[right]).sum(axis=1))
        close = away < np.minimum(limit[left], limit[right])
        close &= first.between(x[left, 0], planes)
        for i, j in zip(left[close].tolist(), right[close].tolist(), strict=True):
            found = tuple(x[i].tolist()), i, j
            best = found if best is None else min(best, found)
    if best is None:
        return ""
    i, j = best[1], best[2]
    pair_of = [
        f"{cloud.region.line(int(row))} of {cloud.region.file}, at {_place(at)}"
        for cloud, row, at in (
            (first, one.rows[i], x[i]),
            (second, other.rows[j - len(one.x)], x[j]),
        )
    ]
    return f"two particles are at nearly the same place ({'; '.join(pair_of)})"


def _taken(
    cloud: Cloud, box: tuple[Reals, Reals], planes: tuple[int, int], beyond: float | None
) -> _Some:
    """Particles in a box and in a range of planes, or up to a distance beyond these along x."""
    edges = cloud.edges[0]

    def wanted(x: Reals) -> NDArray[np.bool_]:
        inside = (box[0][0] <= x) & (x <= box[1][0])
        if beyond is None:
            return inside & cloud.between(x, planes)
        return inside & (edges[planes[0]] - beyond <= x) & (x <= edges[planes[1]] + beyond)

    parts = [_Some(np.zeros(0, np.int64), np.zeros((0, len(cloud.edges))), np.zeros(0))]
    for rows, block in cloud.region.chosen(wanted):
        keep = ((box[0] <= block.position) & (block.position <= box[1])).all(axis=1)
        parts.append(_Some(rows[keep], block.position[keep], block.volume[keep]))
    return _Some(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _place(x: Reals) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in x) + ")"
