"""Hash table from keys to their numbers: (a power of two, 2) int64, key and number, -1 at first."""

from pgimp.jit.kernel import inner_kernel, kernel


@kernel
def table_size(count):
    """Number of slots in a table for `count` keys."""
    size = 16
    while size <= 2 * count:
        size *= 2
    return size


@inner_kernel
def _slot(hashes, key):
    """Slot of a key in a table, or the free slot for it."""
    mask, mixed = len(hashes) - 1, key * 0x9E3779B97F4A7C1
    at = (mixed ^ (mixed >> 31)) & mask
    while hashes[at, 0] != key and hashes[at, 0] >= 0:
        at = (at + 1) & mask
    return at


@inner_kernel
def find_or_insert(hashes, key, found):
    """Number of a key; a new key is inserted with number `found`."""
    at = _slot(hashes, key)
    if hashes[at, 0] < 0:
        hashes[at, 0], hashes[at, 1] = key, found
    return hashes[at, 1]


@inner_kernel
def find(hashes, key):
    """Number of a key; -1 without one."""
    return hashes[_slot(hashes, key), 1]
