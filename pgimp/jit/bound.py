"""Kernel calls without a repeated search for the arguments' types.

At each call Numba determines the types of all arguments, to choose the compiled code. For tuples of
arrays that takes several microseconds, in small scenes more than the kernels' work. Within one
simulation the types of a kernel's arguments never change.
"""

from collections.abc import Callable
from typing import TypeVar

import numba

R = TypeVar("R")


class Bound:
    """Calls of kernels, each with constant types of arguments; others would be misread."""

    def __init__(self) -> None:
        self._entries: dict[Callable, Callable] = {}

    def __call__(self, kernel: Callable[..., R], *args: object) -> R:
        """Call a kernel with the types of its first call."""
        entry = self._entries.get(kernel)
        if entry is not None:
            return entry(*args)
        result = kernel(*args)
        if overloads := getattr(kernel, "overloads", None):
            types = tuple(numba.typeof(arg) for arg in args)
            if types in overloads:  # not where the call is only noted
                self._entries[kernel] = overloads[types].entry_point
        return result
