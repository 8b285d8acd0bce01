"""Checks that the functions of a material compile and return the types that kernels need.

The kernels write a material's results into columns of fixed width. A stress with a component too
many would end up in the next particle. The functions are therefore compiled first, separately, for
the kernels' argument types, and their result types are checked. A passed check is cached beside
the material's compiled kernels (see `pgimp.jit.outside`), so only the first start takes a second
or two longer.
"""

from __future__ import annotations

import inspect
from typing import NamedTuple

import numba
from numba.core import errors, types

from pgimp.errors import UsageError
from pgimp.jit.compiled.cache import Store
from pgimp.jit.kernel import FOLDER
from pgimp.jit.outside import NumbaObject, part_of
from pgimp.jit.results import INTEGER_HINT, described, is_integer, is_tuple, why
from pgimp.jit.vectors.kinds import vec4
from pgimp.physics.materials.base import (
    LOSSES,
    OPTIONAL,
    has,
    state_width,
    states_of,
    takes_viscous_pressure,
)
from pgimp.physics.materials.parameters.evaluate import compiled

_ARGUMENTS = {
    "stress": ("material", "F", "J", "sigma", "L", "dt"),
    "energy": ("material", "F", "J", "sigma"),
    "speed": ("material", "F", "J"),
    "diffusivity": ("material", "F", "J"),
    "margin": ("material", "F", "J", "sigma"),
    "losses": ("material", "F", "J", "sigma"),
    "initial_state": ("material", "F", "J", "sigma"),
}
#: Functions that are called particle by particle: for a row of the history, at the start.
_ONE_BY_ONE = ("energy", "losses", "initial_state")
#: Components of a symmetric tensor, in the order of `pgimp.jit.algebra`, and their number.
_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
_COUNTS = (3, 4, 6)

_fitting: set[tuple[type, str, int]] = set()


def arguments_of(kind: type, quantity: str) -> tuple[str, ...]:
    """Argument names of a material's function, with `state` if the material has states."""
    q = ("q",) if quantity == "stress" and takes_viscous_pressure(kind) else ()
    return (*_ARGUMENTS[quantity], *q, *(("state",) if states_of(kind) else ()))


def quantities_of(kind: type) -> list[str]:
    """Required functions of a material, and the optional ones that it has."""
    return [name for name in _ARGUMENTS if name not in OPTIONAL or has(kind, name)]


def place_of(kind: type, quantity: str) -> str:
    """Name a function of a material's parameters, with its file and line."""
    code = getattr(kind, quantity).__code__
    return f"{kind.__qualname__}.{quantity} ({code.co_filename}:{code.co_firstlineno})"


def file_of(kind: type) -> str:
    """Name the file of a class, or its module if there is none."""
    try:
        return inspect.getsourcefile(kind) or kind.__module__
    except (OSError, TypeError):
        return kind.__module__


class _Kinds(NamedTuple):
    """Numba types of the arguments of a material's functions."""

    F: NumbaObject
    J: NumbaObject
    sigma: NumbaObject
    L: NumbaObject
    dt: NumbaObject
    state: NumbaObject
    q: NumbaObject

    @classmethod
    def of(cls, kind: type, dimensions: int, number: NumbaObject) -> _Kinds:
        matrix = types.UniTuple(number, dimensions**2)
        tensor = types.UniTuple(number, _COUNTS[dimensions - 1])
        state = types.UniTuple(number, state_width(kind, dimensions))
        return cls(matrix, number, tensor, matrix, types.float64, state, number)


def _result(parameters: NamedTuple, quantity: str, kinds: _Kinds) -> NumbaObject:
    """Compile a function of a material for these argument types; return the result's type."""
    kind = type(parameters)
    function = compiled(kind, quantity)
    given = (getattr(kinds, name) for name in arguments_of(kind, quantity)[1:])
    signature = (numba.typeof(parameters), *given)
    function.compile(signature)
    return function.overloads[signature].signature.return_type


def takes_four(parameters: NamedTuple, dimensions: int) -> bool:
    """Whether the functions for four particles at once compile."""
    kind = type(parameters)
    try:
        for quantity in quantities_of(kind):
            if quantity not in _ONE_BY_ONE:
                _result(parameters, quantity, _Kinds.of(kind, dimensions, vec4))
    except errors.NumbaError:
        return False
    return True


