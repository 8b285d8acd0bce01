"""Base of all materials: the entry of a case, and attributes of its parameters' type."""

import re
from inspect import getattr_static
from math import inf
from typing import Annotated, ClassVar, NamedTuple, TypeVar

import numpy as np
from pydantic import Field

from pgimp.physics.materials.parameters.vary import Varying
from pgimp.schema.base import Model, NonNegative, Number, Positive

Poisson = Annotated[
    Number, Field(gt=-1.0, lt=0.5, description="Poisson's ratio, above -1 and below 0.5 [1]")
]
Young = Annotated[Positive, Field(description="Young's modulus [stress]")]


P = TypeVar("P")


class ArtificialViscosity(Model):
    """Pressure in compression that spreads shocks over some cells (45)."""

    linear: NonNegative = Field(
        description="c1 in q = c1 rho c L |D| + c2 rho (L D)^2, D the rate of volume change where "
        "it is negative, c the wave speed, L the smallest side of a cell [1]"
    )
    quadratic: NonNegative = Field(description="c2 [1]")


#: Irreversible energies that a material may report: columns of the history.
LOSSES = ("plastic-work", "viscous-work", "heat")

#: Allowed names of state variables.
STATE_NAME = re.compile("[a-z][a-z0-9-]*")


class State(NamedTuple):
    """A state variable of a material's particles, besides their stress."""

    name: str  #: As ``output.fields`` and probes name it: small letters, digits and ``-``.
    unit: str  #: Its unit, ``1`` for none.
    meaning: str  #: Its description, for the reference and for the datasets of frames.
    #: Initial value, or the name of a number among the material's parameters.
    initial: float | str = 0.0
    #: Whether it is a symmetric tensor, with the components of a stress, or one number.
    tensor: bool = False
    least: float = -inf  #: Least value that a file of particles may give, for a scalar.

    def width(self, dimensions: int) -> int:
        """Number of its components."""
        return (3, 4, 6)[dimensions - 1] if self.tensor else 1


class Material(Varying):
    """Base of the entries ``materials.NAME``."""

    CARRIES_STRESS: ClassVar[bool] = False
    """Whether a step starts from the stress before it. A file of particles may then give it:
    directly, or as states that its parameters' ``initial_state`` finds from it."""

    CARRIES_PRESSURE: ClassVar[bool] = True
    """Whether the mean of a carried stress is carried, too, and does not follow from the volume."""

    BEARS_TENSION: ClassVar[bool] = True
    """Whether a carried stress may have a mean above 0 at the start."""

    ELASTIC: ClassVar[bool] = False
    """Whether it springs back whatever it goes through: it never flows, yields or breaks."""

    PLANE_STRESS: ClassVar[bool] = False
    """Whether its stress out of the plane falls steadily as the thickness does, so that plane
    stress can be found."""

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

    INERTIA_ALONE: ClassVar[bool] = False
    """Whether the density is nothing but inertia, so that `time.mass-scaling` may change it: no
    stress, temperature or state depends on it."""

    density: Positive = Field(description="initial density [mass/volume]")
    viscosity: ArtificialViscosity | None = Field(
        default=None, description="artificial viscosity; null: none"
    )

    @property
    def states(self) -> tuple[State, ...]:
        """State variables of this entry's particles: `STATE`, or fewer."""
        return self.STATE

    RESTS: ClassVar[bool] = False
    """Whether it flows, and comes to rest: walls then take the velocity of particles that they
    hold, see `pgimp.kernels.grid.resting`. What springs back keeps it."""

    LIQUID: ClassVar[bool] = False
    """Whether it has no strength: under gravity it sees the dilatation at its place."""

    @property
    def flow_speed(self) -> float:
        """Wave speed at rest of a liquid, or of loose soil; 0 for all other materials.

        Particles of flowing materials are kept to the space that they fill. Where space is full,
        the state variable `gap` closes if there is one; else J loses the part without force.
        """
        return 0.0

    @property
    def most_filled(self) -> float:
        """Greatest J without voids of a flowing material."""
        return inf

    @property
    def initial_pressure(self) -> float:
        """Initial pressure of a particle, unless a file of particles gives its stress."""
        return 0.0

    @property
    def needs_pressure(self) -> bool:
        """Whether it has no strength without pressure."""
        return False

    def out_of_range(self, J: float, state: tuple[float, ...]) -> tuple[str, str]:
        """Describe the failure of a particle whose ``margin`` is used up, and a remedy.

        Parameters
        ----------
        J : float
            Its current over its initial volume.
        state : tuple of float
            Its state variables.
        """
        return "is out of the range of its material", "smaller steps (time.step), slower loading"

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """Return the exact curves along a path of ``pgimp element``.

        Parameters
        ----------
        path : str
            Its name.
        value : (n,) ndarray
            Its value, from 0 on; it may turn back.
        rate : float
            Rate of the value, 1/time.
        confine : float
            Pressure from all sides at the start [stress].

        Returns
        -------
        dict of str to (n,) ndarray, or None
            Columns of ``pgimp element`` by name, nan in rows without an exact value; None if all
            rows are.
        """
        return None


def lame(young: float, poisson: float) -> tuple[float, float]:
    """Lame's constants lambda and mu, in the unit of `young`."""
    mu = young / (2.0 * (1.0 + poisson))
    return 2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu


def states_of(parameters: type) -> tuple[State, ...]:
    """State variables of the materials whose parameters are of a type, see `with_states`."""
    return getattr(parameters, "STATE", ())


#: Attributes that the type of a material's parameters takes from its entry, besides the states.
_SWITCHES = ("VOLUME_ONLY", "TAKES_VISCOUS_PRESSURE")


def with_states(entry: Material, parameters: P) -> P:
    """Attach an entry's state variables and switches to the type of its parameters.

    Raises
    ------
    ValueError
        If entries with different state variables have parameters of the same type.
    """
    kind = type(parameters)
    if entry.states != states_of(kind) and "STATE" in vars(kind):
        raise ValueError(f"{kind.__qualname__} belongs to a material with other state variables")
    if entry.states:
        setattr(kind, "STATE", entry.states)
    for name in _SWITCHES:
        if getattr(entry, name):
            setattr(kind, name, True)
    return parameters


def state_width(parameters: type, dimensions: int) -> int:
    """Total number of components of a material's state variables."""
    return sum(each.width(dimensions) for each in states_of(parameters))


#: Optional quantities of a material, with their defaults. diffusivity: momentum diffusivity,
#: length^2/time, which limits the step. margin: distance from the end of the material's range, at
#: which the run stops. losses: irreversible energies, see `LOSSES`. initial_state: state of a
#: particle that begins with a stress; by default it stays unchanged (None).
OPTIONAL: dict[str, object] = {
    "diffusivity": 0.0,
    "margin": 1.0,
    "losses": (0.0, 0.0, 0.0),
    "initial_state": None,
}


def has(parameters: type, quantity: str) -> bool:
    """Whether materials with this type of parameters have one of the `OPTIONAL` quantities."""
    return isinstance(getattr_static(parameters, quantity, None), staticmethod)


def volume_only(parameters: type) -> bool:
    """Whether only the volume of the deformation is tracked for materials of this type."""
    return getattr(parameters, "VOLUME_ONLY", False)


def takes_viscous_pressure(parameters: type) -> bool:
    """Whether the artificial viscosity heats materials of this type."""
    return getattr(parameters, "TAKES_VISCOUS_PRESSURE", False)
