"""Evaluation of a scene's materials in kernels: for one particle, or for four at once."""

from functools import cache
from math import isqrt

import numba
from numba.core import errors, types

from pgimp.jit.kernel import INLINE_OPTIONS, class_of, inlined, is_number, of_types
from pgimp.jit.outside import NumbaObject, is_outside
from pgimp.jit.vectors.lanes import (
    has_vectors,
    lanes_of,
    of_lane,
    vectors_as,
    where_all,
    with_lanes,
)
from pgimp.jit.vectors.simd import bits, pack
from pgimp.physics.materials.base import OPTIONAL, has, state_width, takes_viscous_pressure

#: Arguments of "stress" besides the material, the viscous pressure and the state.
_WITHOUT_Q = 5


@cache
def compiled(parameters: type, quantity: str):
    """Return the Numba function of a quantity, for materials with this type of parameters."""
    options = {**INLINE_OPTIONS, "_nrt": is_outside(parameters)}  # user materials may make arrays
    return numba.njit(**options)(getattr(parameters, quantity))


@inlined
def evaluate(quantity, materials, k, args, state):
    """Value of "stress", "energy", "speed", .. of material number `k` of the scene's tuple.

    Materials of one type are indexed; different types become a chain of branches; a single
    material costs neither. The quantities in `OPTIONAL` are optional.

    Parameters
    ----------
    quantity : str
        Its name.
    materials : tuple of NamedTuple
        The scene's.
    k : int
        Number of the material.
    args : tuple
        As in `pgimp.physics.materials`, without the state; F comes first. For "stress" the viscous
        pressure may come last. Materials without that argument do not get it. Materials with it
        get 0 if it is missing.
    state : tuple of float
        As many as the widest material of the scene has; () if none has any.

    Returns
    -------
    float or tuple
        For "stress" the components, followed by the state after the step. For "initial_state" the
        state, unchanged if the material has no such function. For "losses" one number for each of
        `LOSSES`, zeros if the material has none.
    """
    if len(materials) == 1:
        return _ask(quantity, materials[0], args, state)
    if _are_alike(materials):
        return _ask(quantity, materials[k], args, state)
    if not has_vectors(args):
        if k == 0:
            return _ask(quantity, materials[0], args, state)
        return evaluate(quantity, materials[1:], k - 1, args, state)
    if k == 0:  # models may differ: one returns a number, another a vector
        return vectors_as(_ask(quantity, materials[0], args, state), args[0][0])
    return vectors_as(evaluate(quantity, materials[1:], k - 1, args, state), args[0][0])


@of_types
def _are_alike(materials):
    """Whether all materials are of one type."""
    return len(set(materials)) == 1


@inlined
def _ask(quantity, material, args, state):
    """Value of a quantity of one material, see `evaluate`; `state` is cut to its own states."""
    kind = class_of(material)
    if quantity in OPTIONAL and not has(kind, quantity):
        return state if quantity == "initial_state" else OPTIONAL[quantity]
    function = compiled(kind, quantity)
    own = state_width(kind, isqrt(len(args[0])))
    if quantity == "stress" and takes_viscous_pressure(kind) and len(args) == _WITHOUT_Q:
        return _ask(quantity, material, (*args, 0.0), state)
    if quantity == "stress" and not takes_viscous_pressure(kind):
        args = args[:_WITHOUT_Q]
    if quantity == "stress" and own > 0:
        sigma, now = function(material, *args, state[:own])
        return (*sigma, *now, *state[own:])
    if quantity == "stress":
        return (*function(material, *args), *state)
    if own == 0:
        return function(material, *args)
    if quantity == "initial_state":
        return (*function(material, *args, state[:own]), *state[own:])
    return function(material, *args, state[:own])


@of_types
def _take_vectors(quantity, materials, args, state):
    """Whether the materials' functions compile for vectors; those with branches do not."""
    return all(_takes_vectors(material, quantity, args, state) for material in materials)


def _takes_vectors(
    material: NumbaObject, quantity: str, args: NumbaObject, state: NumbaObject
) -> bool:
    """Whether a material's function compiles for vectors."""
    kind = material.instance_class
    if quantity in OPTIONAL and not has(kind, quantity):
        return True
    own = state_width(kind, isqrt(len(args[0])))
    seen = (types.UniTuple(state[0], own),) if own else ()
    if quantity == "stress":
        q = (args[_WITHOUT_Q] if len(args) > _WITHOUT_Q else types.float64,)
        args = (*args[:_WITHOUT_Q], *(q if takes_viscous_pressure(kind) else ()))
    try:
        compiled(kind, quantity).compile((material, *args, *seen))
    except errors.NumbaError:
        return False
    return True


@inlined
def evaluate_four(quantity, materials, numbers, args, state, like):
    """As `evaluate`, for four particles, or for eight.

    `args` and `state` are vectors or tuples of vectors. So is the result, with the structure of
    `like`. `numbers` are the particles' materials: a tuple of four, or one number for all. A
    function with branches takes no vectors and is called particle by particle. Parameters that vary
    in space are vectors as well, see `pgimp.kernels.update.varying`.
    """
    if not _take_vectors(quantity, materials, args, state):
        values = like
        for j in range(lanes_of(like)):
            k = numbers if is_number(numbers) else numbers[j]
            own = of_lane(materials, j) if has_vectors(materials) else materials
            one = evaluate(quantity, own, k, of_lane(args, j), of_lane(state, j))
            values = with_lanes(values, j, one)
        return values
    if len(materials) == 1:
        return vectors_as(evaluate(quantity, materials, 0, args, state), args[0][0])
    if is_number(numbers):
        return vectors_as(evaluate(quantity, materials, numbers, args, state), args[0][0])
    kinds = pack(float(numbers[0]), float(numbers[1]), float(numbers[2]), float(numbers[3]))
    values = like
    done = 0
    for j in range(4):
        if done >> j & 1 == 0:
            mask = kinds == numbers[j]
            found = evaluate(quantity, materials, numbers[j], args, state)
            values = where_all(mask, vectors_as(found, args[0][0]), values)
            done |= bits(mask)
    return values
