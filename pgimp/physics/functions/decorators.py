"""The decorators that register functions, ``@pgimp.body_force`` and others.

Each is written above a function, as it is or with a name for cases,
``@pgimp.body_force("my-name")``; by default the name is the function's, with ``-`` for ``_``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeVar

from pgimp.physics.functions.registry import (
    BODY_FORCE,
    COEFFICIENT,
    EXACT_SOLUTION,
    STRESS,
    VELOCITY,
    F,
    Kind,
    register,
)

T = TypeVar("T")


def _decorated(kind: Kind, function: object) -> Callable[[T], T]:
    """Return a decorator that has been given a name, or register the function at once."""
    if function is None or isinstance(function, str):
        return partial(_named, kind, function)
    found: Callable[[T], T] = register(kind, function, None)
    return found


def _named(kind: Kind, name: str | None, function: T) -> T:
    registered: T = register(kind, function, name)
    return registered


def body_force(function: F | str | None = None) -> F:
    """Register a body force: force per mass, of ``x``, ``X``, ``v``, ``t`` and parameters.

    It returns a tuple of D floats [length/time^2]. ``x`` is a particle's present position, ``X``
    the initial one, ``v`` its velocity, each a tuple of D floats; ``t`` is the time.
    """
    return _decorated(BODY_FORCE, function)  # type: ignore[return-value]


def velocity(function: F | str | None = None) -> F:
    """Register a velocity, of ``x``, ``t`` and parameters: D floats [length/time].

    An initial velocity is of ``x`` alone, that of a constraint may also be of the time.
    """
    return _decorated(VELOCITY, function)  # type: ignore[return-value]


def stress(function: F | str | None = None) -> F:
    """Register an initial Cauchy stress, of ``x`` and parameters: xx yy zz xy (2D) [stress]."""
    return _decorated(STRESS, function)  # type: ignore[return-value]


def coefficient(function: F | str | None = None) -> F:
    """Register a number in place of another: of ``x`` in a material, of ``t`` in a load."""
    return _decorated(COEFFICIENT, function)  # type: ignore[return-value]


def exact_solution(function: F | str | None = None) -> F:
    """Register an exact solution, of ``X``, ``x``, ``t`` and parameters.

    It returns displacement, velocity and Cauchy stress of the particle: three tuples of floats.
    """
    return _decorated(EXACT_SOLUTION, function)  # type: ignore[return-value]
