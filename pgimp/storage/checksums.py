"""Checksums of parts of a file, computed while it is written and compared when it is read."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

# Bytes read at once, which stay in the core's cache.
_BLOCK = 1 << 18


class Written(NamedTuple):
    """A part of a file with the checksum of the data written there."""

    start: int
    size: int
    checksum: int


def word_sum(data: memoryview, before: int = 0) -> int:
    """Add up 64-bit words, modulo 2^64: ten times as fast as CRC-32.

    It detects missing or foreign bytes, but not their order; it is for files that the run itself
    reads back, not for those that are kept.

    Parameters
    ----------
    data : memoryview
        Bytes; those that fill no word at the end are taken as one.
    before : int
        The sum of what comes before, in whole words.
    """
    whole = len(data) // 8 * 8
    words = np.frombuffer(data[:whole], "<u8").sum(dtype=np.uint64)
    return (before + int(words) + int.from_bytes(data[whole:], "little")) % 2**64


def first_wrong(
    descriptor: int, pieces: Iterable[Written], checksum: Callable[[memoryview, int], int]
) -> Written | None:
    """Return the first stretch of an open file that does not have its checksum.

    Parameters
    ----------
    descriptor : int
        The file, open for reading.
    pieces : iterable of Written
        The stretches.
    checksum : callable
        ``checksum(data, before)`` goes on from the checksum of what comes before.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    block = memoryview(bytearray(_BLOCK))
    for piece in pieces:
        found, end = 0, piece.start + piece.size
        for at in range(piece.start, end, _BLOCK):
            some = block[: min(_BLOCK, end - at)]
            found = checksum(some[: read_into(descriptor, some, at)], found)
        if found != piece.checksum:
            return piece
    return None


def read_into(descriptor: int, view: memoryview, start: int) -> int:
    """Read from byte `start` on until `view` is full or the file ends; return how much.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    done = 0
    while done < len(view):
        some = os.preadv(descriptor, [view[done : done + _BLOCK]], start + done)
        if some == 0:
            break
        done += some
    return done
