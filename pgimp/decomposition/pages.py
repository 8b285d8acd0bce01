"""Memory of arrays whose values nothing needs for a while, given back to the system."""

import ctypes
import mmap

import numpy as np

_madvise = ctypes.CDLL(None, use_errno=True).madvise
_madvise.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int


def give_back(array: np.ndarray) -> None:
    """Give the pages of an array back; it stays, and has zeros there until it is set again.

    So references to it stay valid, and kernels take it as before. Where the system refuses, the
    array keeps its memory and its values.
    """
    if not array.flags.owndata:  # others may share its pages
        return
    begin = -(-array.ctypes.data // mmap.PAGESIZE) * mmap.PAGESIZE
    end = (array.ctypes.data + array.nbytes) // mmap.PAGESIZE * mmap.PAGESIZE
    if end > begin:
        _madvise(begin, end - begin, mmap.MADV_DONTNEED)
