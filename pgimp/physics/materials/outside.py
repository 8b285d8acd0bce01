"""What is asked of materials from outside the package, and said of those that do not fit.

The kernels write what a material returns into columns of fixed width, so a stress with a component
too many would end up in the next particle. Its functions are therefore compiled on their own, with
numbers of the types that the kernels use, and what they return is compared with what is wanted,
before any kernel is compiled. What fits is remembered beside the kernels that are kept for the
material (see `pgimp.jit.outside`), so that only the first start takes the second or two.
"""

from __future__ import annotations

import inspect
import re
from math import isfinite
from types import FunctionType
from typing import Any, NamedTuple

import numba
from numba.core import errors, types

from pgimp.errors import UsageError
from pgimp.jit.cache import Store
from pgimp.jit.kernel import FOLDER
from pgimp.jit.outside import is_outside, part_of, tag
from pgimp.jit.simd import vec4
from pgimp.physics.fields import EVERY
from pgimp.physics.materials.base import (
    LOSSES,
    OPTIONAL,
    STATE_NAME,
    Material,
    State,
    _compiled,
    has,
    state_width,
    states_of,
    takes_viscous_pressure,
    with_states,
)

_ARGUMENTS = {
    "stress": ("material", "F", "J", "sigma", "L", "dt"),
    "energy": ("material", "F", "J", "sigma"),
    "speed": ("material", "F", "J"),
    "diffusivity": ("material", "F", "J"),
    "margin": ("material", "F", "J", "sigma"),
    "losses": ("material", "F", "J", "sigma"),
}
#: Functions that are called for a line of the history only, and may branch.
_FOR_HISTORY = ("energy", "losses")
#: Components of a symmetric tensor, as `pgimp.jit.algebra` has them, and how many there are.
_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
_COUNTS = (3, 4, 6)
_COLOUR = re.compile("\x1b\\[[0-9;]*m")
_LONGEST_MESSAGE = 600
_INTEGER_HINT = "; write 0.0 for 0"

_fitting: set[tuple[type, str, int]] = set()


def parameters_of(entry: Material, dimensions: int) -> Any:
    """Return the kernels' view of a material, checked where it comes from outside.

    Parameters
    ----------
    entry : Material
        The entry of the case.
    dimensions : int
        Of the case: 1, 2 or 3.

    Returns
    -------
    NamedTuple
        Its parameters.

    Raises
    ------
    UsageError
        If something that the kernels need is missing, or is not of the type that they need.
    """
    who = f"the material '{entry.model}'"  # type: ignore[attr-defined]
    try:
        parameters = entry.parameters()  # type: ignore[attr-defined]
    except Exception as error:
        if not is_outside(type(entry)):
            raise
        raise UsageError(
            f"{who}: {type(entry).__qualname__}.parameters() of {_file(type(entry))} fails: "
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
    for quantity in _quantities(kind):
        names = _arguments(kind, quantity)
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
                f"{who}: {_place(kind, quantity)} takes {given} arguments instead of {call}"
            )
    _require_told(who, entry, kind)
    tag(kind)
    _require_fit(who, parameters, dimensions)
    return parameters


def _require_told(who: str, entry: Material, kind: type) -> None:
    """Refuse losses that are not known, or that no function tells."""
    if not isinstance(entry.LOSSES, tuple) or not set(entry.LOSSES) <= set(LOSSES):
        raise UsageError(
            f"{who}: LOSSES of {type(entry).__qualname__} ({_file(type(entry))}) must be a tuple "
            f"of some of {', '.join(LOSSES)}"
        )
    if bool(entry.LOSSES) != has(kind, "losses"):
        raise UsageError(
            f"{who}: LOSSES of {type(entry).__qualname__} and the function losses of "
            f"{kind.__qualname__} belong together; one of them is missing"
        )


def _arguments(kind: type, quantity: str) -> tuple[str, ...]:
    """Names of what a material's function is given; those with a memory get their state as well."""
    q = ("q",) if quantity == "stress" and takes_viscous_pressure(kind) else ()
    return (*_ARGUMENTS[quantity], *q, *(("state",) if states_of(kind) else ()))


def _quantities(kind: type) -> list[str]:
    """Functions that a material must have, and those that it has besides."""
    return [name for name in _ARGUMENTS if name not in OPTIONAL or has(kind, name)]


def _require_states(who: str, entry: Material, parameters: Any) -> None:
    """Refuse state variables that are not declared as they must be."""
    kind = type(entry)
    names: list[str] = []
    states: Any = entry.states
    if not isinstance(states, tuple) or not all(isinstance(each, State) for each in states):
        raise UsageError(
            f"{who}: STATE of {kind.__qualname__} ({_file(kind)}) must be a tuple of "
            'pgimp.physics.materials.State, as in STATE = (State("damage", "1", "what it is"),)'
        )
    for each in states:
        where = f"{who}: the state {each.name!r} of {kind.__qualname__} ({_file(kind)})"
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


class _Kinds(NamedTuple):
    """Numba's types of what a material's functions are given."""

    F: Any
    J: Any
    sigma: Any
    L: Any
    dt: Any
    state: Any
    q: Any

    @classmethod
    def of(cls, kind: type, dimensions: int, number: Any) -> _Kinds:
        matrix = types.UniTuple(number, dimensions**2)
        tensor = types.UniTuple(number, _COUNTS[dimensions - 1])
        state = types.UniTuple(number, state_width(kind, dimensions))
        return cls(matrix, number, tensor, matrix, types.float64, state, number)


