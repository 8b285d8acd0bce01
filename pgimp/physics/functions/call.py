"""Functions of one's own in kernels: the NamedTuple that stands for one, and its evaluation."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

import numba

from pgimp.errors import CaseError
from pgimp.jit.kernel import INLINE_OPTIONS, class_of, inlined, kernel, of_types
from pgimp.jit.outside import tag
from pgimp.jit.tuples import read, write
from pgimp.physics.functions.raised import raised_by
from pgimp.physics.functions.registry import Function, Value


@inlined
def call(source, given):
    """Value of a function, see `source_of`, of all that its kind is given."""
    taken = tuple(given[number] for number in class_of(source).taken)
    return _function_of(source)(*taken, *source.parameters)


@of_types
def _function_of(source):
    """The Numba function of a source, given by its Numba type."""
    return compiled(source.instance_class)


@cache
def compiled(kind: type):
    """The Numba function of a class from `source_of`."""
    options = {**INLINE_OPTIONS, "_nrt": True}  # it may make arrays
    return numba.njit(**options)(kind.function)  # type: ignore[attr-defined]


def _own_state(solution, X, x, t):
    return call(solution, (X, x, t))


def _reference(solution: Any, t: float) -> float:
    """Return the reference stress of an exact solution."""
    return float(solution.reference)


#: Classes by function and kind; a function that is defined again has another.
_classes: dict[tuple[FunctionType, str], type] = {}


def source_of(
    function: Function, parameters: dict[str, Value], reference: float = 1.0
) -> tuple[Any, ...]:
    """Return a function with its parameters, as kernels take it.

    Another process finds the class again beside the Python function, as the cache of kernels needs
    it (`pgimp.jit.outside`).
    """
    key = function.function, function.kind.name
    if key not in _classes:
        _classes[key] = _class_of(function)
    values = tuple(parameters[name] for name in function.defaults)
    found: tuple[Any, ...] = _classes[key](reference, values)
    return found


def _class_of(function: Function) -> type:
    plain, attribute = function.function, f"{function.kind.name}_values"
    make: Any = namedtuple
    kind: Any = make(attribute, ("reference", "parameters"))
    kind.__module__, kind.__qualname__ = plain.__module__, f"{plain.__qualname__}.{attribute}"
    kind.function = staticmethod(plain)
    kind.taken = tuple(function.kind.given.index(name) for name in function.given)
    kind.state, kind.scale = staticmethod(_own_state), _reference
    setattr(plain, attribute, kind)
    tag(kind)
    found: type = kind
    return found


def evaluate(function: Function, at: Callable[..., None], arguments: tuple[Any, ...]) -> None:
    """Call one of the kernels below.

    Raises
    ------
    CaseError
        If the function raises an exception.
    """
    try:
        at(*arguments)
    except Exception as error:
        raise CaseError(raised_by(error, function)) from None


@kernel
def vectors_at(source, like, x, values):
    """Set rows of `values` (n, k) to a function's tuples at `x` (n, D); `like` has D numbers."""
    for p in range(len(x)):
        X = read(x, p, 0, like)
        write(values, p, 0, call(source, (X, 0.0)))


@kernel
def numbers_at(source, like, x, values):
    """Set `values` (n,) to a function's numbers at `x` (n, D); `like` has D numbers."""
    for p in range(len(x)):
        values[p] = call(source, (read(x, p, 0, like), 0.0))


@kernel
def numbers_in_time(source, times, values):
    """Set `values` (n,) to a function's numbers at `times` (n,)."""
    for k in range(len(times)):
        values[k] = call(source, ((0.0,), times[k]))


@kernel
def forces_at(source, like, x, t, values):
    """Set rows of `values` (n, D) to a body force at `x` (n, D), for particles at rest there."""
    for p in range(len(x)):
        X = read(x, p, 0, like)
        write(values, p, 0, call(source, (X, X, like, t)))


@kernel
def states_at(source, like, x, t, values):
    """Set rows of `values` to displacement, velocity and stress of an exact solution at `x`."""
    for p in range(len(x)):
        X = read(x, p, 0, like)
        u, v, sigma = call(source, (X, X, t))
        write(values, p, 0, u)
        write(values, p, len(u), v)
        write(values, p, len(u) + len(v), sigma)
