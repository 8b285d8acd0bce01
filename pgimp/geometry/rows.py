"""Rows of whole numbers: their lexicographic order, and the different ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]

#: Greatest number of keys.
_MOST = 1 << 62


def keys_of(rows: NDArray[Any]) -> Indices:
    """Keys of rows of whole numbers, (n, k), in whose order the rows are lexicographic, (n,)."""
    found, count = np.zeros(len(rows), np.int64), 1
    if not len(rows):
        return found
    low = rows.min(axis=0)
    for column, first, size in zip(rows.T, low, rows.max(axis=0) - low + 1, strict=True):
        own, many = (column - first).astype(np.int64, copy=False), int(size)
        if count * many > _MOST:
            found, count = _ranks(found)
        if count * many > _MOST:
            own, many = _ranks(own)
        found, count = found * many + own, count * many
    return found


def _ranks(keys: Indices) -> tuple[Indices, int]:
    """The rank of each key among the different ones, and how many these are."""
    first, ranks = _grouped(keys)
    return ranks, len(first)


def _grouped(keys: Indices) -> tuple[Indices, Indices]:
    """First of each of the different keys, ascending, and which of these each is."""
    order = np.argsort(keys)  # faster than a stable one
    sorted_keys, new = keys[order], np.ones(len(keys), bool)
    np.not_equal(sorted_keys[1:], sorted_keys[:-1], out=new[1:])
    ranks = np.empty(len(keys), np.int64)
    ranks[order] = np.cumsum(new) - 1
    begin = np.flatnonzero(new)
    return (np.minimum.reduceat(order, begin) if len(begin) else order), ranks


def distinct(rows: NDArray[Any]) -> tuple[Indices, Indices]:
    """First of each of the different rows, in ascending order, and which of these each row is."""
    return _grouped(keys_of(rows))


def ascending(rows: NDArray[Any]) -> Indices:
    """Order in which rows are ascending; equal ones stay as they are."""
    return np.argsort(keys_of(rows), kind="stable")


def each_once(numbers: Indices) -> Indices:
    """The different ones of some numbers, ascending; faster than by `np.unique`'s hashes."""
    found = np.sort(numbers)
    new = np.ones(len(found), bool)
    np.not_equal(found[1:], found[:-1], out=new[1:])
    return found[new]
