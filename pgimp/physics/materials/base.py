"""What the entries of all materials have in common, and the kernels' view of a material."""

import re
from functools import cache
from inspect import getattr_static
from math import isqrt
from typing import Annotated, Any, ClassVar, NamedTuple

import numba
from numba.core import errors, types
from numba.extending import overload
from pydantic import Field

from pgimp.jit.kernel import INLINE_OPTIONS
from pgimp.jit.lanes import has_vectors, of_lane, vectors, where_all, with_lanes
from pgimp.jit.outside import is_outside
from pgimp.jit.simd import bits, pack
from pgimp.physics.materials.vary import Varying
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


#: What a material may say of energy that it does not give back: columns of the history.
LOSSES = ("plastic-work", "viscous-work", "heat")

#: What a state variable may be called.
STATE_NAME = re.compile("[a-z][a-z0-9-]*")


class State(NamedTuple):
    """A state variable of a material: what its particles remember besides their stress.

    Attributes
    ----------
    name : str
        As ``output.fields`` and probes name it: small letters, digits and ``-``.
    unit : str
        Its unit, ``1`` for none.
    meaning : str
        What it is, for the reference and for the datasets of frames.
    initial : float or str
        Its value at the start, or the name of a number among the material's parameters.
    tensor : bool
        Whether it is a symmetric tensor, with the components of a stress, or one number.
    """

    name: str
    unit: str
    meaning: str
    initial: float | str = 0.0
    tensor: bool = False

    def width(self, dimensions: int) -> int:
        """Numbers that it takes."""
        return (3, 4, 6)[dimensions - 1] if self.tensor else 1


class Material(Varying):
    """Base of the entries ``materials.NAME``."""

    CARRIES_STRESS: ClassVar[bool] = False
    """Whether the stress of a step starts from that before, which a file of particles may give."""

    ELASTIC: ClassVar[bool] = False
    """Whether it springs back whatever it goes through: it never flows, yields or breaks."""

    STATE: ClassVar[tuple[State, ...]] = ()
    """What its particles remember besides their stress; see `pgimp.physics.materials`."""

    VOLUME_ONLY: ClassVar[bool] = False
    """Whether of its particles' deformation only the volume is followed: F is then J^(1/D) 1."""

    TAKES_VISCOUS_PRESSURE: ClassVar[bool] = False
    """Whether ``stress`` gets, after `dt`, the pressure q of the artificial viscosity in the step,
    0 without any: it heats the material by q per decrease of volume."""

    LOSSES: ClassVar[tuple[str, ...]] = ()
    """Which of `LOSSES` of this module its parameters' ``losses`` tell; each is a column of the
    history."""

    density: Positive = Field(description="initial density [mass/volume]")
    viscosity: ArtificialViscosity | None = Field(
        default=None, description="artificial viscosity; null: none"
    )

    @property
    def states(self) -> tuple[State, ...]:
        """What particles of this very entry remember: `STATE`, or less."""
        return self.STATE

    @property
    def initial_pressure(self) -> float:
        """Pressure of a particle at the start, unless a file of particles gives its stress."""
        return 0.0

    def out_of_range(self, J: float, state: tuple[float, ...]) -> tuple[str, str]:
        """Say of a particle whose ``margin`` is used up what is wrong, and what to try.

        Parameters
        ----------
        J : float
            Its current over its initial volume.
        state : tuple of float
            What it remembers.
        """
        return "is out of the range of its material", "smaller steps (time.step), slower loading"

    def exact_path(self, path: str, value: Any, rate: float) -> dict[str, Any] | None:
        """Return what is known exactly along a path of ``pgimp element``.

        Parameters
        ----------
        path : str
            Its name.
        value : (n,) ndarray
            Its value, from 0 on and monotonic.
        rate : float
            Of the value, 1/time.

        Returns
        -------
        dict of str to (n,) ndarray, or None
            Columns of ``pgimp element`` by name; None where nothing is known.
        """
        return None


def lame(young: float, poisson: float) -> tuple[float, float]:
    """Lame's constants lambda and mu, in the unit of `young`."""
    mu = young / (2.0 * (1.0 + poisson))
    return 2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu


def states_of(parameters: type) -> tuple[State, ...]:
    """State variables of the materials whose parameters are of a type, see `with_states`."""
    return getattr(parameters, "STATE", ())


#: What the type of a material's parameters has from its entry, besides the state variables.
_SWITCHES = ("VOLUME_ONLY", "TAKES_VISCOUS_PRESSURE")


def with_states(entry: Material, parameters: Any) -> Any:
    """Parameters of an entry, whose type says from now on what its particles remember.

    Raises
    ------
    ValueError
        If entries with other state variables have parameters of the same type.
    """
    kind = type(parameters)
    if entry.states != states_of(kind) and "STATE" in vars(kind):
        raise ValueError(f"{kind.__qualname__} belongs to a material with other state variables")
    if entry.states:
        kind.STATE = entry.states
    for name in _SWITCHES:
        if getattr(entry, name):
            setattr(kind, name, True)
    return parameters


def state_width(parameters: type, dimensions: int) -> int:
    """Numbers that particles of a material remember, all its state variables together."""
    return sum(each.width(dimensions) for each in states_of(parameters))


