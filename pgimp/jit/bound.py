"""Kernel calls without a repeated search for the arguments' types.

At each call Numba determines the types of all arguments, to choose the compiled code. For tuples of
arrays that takes several microseconds, in small scenes more than the kernels' work. Within one
simulation the types of a kernel's arguments never change.

If they did, the entry would misread its arguments, and the process might end without a message.
With PGIMP_CHECK_CALLS=1 every call is by Numba's own search, and another type is an error.
"""

import os
from collections.abc import Callable
from typing import TypeVar

from pgimp.jit.argument_types import type_of

R = TypeVar("R")

#: Whether calls are checked, which takes as long as the search that they save.
CHECKED = os.environ.get("PGIMP_CHECK_CALLS", "") not in ("", "0")

#: Entries of kernels by the identities of their arguments' types, with these, so that they stay.
_ENTRIES: dict[tuple, tuple[tuple, Callable]] = {}


class Bound:
    """Calls of kernels, each with constant types of arguments; others would be misread."""

    def __init__(self) -> None:
        self._entries: dict[Callable, Callable] = {}
        self._types: dict[Callable, tuple] = {}  # if they are checked

    def __call__(self, kernel: Callable[..., R], *args: object) -> R:
        """Call a kernel with the types of its first call."""
        entry = self._entries.get(kernel)
        if entry is not None:
            return entry(*args)
        result = kernel(*args)
        if overloads := getattr(kernel, "overloads", None):
            types = tuple(map(type_of, args))
            if CHECKED:
                require_same_types(kernel, self._types.setdefault(kernel, types), types)
                return result
            known = kernel, *map(id, types)
            if known not in _ENTRIES and types in overloads:  # not where the call is only noted
                _ENTRIES[known] = types, overloads[types].entry_point
            if known in _ENTRIES:
                self._entries[kernel] = _ENTRIES[known][1]
        return result


def require_same_types(kernel: Callable, first: tuple, now: tuple) -> None:
    """Refuse arguments of other types than those of the first call.

    Raises
    ------
    TypeError
        With the kernel, and the first argument that differs.
    """
    if len(first) != len(now):
        text = f"{len(now)} arguments, {len(first)} at first"
        raise TypeError(f"{kernel.__qualname__} is called with {text}")
    for number, (before, other) in enumerate(zip(first, now, strict=True), 1):
        if before != other:
            text = f"argument {number} is {other}, at first {before}"
            raise TypeError(f"{kernel.__qualname__} is called with other types: {text}")
