"""Evaluation of a scene's materials in kernels: for one particle, or for four at once."""

from functools import cache
from math import isqrt

import numba
from numba.core import errors, types
from numba.extending import overload

from pgimp.jit.kernel import INLINE_OPTIONS
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


def evaluate(quantity, materials, k, args, state):
    """Value of "stress", "energy", "speed", .. of material number `k` of the scene's tuple.

    Materials of one type are indexed; different types become a chain of branches; a single
    material costs neither. The quantities in `OPTIONAL` are optional.

    Parameters
    ----------
    quantity : str
        A literal.
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


@overload(evaluate, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _evaluate(quantity, materials, k, args, state):
    if not isinstance(quantity, types.Literal):
        return None  # Numba tries that too, after an error in a material
    name = quantity.literal_value
    if len(materials) == 1:
        return lambda quantity, materials, k, args, state: _ask(name, materials[0], args, state)
    if len(set(materials)) == 1:
        return lambda quantity, materials, k, args, state: _ask(name, materials[k], args, state)

    def branch(quantity, materials, k, args, state):
        if k == 0:
            return _ask(name, materials[0], args, state)
        return evaluate(name, materials[1:], k - 1, args, state)

    def branch_of_vectors(quantity, materials, k, args, state):
        if k == 0:  # models may differ: one returns a number, another a vector
            return vectors_as(_ask(name, materials[0], args, state), args[0][0])
        return vectors_as(evaluate(name, materials[1:], k - 1, args, state), args[0][0])

    return branch_of_vectors if has_vectors(args) else branch


def _ask(quantity, material, args, state):
    """Value of a quantity of one material, see `evaluate`; `state` is cut to its own states."""


@overload(_ask, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _ask_material(quantity, material, args, state):
    if not isinstance(quantity, types.Literal):
        return None
    name, kind = quantity.literal_value, material.instance_class
    if name in OPTIONAL and not has(kind, name):
        value = OPTIONAL[name]
        if value is None:
            return lambda quantity, material, args, state: state
        return lambda quantity, material, args, state: value
    function = compiled(kind, name)
    own = state_width(kind, isqrt(len(args[0])))
    if name == "stress" and len(args) > _WITHOUT_Q and not takes_viscous_pressure(kind):
        return lambda quantity, material, args, state: _ask(
            name, material, args[:_WITHOUT_Q], state
        )
    if name == "stress" and len(args) == _WITHOUT_Q and takes_viscous_pressure(kind):
        return lambda quantity, material, args, state: _ask(name, material, (*args, 0.0), state)
    if len(state) == 0:
        return lambda quantity, material, args, state: function(material, *args)
    if own == 0 and name == "stress":
        return lambda quantity, material, args, state: (*function(material, *args), *state)
    if own == 0:
        return lambda quantity, material, args, state: function(material, *args)
    if name == "initial_state":
        return lambda quantity, material, args, state: (
            *function(material, *args, state[:own]),
            *state[own:],
        )
    if name != "stress":
        return lambda quantity, material, args, state: function(material, *args, state[:own])

    def stress(quantity, material, args, state):
        sigma, now = function(material, *args, state[:own])
        return (*sigma, *now, *state[own:])

    return stress


def _takes_vectors(
    material: NumbaObject, quantity: str, args: NumbaObject, state: NumbaObject
) -> bool:
    """Whether a material's function compiles for vectors; functions with branches do not."""
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


def _number_of(numbers, j):
    """Number of the material of particle `j`, see `evaluate_four`."""


@overload(_number_of, jit_options=INLINE_OPTIONS, strict=False)
def _number_of_one(numbers, j):
    if isinstance(numbers, types.Integer):
        return lambda numbers, j: numbers
    return lambda numbers, j: numbers[j]


def evaluate_four(quantity, materials, numbers, args, state, like):
    """As `evaluate`, for four particles, or for eight.

    `args` and `state` are vectors or tuples of vectors. So is the result, with the structure of
    `like`. `numbers` are the particles' materials: a tuple of four, or one number for all. A
    function with branches takes no vectors and is called particle by particle. Parameters that vary
    in space are vectors as well, see `pgimp.kernels.update.varying`.
    """


@overload(evaluate_four, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _evaluate_four(quantity, materials, numbers, args, state, like):
    if not isinstance(quantity, types.Literal):
        return None
    name, lanes = quantity.literal_value, lanes_of(like)
    if not all(_takes_vectors(material, name, args, state) for material in materials):

        def one_by_one(quantity, materials, numbers, args, state, like):
            values = like
            for j in range(lanes):
                k = _number_of(numbers, j)
                one = evaluate(name, materials, k, of_lane(args, j), of_lane(state, j))
                values = with_lanes(values, j, one)
            return values

        def one_by_one_of_own(quantity, materials, numbers, args, state, like):
            values = like
            for j in range(lanes):
                own, given = of_lane(materials, j), of_lane(args, j)
                one = evaluate(name, own, _number_of(numbers, j), given, of_lane(state, j))
                values = with_lanes(values, j, one)
            return values

        return one_by_one_of_own if has_vectors(materials) else one_by_one
    if len(materials) == 1:
        return lambda quantity, materials, numbers, args, state, like: vectors_as(
            evaluate(name, materials, 0, args, state), args[0][0]
        )
    if isinstance(numbers, types.Integer):
        return lambda quantity, materials, numbers, args, state, like: vectors_as(
            evaluate(name, materials, numbers, args, state), args[0][0]
        )

    def by_material(quantity, materials, numbers, args, state, like):
        kinds = pack(float(numbers[0]), float(numbers[1]), float(numbers[2]), float(numbers[3]))
        values = like
        done = 0
        for j in range(4):
            if done >> j & 1 == 0:
                mask = kinds == numbers[j]
                found = evaluate(name, materials, numbers[j], args, state)
                values = where_all(mask, vectors_as(found, args[0][0]), values)
                done |= bits(mask)
        return values

    return by_material
