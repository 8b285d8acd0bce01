"""Hash table from keys to their numbers."""

import numpy as np

from pgimp.jit.kernel import inner_kernel, kernel


@kernel
def table_size(count):
    """Number of slots in a table for `count` keys."""
    size = 16
    while size <= 2 * count:
        size *= 2
    return size


def empty_table(count: int) -> np.ndarray:
    """Make an empty table for `count` keys: (a power of two, 2) int64, key and number."""
    return np.full((table_size(count), 2), -1, np.int64)


@inner_kernel
def slot(hashes, key):
    """Slot of a key in a table, or the free slot for it."""
    mask, mixed = len(hashes) - 1, key * 0x9E3779B97F4A7C1
    at = (mixed ^ (mixed >> 31)) & mask
    while hashes[at, 0] != key and hashes[at, 0] >= 0:
        at = (at + 1) & mask
    return at


@kernel
def insert_keys(keys, hashes):
    """Insert the offsets of `keys` into a table; duplicates keep the first offset."""
    for i in range(len(keys)):
        at = slot(hashes, keys[i])
        if hashes[at, 0] < 0:
            hashes[at, 0], hashes[at, 1] = keys[i], i


@inner_kernel
def find_or_insert(hashes, key, found):
    """Number of a key; a new key is inserted with number `found`."""
    at = slot(hashes, key)
    if hashes[at, 0] < 0:
        hashes[at, 0], hashes[at, 1] = key, found
    return hashes[at, 1]
