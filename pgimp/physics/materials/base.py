"""What the entries of all materials have in common, and the kernels' view of a material."""

from functools import cache
from typing import Annotated, Any, ClassVar

import numba
from numba.core import errors, types
from numba.extending import overload
from pydantic import Field

from pgimp.jit.kernel import INLINE_OPTIONS
from pgimp.jit.lanes import has_vectors, of_lane, vectors, where_all, with_lanes
from pgimp.jit.simd import bits, pack
from pgimp.schema.base import Model, NonNegative, Number, Positive

Poisson = Annotated[
    Number, Field(gt=-1.0, lt=0.5, description="Poisson's ratio, above -1 and below 0.5 [1]")
]
Young = Annotated[Positive, Field(description="Young's modulus [stress]")]


class ArtificialViscosity(Model):
    """Pressure in compression that spreads shocks over some cells (45)."""

    linear: NonNegative = Field(
        description="c1 in q = c1 rho c L |D| + c2 rho (L D)^2, D the rate of volume change where "
        "it is negative, c the wave speed, L the smallest side of a cell [1]"
    )
    quadratic: NonNegative = Field(description="c2 [1]")


class Material(Model):
    """Base of the entries ``materials.NAME``."""

    CARRIES_STRESS: ClassVar[bool] = False
    """Whether the stress of a step starts from that before, which a file of particles may give."""

    density: Positive = Field(description="initial density [mass/volume]")
    viscosity: ArtificialViscosity | None = Field(
        default=None, description="artificial viscosity; null: none"
    )


def lame(young: float, poisson: float) -> tuple[float, float]:
    """Lame's constants lambda and mu, in the unit of `young`."""
    mu = young / (2.0 * (1.0 + poisson))
    return 2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu


@cache
def _compiled(parameters: type, quantity: str):
    return numba.njit(**INLINE_OPTIONS)(getattr(parameters, quantity))


def evaluate(quantity, materials, k, args):
    """Value of "stress", "energy" or "speed" of material number `k` of the scene's tuple.

    Materials of one model are indexed; different models become a chain of branches; one material
    alone costs neither (``args`` as in `pgimp.physics.materials`).
    """


@overload(evaluate, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _evaluate(quantity, materials, k, args):
    if not isinstance(quantity, types.Literal):
        return None  # Numba tries that too, after an error in a material
    name = quantity.literal_value
    models = [material.instance_class for material in materials]
    function = _compiled(models[0], name)
    if len(models) == 1:
        return lambda quantity, materials, k, args: function(materials[0], *args)
    if len(set(models)) == 1:
        return lambda quantity, materials, k, args: function(materials[k], *args)

    def branch(quantity, materials, k, args):
        if k == 0:
            return function(materials[0], *args)
        return evaluate(name, materials[1:], k - 1, args)

    def branch_of_vectors(quantity, materials, k, args):
        if k == 0:  # one model may give a number where another gives a vector
            return vectors(function(materials[0], *args))
        return vectors(evaluate(name, materials[1:], k - 1, args))

    return branch_of_vectors if has_vectors(args) else branch


def _takes_vectors(material: Any, quantity: str, args: Any) -> bool:
    """Whether a material's function compiles for vectors: one that branches does not."""
    try:
        _compiled(material.instance_class, quantity).compile((material, *args))
    except errors.NumbaError:
        return False
    return True


def evaluate_four(quantity, materials, numbers, args, like):
    """As `evaluate`, of four particles.

    `args` are vectors or tuples of them; so is the result, which is of the kind of `like`.
    `numbers` are the particles' materials, a tuple of four. A function that cannot take vectors,
    because it branches, is called for one particle after the other.
    """


@overload(evaluate_four, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _evaluate_four(quantity, materials, numbers, args, like):
    if not isinstance(quantity, types.Literal):
        return None
    name = quantity.literal_value
    if not all(_takes_vectors(material, name, args) for material in materials):

        def one_by_one(quantity, materials, numbers, args, like):
            values = like
            for j in range(4):
                one = evaluate(name, materials, numbers[j], of_lane(args, j))
                values = with_lanes(values, j, one)
            return values

        return one_by_one
    if len(materials) == 1:
        return lambda quantity, materials, numbers, args, like: vectors(
            evaluate(name, materials, 0, args)
        )

    def by_material(quantity, materials, numbers, args, like):
        kinds = pack(float(numbers[0]), float(numbers[1]), float(numbers[2]), float(numbers[3]))
        values = like
        done = 0
        for j in range(4):
            if done >> j & 1 == 0:
                mask = kinds == numbers[j]
                found = vectors(evaluate(name, materials, numbers[j], args))
                values = where_all(mask, found, values)
                done |= bits(mask)
        return values

    return by_material
