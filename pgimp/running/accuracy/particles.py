"""What the particles of a frame show: stretch of their boxes, and stress that varies in cells."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.errors import RunError

if TYPE_CHECKING:
    from pgimp.case.schema import Case
    from pgimp.io.results.frame import Frame

Array = np.ndarray

#: Most particles that are looked at, in runs of neighbours of this length.
_MAX_PARTICLES, _RUN = 1 << 18, 1 << 16
#: The part of a body's particles that may be beyond what is reported of its stretch.
_FEW = 0.01
#: Fewest particles of a body of which anything is said.
_MIN_PARTICLES = 16
#: Rank of symmetric tensors' components in a matrix, xx yy zz xy yz xz.
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


class BodyState(NamedTuple):
    """A body in a frame."""

    name: str
    #: stretch, squeeze: Principal stretches that a hundredth of the particles exceed, or stay
    #: below; nan if unknown.
    stretch: float
    squeeze: float
    #: Part of the mean square stress that varies within cells; nan if unknown, or without stress.
    within_cells: float
    square: float  #: Sum of the squared stress times volume, of all of its particles.


def body_states(case: Case, frame: Frame) -> list[BodyState]:
    """Look at the particles of a frame, of large frames at a part of them.

    Parameters
    ----------
    frame : Frame
        A complete frame.

    Raises
    ------
    RunError
        If the frame cannot be read.
    """
    rows = [*_rows(len(frame))]
    if not rows:
        return []
    take = _Taker(frame, rows)
    body, D = take("body"), case.dimensions
    stretches = _stretches(take, frame, D)
    stress = _stress(take, frame)
    volume = take("volume").astype(float)
    position = take("position").astype(float)[:, :D]
    cell = np.floor((position - case.grid.origin) / np.array(case.grid.cell, float))
    found = []
    for number, name in enumerate(frame.bodies):
        own = np.flatnonzero((body == number) & np.isfinite(position).all(axis=1))
        if len(own) < _MIN_PARTICLES:
            continue
        low = high = within = np.nan
        square = 0.0
        if stretches is not None:
            low = float(np.nanquantile(stretches[own, 0], _FEW))
            high = float(np.nanquantile(stretches[own, 1], 1.0 - _FEW))
        if stress is not None:
            square = float(volume[own] @ (stress[own] ** 2).sum(axis=1))
            places = cell[own].astype(np.int64), position[own]
            within = _within_cells(*places, volume[own], stress[own])
        found.append(BodyState(name, high, low, within, square))
    return found


def _rows(count: int) -> Iterator[tuple[int, int]]:
    """Ranges of rows to be read: all, or runs of neighbours from everywhere."""
    runs = -(-count // _RUN)
    most = _MAX_PARTICLES // _RUN
    for k in np.unique(np.linspace(0, runs - 1, min(runs, most)).round().astype(int)).tolist():
        yield k * _RUN, min((k + 1) * _RUN, count)


class _Taker:
    """Reads fields of the chosen rows."""

    def __init__(self, frame: Frame, rows: list[tuple[int, int]]) -> None:
        self._frame, self._rows = frame, rows

    def __call__(self, name: str) -> Array:
        try:
            return np.concatenate([self._frame.rows(name, *ends) for ends in self._rows])
        except KeyError as error:
            raise RunError(f"cannot read {self._frame.path}: {error}") from error


def _stretches(take: _Taker, frame: Frame, D: int) -> Array | None:
    """Least and greatest principal stretch of each particle, (n, 2); None if not in the frame."""
    if "deformation" in frame:
        F = take("deformation").astype(float).reshape(-1, 3, 3)[:, :D, :D]
        C = np.einsum("nji,njk->nik", F, F)
    elif "strain" in frame:
        strain = take("strain").astype(float)
        C = np.zeros((len(strain), 3, 3))
        for column, (i, j) in enumerate(_PLACES):
            C[:, i, j] = C[:, j, i] = 2.0 * strain[:, column] + float(i == j)
        C = C[:, :D, :D]
    else:
        return None
    sound = np.isfinite(C).all(axis=(1, 2))
    squares = np.full((len(C), D), np.nan)
    squares[sound] = np.linalg.eigvalsh(C[sound])
    return np.sqrt(np.maximum(squares[:, [0, -1]], 0.0))


def _stress(take: _Taker, frame: Frame) -> Array | None:
    """Stress in columns whose squares add up to its norm, or an invariant of it; None without."""
    if "stress" in frame:
        return take("stress").astype(float) * np.sqrt([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    names = [name for name in ("pressure", "von-mises") if name in frame]
    return np.stack([take(name).astype(float) for name in names], axis=1) if names else None


def _within_cells(cell: Array, position: Array, volume: Array, stress: Array) -> float:
    """Part of the mean square stress that varies within cells; nan without stress.

    The mean over each cell is taken off, and a gradient by the means of the cells beside it, so
    that what is smooth counts little.
    """
    cell = cell - cell.min(axis=0)
    shape = cell.max(axis=0) + 3  # a margin, so that no neighbour is in another row
    strides = np.concatenate([np.cumprod(shape[::-1])[::-1][1:], [1]])
    keys, index, counts = np.unique(cell @ strides, return_inverse=True, return_counts=True)

    def mean(values: Array) -> Array:
        sums = [np.bincount(index, volume * column, len(keys)) for column in values.T]
        return np.stack(sums, axis=1) / filled[:, None]

    filled = np.bincount(index, volume, len(keys))
    means, centres = mean(stress), mean(position)
    smooth = means[index]
    for axis, stride in enumerate(strides):
        smooth += (
            _slope(keys, stride, means, centres[:, axis])[index]
            * (position[:, axis] - centres[index, axis])[:, None]
        )
    shared = counts[index] > 1
    weights = volume[shared]
    whole = float(weights @ (stress[shared] ** 2).sum(axis=1))
    rest = float(weights @ ((stress - smooth)[shared] ** 2).sum(axis=1))
    return rest / whole if whole > 0.0 and np.isfinite(rest) else np.nan


def _slope(keys: Array, stride: int, means: Array, places: Array) -> Array:
    """Gradient along an axis of the means over cells, by those beside, (n, k); zero without any."""
    own = np.arange(len(keys))
    after = np.minimum(np.searchsorted(keys, keys + stride), own[-1])
    before = np.searchsorted(keys, keys - stride)
    after = np.where(keys[after] == keys + stride, after, own)
    before = np.where(keys[before] == keys - stride, before, own)
    way = places[after] - places[before]
    beside = (after != before) & (np.abs(way) > 0.0)
    slope = (means[after] - means[before]) / np.where(beside, way, 1.0)[:, None]
    return np.where(beside[:, None], slope, 0.0)