def _result(parameters: Any, quantity: str, kinds: _Kinds) -> Any:
    """Compile a function of a material for arguments of these types; return the result's."""
    kind: Any = type(parameters)
    function = _compiled(kind, quantity)
    given = (getattr(kinds, name) for name in _arguments(kind, quantity)[1:])
    signature = (numba.typeof(parameters), *given)
    function.compile(signature)
    return function.overloads[signature].signature.return_type


def takes_vectors(entry: Material, dimensions: int) -> bool:
    """Return whether a material is computed for four particles at once, as pgimp's own are.

    A function that branches, or calls what knows no vectors, is called for one particle after the
    other: right, but slower. See `pgimp.physics.materials` for what to write instead.

    Parameters
    ----------
    entry : Material
        The material with its constants.
    dimensions : int
        Of the case: 1, 2 or 3.

    Raises
    ------
    UsageError
        If it does not fit at all, as in a run.
    """
    parameters = parameters_of(entry, dimensions)
    try:
        for quantity in _quantities(type(parameters)):
            if quantity in _FOR_HISTORY:
                continue
            _result(parameters, quantity, _Kinds.of(type(parameters), dimensions, vec4))
    except errors.NumbaError:
        return False
    return True


def _require_fit(who: str, parameters: Any, dimensions: int) -> None:
    """Refuse a material whose functions do not compile or do not return what is wanted."""
    kind = type(parameters)
    for name, value in zip(kind._fields, parameters, strict=True):
        try:
            numba.typeof(value)
        except (ValueError, errors.NumbaError):
            raise UsageError(
                f"{who}: {name} of {kind.__qualname__} ({_file(kind)}) is of the type "
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


def _examine(who: str, parameters: Any, dimensions: int) -> None:
    kinds = _Kinds.of(type(parameters), dimensions, types.float64)
    for quantity in _quantities(type(parameters)):
        where = f"{who}: {_place(type(parameters), quantity)}"
        try:
            result = _result(parameters, quantity, kinds)
        except Exception as error:  # also what Numba itself fails with
            text = " ".join(_COLOUR.sub("", str(error)).split())
            text = text.partition("pipeline (step: nopython frontend) ")[2] or text
            if len(text) > _LONGEST_MESSAGE:
                text = f"{text[: _LONGEST_MESSAGE - 3]}..."
            raise UsageError(f"{where} does not compile: {text}") from error
        if quantity == "stress":
            width = state_width(type(parameters), dimensions)
            if width:
                result = _require_state(where, result, width)
            _require_stress(where, result, dimensions)
        elif quantity == "losses":
            _require_losses(where, result)
        elif result != types.float64:
            raise UsageError(
                f"{where} must return a float, but returns {_described(result)}"
                f"{_INTEGER_HINT * _is_integer(result)}"
            )


def _require_state(where: str, result: Any, width: int) -> Any:
    """Refuse what is not a pair of stress and state; return the type of the stress."""
    if not _is_tuple(result) or len(result) != 2:
        raise UsageError(
            f"{where} must return a pair, the stress and the state of {width}, as the material has "
            f"a STATE, but returns {_described(result)}"
        )
    state = result[1]
    parts = [*state] if _is_tuple(state) else []
    if len(parts) != width or any(part != types.float64 for part in parts):
        listed = ": " * bool(parts) + ", ".join(map(_described, parts))
        raise UsageError(
            f"{where} must return the state as a tuple of {width} floats, but returns "
            f"{_described(state)}{listed}"
        )
    return result[0]


def _require_losses(where: str, result: Any) -> None:
    """Refuse what is no tuple with a float for each of `LOSSES`."""
    parts = [*result] if _is_tuple(result) else []
    if len(parts) != len(LOSSES) or any(part != types.float64 for part in parts):
        raise UsageError(
            f"{where} must return a tuple of {len(LOSSES)} floats, {', '.join(LOSSES)}, but "
            f"returns {_described(result)}"
        )


def _require_stress(where: str, result: Any, dimensions: int) -> None:
    wanted = _COUNTS[dimensions - 1]
    names = _COMPONENTS[:wanted]
    given = len(result) if isinstance(result, types.BaseTuple) else None
    if given != wanted:
        raise UsageError(
            f"{where} must return the {wanted} components {' '.join(names)} of a stress in "
            f"{dimensions}D as a tuple, but returns {_described(result)}"
        )
    for name, part in zip(names, result, strict=True):
        if part != types.float64:
            raise UsageError(
                f"{where} must return {wanted} floats, but the component {name} is "
                f"{_described(part)}{_INTEGER_HINT * _is_integer(part)}"
            )


def _is_tuple(kind: Any) -> bool:
    return isinstance(kind, types.BaseTuple)


def _is_integer(kind: Any) -> bool:
    return isinstance(kind, types.Integer | types.IntegerLiteral)


def _described(kind: Any) -> str:
    """Put a Numba type in words."""
    if isinstance(kind, types.BaseTuple):
        return f"a tuple of {len(kind)}"
    for known, words in (
        (types.Optional, "None in some cases"),
        (types.NoneType, "None"),
        (types.Boolean, "a bool"),
        (types.Complex, "a complex number"),
        (types.Array, "an array"),
    ):
        if isinstance(kind, known):
            return words
    return "an int" if _is_integer(kind) else "a float" if kind == types.float64 else str(kind)


def _place(kind: type, quantity: str) -> str:
    """Name a function of a material's parameters, with its file and line."""
    code = getattr(kind, quantity).__code__
    return f"{kind.__qualname__}.{quantity} ({code.co_filename}:{code.co_firstlineno})"


def _file(kind: type) -> str:
    try:
        return inspect.getsourcefile(kind) or kind.__module__
    except (OSError, TypeError):
        return kind.__module__
