"""Rehearsals: kernels are called as in a step, but for nothing, so that they are compiled.

Ranks share the compilation: a rehearsal first only notes the calls of kernels not yet compiled.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, get_args, get_type_hints

import numpy as np

from pgimp.jit.argument_types import type_of

#: A kernel, and the types of its arguments.
Noted = tuple[Any, tuple[Any, ...]]


class _State:
    """Whether this process rehearses, and the calls noted instead of made."""

    rehearses = False
    noted: dict[Noted, None] | None = None


def needed(count: Any) -> bool:
    """Whether kernels are to be called for `count` things: in a rehearsal also for none."""
    return _State.rehearses or bool(count)


def marked(marks: np.ndarray) -> np.ndarray:
    """Offsets of the marks that are not 0; in a rehearsal of all."""
    return np.arange(len(marks)) if _State.rehearses else np.flatnonzero(marks)


@contextmanager
def rehearsal() -> Iterator[None]:
    """Rehearse in the body: whatever `needed` guards is done."""
    _State.rehearses = True
    try:
        yield
    finally:
        _State.rehearses = False


def note_calls(rehearse: Callable[[], None]) -> list[Noted]:
    """Return the first calls of kernels in a rehearsal, which are not made."""
    _State.noted = found = {}
    try:
        rehearse()
    finally:
        _State.noted = None
    return list(found)


def notable(kernel: Any) -> None:
    """Have the first calls of a kernel noted where they are to be."""
    compile_now = kernel._compile_for_args

    def first_call(*args: Any, **named: Any) -> Any:
        if _State.noted is None:
            return compile_now(*args, **named)
        _State.noted[kernel, tuple(map(type_of, args))] = None
        return lambda *_: _nothing(get_type_hints(kernel.py_func).get("return", int))

    kernel._compile_for_args = first_call


def _nothing(kind: Any) -> Any:
    """Result of a kernel that has nothing to do: zeros, or what is `empty`."""
    if parts := get_args(kind):
        return tuple(map(_nothing, parts))
    return kind.empty() if hasattr(kind, "empty") else kind()
