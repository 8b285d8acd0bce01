"""Materials of a scene: parameters, state variables, reported losses, and masses."""

from math import inf, pi, prod

import numpy as np

from pgimp.case.locations import located
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.kernels.sums.sums import SUMS
from pgimp.physics.materials.base import LOSSES
from pgimp.physics.materials.parameters.outside import parameters_of
from pgimp.physics.materials.parameters.states import States
from pgimp.physics.source import Fills
from pgimp.scene.variations import Variations

#: Masses outside of this would leave the range of float64 in sums and products.
SMALLEST, LARGEST = 1e-200, 1e200


class MaterialTable:
    """Materials in use.

    Attributes
    ----------
    names : list of str
        Their names; `entries` is their entries in the case.
    parameters : tuple of NamedTuple
        Their parameters; where they vary in space (see `variations`), typical values.
    body_material : tuple of int
        Number of each body's material.
    losses : tuple of str
        Entries of `LOSSES` that a material in use reports; `sums` is the columns of `layer_sums`.
    states : States
        Their state variables.
    most_mass : float
        Greatest mass that the domain can hold.
    fills : Fills or None
        Voids of the bodies that flow; None if none does.
    densest : float or None
        Greatest initial density of a particle, set where materials vary once computed.
    """

    def __init__(self, case: Case) -> None:
        bodies = case.bodies.values()
        in_use = {body.material for body in bodies}
        self.names = [name for name in case.materials if name in in_use]
        self.entries = [case.materials[name] for name in self.names]
        self.body_material = tuple(self.names.index(body.material) for body in bodies)
        self.parameters = tuple(parameters_of(entry, case.dimensions) for entry in self.entries)
        self.initial_pressures = [entry.initial_pressure for entry in self.entries]
        losses = {loss for entry in self.entries for loss in entry.LOSSES}
        self.losses = tuple(loss for loss in LOSSES if loss in losses)
        self.sums = SUMS + (len(LOSSES) if losses else 0)
        self._volume = prod(case.grid.size)
        if case.axisymmetric:
            self._volume *= pi * (case.grid.origin[0] + case.grid.corner[0])
        with located(case):
            self.most_mass = self._weigh(case)
        self.states = States(self.names, self.parameters, case.dimensions)
        self.variations = Variations(case, self.names, self.parameters, self.states.width)
        self.fills = self._fills()
        self.densest: float | None = None

    def _fills(self) -> Fills | None:
        """Voids of the bodies that flow; None if none does."""
        most, gap = np.full(len(self.entries), inf), np.full(len(self.entries), -1)
        for n, entry in enumerate(self.entries):
            if entry.flow_speed > 0.0:
                most[n], gap[n] = entry.most_filled, self.states.first("gap", n)
        of_body = list(self.body_material)
        limited = bool((most < inf).any() or (gap >= 0).any())
        return Fills(most[of_body], gap[of_body]) if limited else None

    def _weigh(self, case: Case) -> float:
        """Mass of a domain full of the densest material; refuse masses that no float64 can sum."""
        least = prod(case.grid.cell) / prod(case.method.particles_per_cell)
        if case.axisymmetric:
            least *= pi * case.grid.cell[0] / case.method.particles_per_cell[0]  # at the axis
        most = 0.0
        for name, entry in zip(self.names, self.entries, strict=True):
            particle, domain = entry.density * least, entry.density * self._volume
            if not (particle > SMALLEST and domain < LARGEST):
                raise CaseError(
                    f"materials.{name}.density: a particle would have the mass {particle:.3g}, a "
                    f"full domain {domain:.3g}; with numbers below {SMALLEST:g} or "
                    f"above {LARGEST:g} nothing can be computed: choose other units"
                )
            most = max(most, domain)
        return most

    def varies(self, body: int) -> bool:
        """Whether the material of a body varies in space."""
        return self.variations.layouts[self.body_material[body]] is not None

    def weigh(self, densest: float) -> None:
        """Set the greatest density of particles whose materials vary."""
        self.densest = densest
        self.most_mass = densest * self._volume
