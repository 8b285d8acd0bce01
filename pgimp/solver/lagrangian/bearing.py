"""Vertices that contact moves keep their lumped mass: links of the averaged mass that end there.

The averaged mass takes sums of alpha C_ij (a_j - a_i) from forces. Contact finds its impulses
later in a step, from the lumped mass. Were they not among the accelerations, what rests on another
body would not be in equilibrium. So no link counts at a vertex that contact has moved in the last
step. What is left is symmetric, and has row sums 0: momentum and uniform accelerations stay exact.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from pgimp.kernels.data.record import FORCE, RECORD
from pgimp.kernels.lagrangian.averaged_mass import NUMBERS, Links, MassRows


def links_at(rows: MassRows, marked: np.ndarray, reach: int, window: Any) -> Links:
    """The links of a rank's vertices that end at marked ones.

    Parameters
    ----------
    rows : MassRows
        The rows at the rank's planes.
    marked : (n,) int64
        Numbers of the marked vertices, ascending, counted from `reach` planes before these.
    window : Window
        The rank's window.
    """
    strides = tuple(each // RECORD for each in window.stride[: len(rows.scale)])
    size, planes = strides[0], len(rows.start) - 1
    plane = np.repeat(np.arange(planes) + reach, np.diff(rows.start))
    own = plane * size + rows.vertex // RECORD
    distances = np.unique(rows.column) // NUMBERS
    near = np.unique(np.concatenate([marked, (marked[:, None] - distances).reshape(-1)]))
    n = np.flatnonzero(np.isin(own, near))
    first, pattern = rows.first, rows.pattern[n]
    count = first[pattern + 1] - first[pattern]
    entry = np.repeat(first[pattern] - np.cumsum(count) + count, count) + np.arange(count.sum())
    at = [np.repeat(own[n], count)]
    other, value = [at[0] + rows.column[entry] // NUMBERS], [rows.value[entry]]
    if len(rows.run):
        steps = [each for each in product((-1, 0, 1), repeat=len(strides)) if any(each)]
        around = [int(np.dot(each, strides)) for each in steps]
        near = np.unique(np.concatenate([marked, *(marked - each for each in around)]))
        plane = np.repeat(np.arange(planes) + reach, np.diff(rows.run_start))
        begin, end = (plane * size + edge // NUMBERS for edge in rows.run.T)
        run = np.maximum(np.searchsorted(begin, near, side="right") - 1, 0)
        inside = (near >= begin[run]) & (near < end[run])
        near, mass = near[inside], rows.mass[run[inside]]
        for step, distance in zip(steps, around, strict=True):
            parts = [s if o else 1.0 - 2.0 * s for s, o in zip(rows.scale, step, strict=True)]
            at.append(near)
            other.append(near + distance)
            value.append(mass * np.prod(parts))
    i, j, w = (np.concatenate(each) for each in (at, other, value))
    some = np.isin(i, marked) | np.isin(j, marked)
    i, j, w = i[some], j[some], w[some]
    order = np.lexsort((j, i))
    i, j, w = i[order], j[order], w[order]
    return Links(RECORD * (i - reach * size) + FORCE, NUMBERS * i + 1, NUMBERS * j + 1, w)
