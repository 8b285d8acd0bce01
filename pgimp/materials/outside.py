"""What is asked of materials from outside the package, and said of those that do not fit."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numba
from numba.core import errors, types

from pgimp.errors import UsageError
from pgimp.kernels.outside import is_outside, tag
from pgimp.kernels.simd import vec4
from pgimp.materials.base import Material, _compiled

_ARGUMENTS = {
    "stress": ("material", "F", "J", "sigma", "L", "dt"),
    "energy": ("material", "F", "J", "sigma"),
    "speed": ("material", "F", "J"),
}
_COLOUR = re.compile("\x1b\\[[0-9;]*m")
_LONGEST_MESSAGE = 600


def parameters_of(entry: Material) -> Any:
    """Return the kernels' view of a material, checked where it comes from outside.

    Parameters
    ----------
    entry : Material
        The entry of the case.

    Returns
    -------
    NamedTuple
        Its parameters.

    Raises
    ------
    UsageError
        If something that the kernels need is missing.
    """
    parameters = entry.parameters()  # type: ignore[attr-defined]
    kind = type(parameters)
    if not is_outside(kind):
        return parameters
    who = f"the material '{entry.model}'"  # type: ignore[attr-defined]
    if "density" not in getattr(kind, "_fields", ()):
        raise UsageError(
            f"{who}: parameters() must return a NamedTuple with a density, got {kind.__qualname__}"
        )
    for quantity, names in _ARGUMENTS.items():
        function = inspect.getattr_static(kind, quantity, None)
        call = f"{quantity}({', '.join(names)})"
        if not isinstance(function, staticmethod):
            raise UsageError(f"{who}: {kind.__qualname__} needs a @staticmethod {call}")
        given = len(inspect.signature(function.__func__).parameters)
        if given != len(names):
            raise UsageError(
                f"{who}: {kind.__qualname__}.{quantity} takes {given} arguments instead of {call}"
            )
    tag(kind)
    return parameters


class _Kinds(NamedTuple):
    """Numba's types of what a material's functions are given."""

    F: Any
    J: Any
    sigma: Any
    L: Any
    dt: Any

    @classmethod
    def of(cls, dimensions: int, number: Any) -> _Kinds:
        matrix = types.UniTuple(number, dimensions**2)
        tensor = types.UniTuple(number, (3, 4, 6)[dimensions - 1])
        return cls(matrix, number, tensor, matrix, types.float64)


def _result(parameters: Any, quantity: str, kinds: _Kinds) -> Any:
    """Compile a function of a material for arguments of these types; return the result's."""
    kind: Any = type(parameters)
    function = _compiled(kind, quantity)
    given = (getattr(kinds, name) for name in _ARGUMENTS[quantity][1:])
    signature = (numba.typeof(parameters), *given)
    function.compile(signature)
    return function.overloads[signature].signature.return_type


def takes_vectors(entry: Material, dimensions: int) -> bool:
    """Tell whether a material is computed for four particles at once, as pgimp's own are.

    A function that branches, or calls what knows no vectors, is called for one particle after the
    other: right, but slower. See `pgimp.materials` for what to write instead.

    Parameters
    ----------
    entry : Material
        The material with its constants.
    dimensions : int
        Of the case: 1, 2 or 3.
    """
    parameters = parameters_of(entry)
    try:
        for quantity in ("stress", "speed"):
            _result(parameters, quantity, _Kinds.of(dimensions, vec4))
    except errors.NumbaError:
        return False
    return True


@contextmanager
def explained(materials: tuple[Any, ...], dimensions: int) -> Iterator[None]:
    """Say which material from outside it is that does not compile, and why.

    Parameters
    ----------
    materials : tuple of NamedTuple
        Parameters of the materials in use.
    dimensions : int
        Of the case.

    Raises
    ------
    UsageError
        If kernels do not compile because of it.
    """
    try:
        yield
    except errors.NumbaError:
        for parameters in materials:
            if is_outside(type(parameters)):
                _examine(parameters, dimensions)
        raise


def _examine(parameters: Any, dimensions: int) -> None:
    kinds = _Kinds.of(dimensions, types.float64)
    for quantity in _ARGUMENTS:
        who = f"{type(parameters).__qualname__}.{quantity} of {_file(parameters)}"
        try:
            result = _result(parameters, quantity, kinds)
        except errors.NumbaError as error:
            text = " ".join(_COLOUR.sub("", str(error)).split())
            text = text.partition("pipeline (step: nopython frontend) ")[2] or text
            if len(text) > _LONGEST_MESSAGE:
                text = f"{text[: _LONGEST_MESSAGE - 3]}..."
            raise UsageError(f"{who} does not compile: {text}") from error
        if quantity == "stress":
            number = len(kinds.sigma)
            fits = isinstance(result, types.BaseTuple) and len(result) == number
            if not (fits and all(isinstance(part, types.Number) for part in result)):
                raise UsageError(
                    f"{who} gives {result}, not the {number} numbers xx yy zz xy yz xz of a stress "
                    f"in {dimensions}D"
                )
        elif not isinstance(result, types.Number):
            raise UsageError(f"{who} gives {result}, not a number")


def _file(parameters: Any) -> str:
    try:
        return inspect.getsourcefile(type(parameters)) or type(parameters).__module__
    except (OSError, TypeError):
        return type(parameters).__module__
