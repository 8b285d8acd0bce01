"""Kernels called without asking for their arguments' types again.

At each call Numba finds out the types of all arguments, to choose what it has compiled. For tuples
of arrays that takes several microseconds, in small scenes more than the kernels' work. Within one
simulation a kernel is always called with the same types.
"""

from collections.abc import Callable
from typing import Any

import numba


class Bound:
    """Calls of kernels, each with arguments of the same types for ever; others would be misread."""

    def __init__(self) -> None:
        self._entries: dict[Any, Callable[..., Any]] = {}

    def __call__(self, kernel: Any, *args: Any) -> Any:
        """Call a kernel with the types of its first call."""
        entry = self._entries.get(kernel)
        if entry is not None:
            return entry(*args)
        result = kernel(*args)
        if overloads := getattr(kernel, "overloads", None):
            types = tuple(numba.typeof(arg) for arg in args)
            self._entries[kernel] = overloads[types].entry_point
        return result