def require_fit(who: str, parameters: NamedTuple, dimensions: int) -> None:
    """Refuse a material whose functions do not compile or return wrong types."""
    kind = type(parameters)
    for name, value in zip(kind._fields, parameters, strict=True):
        try:
            numba.typeof(value)
        except (ValueError, errors.NumbaError):
            raise UsageError(
                f"{who}: {name} of {kind.__qualname__} ({file_of(kind)}) is of the type "
                f"{type(value).__name__}, which kernels cannot hold; they know numbers, tuples of "
                "numbers and NumPy's arrays"
            ) from None
    typed = numba.typeof(parameters)
    known = (kind, str(typed), dimensions)
    if known in _fitting:
        return
    part = part_of((typed,))
    store = None if part is None else Store(FOLDER.path / part)
    name, key = f"{kind.__module__}.{kind.__qualname__}-fits", (numba.__version__, *known[1:])
    if store is None or not store.load(name, key):
        _examine(who, parameters, dimensions)
        if store is not None:
            store.save(name, key, True)
    _fitting.add(known)


def _examine(who: str, parameters: NamedTuple, dimensions: int) -> None:
    kinds = _Kinds.of(type(parameters), dimensions, types.float64)
    for quantity in quantities_of(type(parameters)):
        where = f"{who}: {place_of(type(parameters), quantity)}"
        try:
            result = _result(parameters, quantity, kinds)
        except Exception as error:  # also errors of Numba itself
            raise UsageError(f"{where} does not compile: {why(error)}") from error
        if quantity == "stress":
            width = state_width(type(parameters), dimensions)
            if width:
                result = _require_state(where, result, width)
            _require_stress(where, result, dimensions)
        elif quantity == "losses":
            _require_losses(where, result)
        elif quantity == "initial_state":
            _require_states(where, result, state_width(type(parameters), dimensions))
        elif result != types.float64:
            raise UsageError(
                f"{where} must return a float, but returns {described(result)}"
                f"{INTEGER_HINT * is_integer(result)}"
            )


def _require_state(where: str, result: NumbaObject, width: int) -> NumbaObject:
    """Refuse a result other than a pair of stress and state; return the type of the stress."""
    if not is_tuple(result) or len(result) != 2:
        raise UsageError(
            f"{where} must return a pair, the stress and the state of {width}, as the material has "
            f"a STATE, but returns {described(result)}"
        )
    _require_states(where, result[1], width)
    return result[0]


def _require_states(where: str, state: NumbaObject, width: int) -> None:
    """Refuse a state other than a tuple of `width` floats."""
    parts = [*state] if is_tuple(state) else []
    if len(parts) != width or any(part != types.float64 for part in parts):
        listed = ": " * bool(parts) + ", ".join(map(described, parts))
        raise UsageError(
            f"{where} must return the state as a tuple of {width} floats, but returns "
            f"{described(state)}{listed}"
        )


def _require_losses(where: str, result: NumbaObject) -> None:
    """Refuse a result other than a tuple with a float for each of `LOSSES`."""
    parts = [*result] if is_tuple(result) else []
    if len(parts) != len(LOSSES) or any(part != types.float64 for part in parts):
        raise UsageError(
            f"{where} must return a tuple of {len(LOSSES)} floats, {', '.join(LOSSES)}, but "
            f"returns {described(result)}"
        )


def _require_stress(where: str, result: NumbaObject, dimensions: int) -> None:
    wanted = _COUNTS[dimensions - 1]
    names = _COMPONENTS[:wanted]
    given = len(result) if is_tuple(result) else None
    if given != wanted:
        raise UsageError(
            f"{where} must return the {wanted} components {' '.join(names)} of a stress in "
            f"{dimensions}D as a tuple, but returns {described(result)}"
        )
    for name, part in zip(names, result, strict=True):
        if part != types.float64:
            raise UsageError(
                f"{where} must return {wanted} floats, but the component {name} is "
                f"{described(part)}{INTEGER_HINT * is_integer(part)}"
            )
