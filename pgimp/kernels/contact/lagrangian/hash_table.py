"""Numbers of keys: a hash table."""

import numpy as np

from pgimp.jit.kernel import inner_kernel, kernel


@kernel
def table_size(count):
    """Places in a table for `count` keys."""
    size = 16
    while size <= 2 * count:
        size *= 2
    return size


def empty_table(count: int) -> np.ndarray:
    """Make an empty table for `count` keys: (a power of two, 2) int64, key and number."""
    return np.full((table_size(count), 2), -1, np.int64)


@inner_kernel
def slot(hashes, key):
    """Place of a key in a table, or of the free slot where it belongs."""
    mask, mixed = len(hashes) - 1, key * 0x9E3779B97F4A7C1
    at = (mixed ^ (mixed >> 31)) & mask
    while hashes[at, 0] != key and hashes[at, 0] >= 0:
        at = (at + 1) & mask
    return at


@kernel
def insert_keys(keys, hashes):
    """Enter the places of `keys` in a table: of duplicates, the first."""
    for i in range(len(keys)):
        at = slot(hashes, keys[i])
        if hashes[at, 0] < 0:
            hashes[at, 0], hashes[at, 1] = keys[i], i


@inner_kernel
def find_or_insert(hashes, key, found):
    """Number of a key, which is entered as number `found` if it is new."""
    at = slot(hashes, key)
    if hashes[at, 0] < 0:
        hashes[at, 0], hashes[at, 1] = key, found
    return hashes[at, 1]
