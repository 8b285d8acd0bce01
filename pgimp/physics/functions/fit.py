"""Checks that functions of one's own compile and return what kernels need.

They are compiled first by themselves, for the types that kernels give them. A passed check is kept
beside the kernels, as for materials (`pgimp.physics.materials.parameters.fit`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numba
from numba.core import types

from pgimp.jit.compiled.cache import Store
from pgimp.jit.kernel import FOLDER
from pgimp.jit.outside import NumbaObject, part_of
from pgimp.jit.results import INTEGER_HINT, described, is_integer, is_tuple, why
from pgimp.physics.functions.call import compiled
from pgimp.physics.functions.registry import COEFFICIENT, EXACT_SOLUTION, STRESS, Function

_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
_COUNTS = (3, 4, 6)

_fitting: dict[tuple[type, str, int], str] = {}


def unfit(function: Function, source: Any, dimensions: int) -> str:
    """Return why kernels cannot use a function with its parameters; empty if they can.

    Parameters
    ----------
    source : NamedTuple
        The function with its parameters, see `source_of`.
    dimensions : int
        Of the case.
    """
    kind, typed = type(source), numba.typeof(source)
    known = (kind, str(typed), dimensions)
    if known in _fitting:
        return _fitting[known]
    part = part_of((typed,))
    store = None if part is None else Store(FOLDER.path / part)
    name, key = f"{kind.__module__}.{kind.__qualname__}-fits", (numba.__version__, *known[1:])
    text = ""
    if store is None or not store.load(name, key):
        text = _examined(function, typed, dimensions)
        if store is not None and not text:
            store.save(name, key, True)
    _fitting[known] = text
    return text


def _examined(function: Function, typed: NumbaObject, dimensions: int) -> str:
    vector = types.UniTuple(types.float64, dimensions)
    given = [types.float64 if name == "t" else vector for name in function.given]
    plain = compiled(typed.instance_class)
    signature = (*given, *typed.types[1])
    try:
        plain.compile(signature)
        result = plain.overloads[signature].signature.return_type
    except Exception as error:  # also errors of Numba itself
        return f"{function} does not compile: {why(error)}"
    wrong = next(_wrong(function, result, dimensions), "")
    return f"{function} {wrong}" if wrong else ""


def _wrong(function: Function, result: NumbaObject, dimensions: int) -> Iterator[str]:
    """Yield what is wrong with the type of a result."""
    components = _COMPONENTS[: _COUNTS[dimensions - 1]]
    if function.kind == COEFFICIENT:
        if result != types.float64:
            hint = INTEGER_HINT * is_integer(result)
            yield f"must return a float, but returns {described(result)}{hint}"
    elif function.kind == STRESS:
        yield from _not_floats(result, components, f"a stress in {dimensions}D")
    elif function.kind != EXACT_SOLUTION:
        yield from _not_floats(result, tuple("xyz"[:dimensions]), f"a vector in {dimensions}D")
    elif not is_tuple(result) or len(result) != 3:
        yield (
            "must return three tuples, displacement, velocity and stress, but returns "
            f"{described(result)}"
        )
    else:
        axes = tuple("xyz"[:dimensions])
        for part, names, what in zip(
            result, (axes, axes, components), ("displacement", "velocity", "stress"), strict=True
        ):
            yield from _not_floats(part, names, f"the {what} in {dimensions}D")


def _not_floats(result: NumbaObject, names: tuple[str, ...], what: str) -> Iterator[str]:
    if not is_tuple(result) or len(result) != len(names):
        yield (
            f"must return the {len(names)} components {' '.join(names)} of {what} as a tuple, but "
            f"returns {described(result)}"
        )
        return
    for name, part in zip(names, result, strict=True):
        if part != types.float64:
            yield (
                f"must return floats, but the component {name} of {what} is {described(part)}"
                f"{INTEGER_HINT * is_integer(part)}"
            )