#: Quantities that a material need not have, and what they are without: the diffusivity of
#: momentum, length^2/time, that limits the step; how far the material is from the end of its range,
#: at which the run stops; the energies that it does not give back, see `LOSSES`.
OPTIONAL: dict[str, Any] = {"diffusivity": 0.0, "margin": 1.0, "losses": (0.0, 0.0, 0.0)}

#: Arguments of "stress" besides the material, the viscous pressure and the state.
_WITHOUT_Q = 5


def has(parameters: type, quantity: str) -> bool:
    """Whether materials whose parameters are of a type have one of the `OPTIONAL` quantities."""
    return isinstance(getattr_static(parameters, quantity, None), staticmethod)


def volume_only(parameters: type) -> bool:
    """Whether of such materials' deformation only the volume is followed."""
    return getattr(parameters, "VOLUME_ONLY", False)


def takes_viscous_pressure(parameters: type) -> bool:
    """Whether such materials are heated by the artificial viscosity."""
    return getattr(parameters, "TAKES_VISCOUS_PRESSURE", False)


@cache
def _compiled(parameters: type, quantity: str):
    options = {**INLINE_OPTIONS, "_nrt": is_outside(parameters)}  # a user's may make arrays
    return numba.njit(**options)(getattr(parameters, quantity))


def evaluate(quantity, materials, k, args, state):
    """Value of "stress", "energy", "speed", .. of material number `k` of the scene's tuple.

    Materials of one type are indexed; different types become a chain of branches; one material
    alone costs neither. Of the quantities in `OPTIONAL` a material need not have any.

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
        pressure may come last; it is left out for materials that do not take it, and is 0 for those
        that do where it does not.
    state : tuple of float
        As many as the widest material of the scene remembers, () where none does.

    Returns
    -------
    float or tuple
        Of "stress" the components, followed by the state after the step; of "losses" one number
        for each of `LOSSES`, zeros where the material has no such function.
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
        if k == 0:  # one model may give a number where another gives a vector
            return vectors(_ask(name, materials[0], args, state))
        return vectors(evaluate(name, materials[1:], k - 1, args, state))

    return branch_of_vectors if has_vectors(args) else branch


def _ask(quantity, material, args, state):
    """Value of a quantity of one material, see `evaluate`; a material sees its own state alone."""


@overload(_ask, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _ask_material(quantity, material, args, state):
    if not isinstance(quantity, types.Literal):
        return None
    name, kind = quantity.literal_value, material.instance_class
    if name in OPTIONAL and not has(kind, name):
        value = OPTIONAL[name]
        return lambda quantity, material, args, state: value
    function = _compiled(kind, name)
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
    if name != "stress":
        return lambda quantity, material, args, state: function(material, *args, state[:own])

    def stress(quantity, material, args, state):
        sigma, now = function(material, *args, state[:own])
        return (*sigma, *now, *state[own:])

    return stress


def _takes_vectors(material: Any, quantity: str, args: Any, state: Any) -> bool:
    """Whether a material's function compiles for vectors: one that branches does not."""
    kind = material.instance_class
    if quantity in OPTIONAL and not has(kind, quantity):
        return True
    own = state_width(kind, isqrt(len(args[0])))
    seen = (types.UniTuple(state[0], own),) if own else ()
    if quantity == "stress":
        q = (args[_WITHOUT_Q] if len(args) > _WITHOUT_Q else types.float64,)
        args = (*args[:_WITHOUT_Q], *(q if takes_viscous_pressure(kind) else ()))
    try:
        _compiled(kind, quantity).compile((material, *args, *seen))
    except errors.NumbaError:
        return False
    return True


def evaluate_four(quantity, materials, numbers, args, state, like):
    """As `evaluate`, of four particles.

    `args` and `state` are vectors or tuples of them; so is the result, which is of the kind of
    `like`. `numbers` are the particles' materials, a tuple of four. A function that cannot take
    vectors, because it branches, is called for one particle after the other. Parameters that vary
    in space are vectors as well, see `pgimp.kernels.own`.
    """


@overload(evaluate_four, jit_options=INLINE_OPTIONS, prefer_literal=True, strict=False)
def _evaluate_four(quantity, materials, numbers, args, state, like):
    if not isinstance(quantity, types.Literal):
        return None
    name = quantity.literal_value
    if not all(_takes_vectors(material, name, args, state) for material in materials):

        def one_by_one(quantity, materials, numbers, args, state, like):
            values = like
            for j in range(4):
                one = evaluate(name, materials, numbers[j], of_lane(args, j), of_lane(state, j))
                values = with_lanes(values, j, one)
            return values

        def one_by_one_of_own(quantity, materials, numbers, args, state, like):
            values = like
            for j in range(4):
                own, given = of_lane(materials, j), of_lane(args, j)
                values = with_lanes(
                    values, j, evaluate(name, own, numbers[j], given, of_lane(state, j))
                )
            return values

        return one_by_one_of_own if has_vectors(materials) else one_by_one
    if len(materials) == 1:
        return lambda quantity, materials, numbers, args, state, like: vectors(
            evaluate(name, materials, 0, args, state)
        )

    def by_material(quantity, materials, numbers, args, state, like):
        kinds = pack(float(numbers[0]), float(numbers[1]), float(numbers[2]), float(numbers[3]))
        values = like
        done = 0
        for j in range(4):
            if done >> j & 1 == 0:
                mask = kinds == numbers[j]
                found = vectors(evaluate(name, materials, numbers[j], args, state))
                values = where_all(mask, found, values)
                done |= bits(mask)
        return values

    return by_material
