"""What all materials have in common: the entry of a case, and what its parameters' type says."""

import re
from inspect import getattr_static
from math import inf
from typing import Annotated, Any, ClassVar, NamedTuple

from pydantic import Field

from pgimp.physics.materials.parameters.vary import Varying
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
    least : float
        The least that a file of particles may give, of one number.
    """

    name: str
    unit: str
    meaning: str
    initial: float | str = 0.0
    tensor: bool = False
    least: float = -inf

    def width(self, dimensions: int) -> int:
        """Numbers that it takes."""
        return (3, 4, 6)[dimensions - 1] if self.tensor else 1


class Material(Varying):
    """Base of the entries ``materials.NAME``."""

    CARRIES_STRESS: ClassVar[bool] = False
    """Whether the stress of a step starts from that before, which a file of particles may give:
    from the stress itself, or from states that its parameters' ``initial_state`` finds from it."""

    CARRIES_PRESSURE: ClassVar[bool] = True
    """Whether the mean of a carried stress is carried, too, and does not follow from the volume."""

    BEARS_TENSION: ClassVar[bool] = True
    """Whether a carried stress may have a mean above 0 at the start."""

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

    RESTS: ClassVar[bool] = False
    """Whether it flows, and comes to rest: walls then take the velocity of particles that they
    hold, see `pgimp.kernels.grid.resting`. What springs back keeps it."""

    LIQUID: ClassVar[bool] = False
    """Whether it has no strength: under gravity it sees the dilatation at its place."""

    @property
    def flow_speed(self) -> float:
        """Speed of waves at rest of a liquid, or of loose soil; 0 for all other materials.

        Particles of what flows are kept to the space that they fill. If it remembers a `gap` by
        which it has opened, that closes where space is full; else J loses what exerts no force.
        """
        return 0.0

    @property
    def most_filled(self) -> float:
        """The greatest J without voids of what flows."""
        return inf

    @property
    def initial_pressure(self) -> float:
        """Pressure of a particle at the start, unless a file of particles gives its stress."""
        return 0.0

    @property
    def needs_pressure(self) -> bool:
        """Whether it bears nothing at all without pressure."""
        return False

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

    def exact_path(
        self, path: str, value: Any, rate: float, confine: float
    ) -> dict[str, Any] | None:
        """Return what is known exactly along a path of ``pgimp element``.

        Parameters
        ----------
        path : str
            Its name.
        value : (n,) ndarray
            Its value, from 0 on; it may turn back.
        rate : float
            Of the value, 1/time.
        confine : float
            Pressure from all sides at the start [stress].

        Returns
        -------
        dict of str to (n,) ndarray, or None
            Columns of ``pgimp element`` by name, nan in rows of which nothing is known; None where
            that is all of them.
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
#: at which the run stops; the energies that it does not give back, see `LOSSES`; the state of a
#: particle that begins with a stress, without which it is what it was (None).
OPTIONAL: dict[str, Any] = {
    "diffusivity": 0.0, "margin": 1.0, "losses": (0.0, 0.0, 0.0), "initial_state": None,
}  # fmt: skip


def has(parameters: type, quantity: str) -> bool:
    """Whether materials whose parameters are of a type have one of the `OPTIONAL` quantities."""
    return isinstance(getattr_static(parameters, quantity, None), staticmethod)


def volume_only(parameters: type) -> bool:
    """Whether of such materials' deformation only the volume is followed."""
    return getattr(parameters, "VOLUME_ONLY", False)


def takes_viscous_pressure(parameters: type) -> bool:
    """Whether such materials are heated by the artificial viscosity."""
    return getattr(parameters, "TAKES_VISCOUS_PRESSURE", False)
