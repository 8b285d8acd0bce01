"""Functions of one's own, registered by their name in a case.

A case is data and never names code: ``{function: my-name, parameters: {...}}`` names a function
that a file on the command line (``--import``), or a program, has registered by a decorator. What a
function may be given, it takes by the names of its arguments; all others are parameters, which the
case gives. Nothing is compiled here.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from math import isfinite
from types import FunctionType
from typing import Any, NamedTuple, TypeVar

from pgimp.errors import UsageError

F = TypeVar("F", bound=Callable[..., Any])

#: A number or a list of numbers.
Value = float | tuple[float, ...]

#: Names in a case.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,99}")


class Kind(NamedTuple):
    """A kind of functions: its name, what they may be given, and what they return."""

    name: str
    given: tuple[str, ...]
    returns: str

    def __str__(self) -> str:
        """Return the words for it."""
        return self.name.replace("_", " ")


BODY_FORCE = Kind("body_force", ("X", "x", "v", "t"), "a component for each direction")
VELOCITY = Kind("velocity", ("x", "t"), "a component for each direction")
STRESS = Kind("stress", ("x",), "the components of a stress")
COEFFICIENT = Kind("coefficient", ("x", "t"), "a number")
EXACT_SOLUTION = Kind(
    "exact_solution", ("X", "x", "t"), "displacement, velocity and stress: a tuple of three tuples"
)


class Function(NamedTuple):
    """A registered function."""

    name: str  #: In a case.
    kind: Kind  #: What it is.
    function: Any  #: function: The Python function.
    given: tuple[str, ...]  #: What it is given first, in this order.
    #: Its parameters, by their names in a case, with their defaults.
    defaults: dict[str, Value | None]

    @property
    def place(self) -> str:
        """Its file and line."""
        code = self.function.__code__
        return f"{code.co_filename}:{code.co_firstlineno}"

    def __str__(self) -> str:
        """Return the words for it, with its place."""
        return f"the {self.kind} '{self.name}' ({self.place})"

    def __deepcopy__(self, memo: object) -> Function:
        """Return the function itself, of which there is one."""
        return self


#: The functions by their name in a case.
FUNCTIONS: dict[str, Function] = {}


def spelled(name: str) -> str:
    """Return a name of Python as cases write it."""
    return name.replace("_", "-")


def register(kind: Kind, function: Any, name: str | None) -> Any:
    """Register a function, and return it.

    Raises
    ------
    UsageError
        If it is none, has other arguments, or its name is taken; with its file and line.
    """
    if not isinstance(function, FunctionType):
        raise UsageError(
            f"cannot register {function!r}: a {kind} is a plain function, which pgimp compiles "
            f"itself; it is of the type {type(function).__name__}"
        )
    code = function.__code__
    where = f"{code.co_filename}:{code.co_firstlineno}: {function.__qualname__}"
    name = spelled(function.__name__) if name is None else name
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise UsageError(
            f"{where}: the name {name!r} cannot be one in a case: a letter, then letters, digits, "
            "'-' and '_'"
        )
    given, defaults = _arguments(kind, function, where)
    new = Function(name, kind, function, given, defaults)
    known = FUNCTIONS.get(name)
    if known is not None and _origin(known.function) != _origin(function):
        raise UsageError(
            f"{where}: there is a function '{name}' already, {known}; give it another name, "
            f'@pgimp.{kind.name}("another-name")'
        )
    FUNCTIONS[name] = new
    return function


def _origin(function: FunctionType) -> tuple[str, str]:
    return function.__module__, function.__qualname__


def _arguments(
    kind: Kind, function: FunctionType, where: str
) -> tuple[tuple[str, ...], dict[str, Value | None]]:
    """Split the arguments of a function into what it is given and its parameters."""
    given: list[str] = []
    defaults: dict[str, Value | None] = {}
    for name, argument in inspect.signature(function).parameters.items():
        if argument.kind != argument.POSITIONAL_OR_KEYWORD:
            raise UsageError(
                f"{where}: takes {argument}, but a {kind} has arguments of fixed names alone: "
                f"{', '.join(kind.given)}, as far as it needs them, and then its parameters"
            )
        if name in kind.given:
            if defaults:
                raise UsageError(
                    f"{where}: {name} comes after parameters; first {', '.join(kind.given)}, as "
                    "far as it needs them, and then its parameters"
                )
            given.append(name)
        elif name in BODY_FORCE.given:
            raise UsageError(
                f"{where}: a {kind} is not given {name}, but {', '.join(kind.given)}; take another "
                "name for a parameter"
            )
        elif not _NAME.fullmatch(spelled(name)):
            raise UsageError(f"{where}: the parameter {name} cannot be a key of a case")
        else:
            has = argument.default is not argument.empty
            defaults[spelled(name)] = _default(argument.default, where, name) if has else None
    return tuple(given), defaults


def _default(value: Any, where: str, name: str) -> Value:
    """Return the default of a parameter as floats."""
    parts = value if isinstance(value, tuple) and value else (value,)
    for part in parts:
        if isinstance(part, bool) or not isinstance(part, int | float) or not isfinite(part):
            raise UsageError(
                f"{where}: the default of {name} must be a finite number or a tuple of them, "
                f"not {value!r}"
            )
    return tuple(map(float, parts)) if isinstance(value, tuple) else float(value)
