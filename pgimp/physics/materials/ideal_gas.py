"""Ideal gas: p = (g - 1) rho e, with the internal energy e as a state.

In a step the gas gains the work of the mean pressure and of the artificial viscosity q,

    rho0 (e' - e) = -((p + p')/2 + q) (J' - J),

which with p' = (g - 1) rho0 e'/J' is linear in e'. Shocks heat the gas by q only: without
artificial viscosity their dissipation stays as noise in the velocities.
"""

from math import sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from pgimp.jit.algebra import determinant, isotropic, one_plus, symmetric
from pgimp.physics.materials.base import Material, State
from pgimp.physics.materials.exact.flow import isotropic_columns, volumes
from pgimp.schema.base import Number, Positive


class IdealGasParameters(NamedTuple):
    """Ratio of specific heats, initial energy per mass, initial density."""

    gamma: float
    energy_at_start: float
    density: float

    @staticmethod
    def stress(material, F, J, sigma, L, dt, q, state):
        """Pressure, and the internal energy after the step."""
        before = J / determinant(one_plus(dt, L))
        grown = (J - before) / material.density
        stiff = material.gamma - 1.0
        p = stiff * material.density / before * state[0]
        e = (state[0] - (0.5 * p + q) * grown) / (1.0 + 0.5 * stiff * (J - before) / J)
        p = stiff * material.density / J * e
        return isotropic(0.0, symmetric(L), -p), (e,)

    @staticmethod
    def energy(material, F, J, sigma, state):
        """Internal energy per initial volume."""
        return material.density * state[0]

    @staticmethod
    def speed(material, F, J, state):
        """Speed of sound: c^2 = g p/rho."""
        return sqrt(material.gamma * (material.gamma - 1.0) * max(state[0], 0.0))

    @staticmethod
    def margin(material, F, J, sigma, state):
        """Remaining internal energy."""
        return state[0]


class IdealGas(Material):
    """Ideal gas."""

    VOLUME_ONLY = True
    TAKES_VISCOUS_PRESSURE = True
    STATE: ClassVar[tuple[State, ...]] = (
        State(
            "internal-energy",
            "energy/mass",
            "internal energy e",
            initial="energy_at_start",
            least=0.0,
        ),
    )

    model: Literal["ideal-gas"] = Field(description="name of the model")
    gamma: Number = Field(
        gt=1.0, le=10.0, description="ratio of specific heats g, 1.4 for air, 5/3 for helium [1]"
    )
    energy: Positive = Field(
        description="internal energy at the start, e = p/((g - 1) density) [energy/mass]"
    )

    @property
    def initial_pressure(self) -> float:
        """See `Material.initial_pressure`."""
        return (self.gamma - 1.0) * self.density * self.energy

    def out_of_range(self, J: float, state: tuple[float, ...]) -> tuple[str, str]:
        """See `Material.out_of_range`."""
        return (
            f"has used up its internal energy ({state[0]:.3g}) at {J:.3g} times its volume",
            "artificial viscosity (viscosity: {linear: 0.5, quadratic: 1.5}), smaller steps "
            "(time.step), slower walls: a gas that is left behind by more than 2 c/(gamma - 1) is "
            "a vacuum",
        )

    def exact_path(
        self, path: str, value: np.ndarray, rate: float, confine: float
    ) -> dict[str, np.ndarray] | None:
        """See `Material.exact_path`."""
        start = self.initial_pressure
        J = volumes(path, value, (start / confine) ** (1.0 / self.gamma))
        if J is None:
            return None
        columns = isotropic_columns(start * J**-self.gamma)
        if confine != start:  # Confinement gives an energy off the isentrope.
            return columns
        return columns | {"internal-energy": self.energy * J ** (1.0 - self.gamma)}

    def parameters(self) -> IdealGasParameters:
        """Parameters of the kernels."""
        return IdealGasParameters(self.gamma, self.energy, self.density)
