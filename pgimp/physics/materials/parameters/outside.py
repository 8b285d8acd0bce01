"""Checks of the declarations of materials from outside the package, with their messages.

`pgimp.physics.materials.parameters.fit` checks the results of their functions.
"""

from __future__ import annotations

import inspect
from math import isfinite
from types import FunctionType
from typing import Any, NamedTuple

from pgimp.errors import UsageError
from pgimp.jit.outside import is_outside, tag
from pgimp.physics.fields import EVERY
from pgimp.physics.materials.base import LOSSES, STATE_NAME, Material, State, has, with_states
from pgimp.physics.materials.parameters.fit import (
    arguments_of,
    file_of,
    place_of,
    quantities_of,
    require_fit,
    takes_four,
)


def parameters_of(entry: Material, dimensions: int) -> Any:
    """Return the kernels' view of a material, checked where it comes from outside.

    Parameters
    ----------
    dimensions : int
        Of the case: 1, 2 or 3.

    Returns
    -------
    NamedTuple
        Parameters of the kernels.

    Raises
    ------
    UsageError
        If something that the kernels need is missing or of a wrong type.
    """
    who = f"the material '{entry.model}'"  # type: ignore[attr-defined]
    try:
        parameters = entry.parameters()  # type: ignore[attr-defined]
    except Exception as error:
        if not is_outside(type(entry)):
            raise
        raise UsageError(
            f"{who}: {type(entry).__qualname__}.parameters() of {file_of(type(entry))} fails: "
            f"{type(error).__name__}: {error}"
        ) from error
    kind = type(parameters)
    if not is_outside(kind):
        return with_states(entry, parameters)
    if "density" not in getattr(kind, "_fields", ()):
        raise UsageError(
            f"{who}: parameters() must return a NamedTuple with a density, got {kind.__qualname__}"
        )
    _require_states(who, entry, parameters)
    try:
        with_states(entry, parameters)
    except ValueError as error:
        raise UsageError(f"{who}: {error}; give each material a NamedTuple of its own") from error
    for quantity in quantities_of(kind):
        names = arguments_of(kind, quantity)
        function = inspect.getattr_static(kind, quantity, None)
        call = f"{quantity}({', '.join(names)})"
        if not isinstance(function, staticmethod):
            raise UsageError(f"{who}: {kind.__qualname__} needs a @staticmethod {call}")
        if not isinstance(function.__func__, FunctionType):
            raise UsageError(
                f"{who}: {kind.__qualname__}.{quantity} must be a plain function {call}, which "
                f"pgimp compiles itself; it is of the type {type(function.__func__).__name__}"
            )
        given = len(inspect.signature(function.__func__).parameters)
        if given != len(names):
            raise UsageError(
                f"{who}: {place_of(kind, quantity)} takes {given} arguments instead of {call}"
            )
    _require_losses(who, entry, kind)
    tag(kind)
    require_fit(who, parameters, dimensions)
    return parameters


def _require_losses(who: str, entry: Material, kind: type) -> None:
    """Refuse unknown losses, and losses without a function."""
    if not isinstance(entry.LOSSES, tuple) or not set(entry.LOSSES) <= set(LOSSES):
        raise UsageError(
            f"{who}: LOSSES of {type(entry).__qualname__} ({file_of(type(entry))}) must be a tuple "
            f"of some of {', '.join(LOSSES)}"
        )
    if bool(entry.LOSSES) != has(kind, "losses"):
        raise UsageError(
            f"{who}: LOSSES of {type(entry).__qualname__} and the function losses of "
            f"{kind.__qualname__} belong together; one of them is missing"
        )


def _require_states(who: str, entry: Material, parameters: NamedTuple) -> None:
    """Refuse wrong declarations of state variables."""
    kind = type(entry)
    names: list[str] = []
    states: object = entry.states
    if not isinstance(states, tuple) or not all(isinstance(each, State) for each in states):
        raise UsageError(
            f"{who}: STATE of {kind.__qualname__} ({file_of(kind)}) must be a tuple of "
            'pgimp.physics.materials.State, as in STATE = (State("damage", "1", "what it is"),)'
        )
    for each in states:
        where = f"{who}: the state {each.name!r} of {kind.__qualname__} ({file_of(kind)})"
        if not isinstance(each.name, str) or not STATE_NAME.fullmatch(each.name):
            raise UsageError(f"{where} needs a name of small letters, digits and '-'")
        if each.name in EVERY or each.name in names:
            raise UsageError(f"{where} has a name that is taken by another field")
        names.append(each.name)
        start = each.initial
        if isinstance(start, str):
            if start not in parameters._fields:
                raise UsageError(
                    f"{where} begins with '{start}', which is none of the parameters: "
                    f"{', '.join(parameters._fields)}"
                )
            start = getattr(parameters, start)
        if isinstance(start, bool) or not isinstance(start, int | float) or not isfinite(start):
            raise UsageError(f"{where} must begin with a finite number, not with {start!r}")


def takes_vectors(entry: Material, dimensions: int) -> bool:
    """Return whether a material is computed for four particles at once, like pgimp's own.

    A function with branches, or with calls that take no vectors, is called particle by particle:
    correct, but slower. See `pgimp.physics.materials` for the allowed operations.

    Parameters
    ----------
    entry : Material
        The material with its constants.
    dimensions : int
        Of the case: 1, 2 or 3.

    Raises
    ------
    UsageError
        If the material is unusable, as in a run.
    """
    return takes_four(parameters_of(entry, dimensions), dimensions)
