"""Observation of the kernels that Python calls: which, in which order, and how long each takes."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from numba.core.registry import CPUDispatcher

from pgimp.jit.bound import Bound
from pgimp.jit.outside import NumbaObject

#: Takes a kernel, its arguments, and the seconds of the call.
Note = Callable[[Callable, tuple[object, ...], float], None]


@contextmanager
def observed(note: Note) -> Iterator[None]:
    """Have all calls of kernels noted in the body, in their order; other code pays nothing."""
    by_bound, by_type, inside = Bound.__call__, CPUDispatcher.__call__, False

    def timed(call: Callable, kernel: Callable, args: tuple[object, ...]) -> object:
        nonlocal inside
        if inside:  # the first call by a `Bound`
            return call()
        inside, begin = True, perf_counter()
        try:
            return call()
        finally:
            inside = False
            note(kernel, args, perf_counter() - begin)

    def bound_call(self: Bound, kernel: Callable, *args: object) -> object:
        return timed(lambda: by_bound(self, kernel, *args), kernel, args)

    def direct_call(self: NumbaObject, *args: object, **named: object) -> object:
        return timed(lambda: by_type(self, *args, **named), self, args)

    Bound.__call__ = bound_call  # type: ignore[assignment,method-assign]
    CPUDispatcher.__call__ = direct_call  # type: ignore[assignment,method-assign]
    try:
        yield
    finally:
        Bound.__call__ = by_bound  # type: ignore[method-assign]
        del CPUDispatcher.__call__
