"""Settings of a scene: configurations of its bodies, shape of its particles, exact solution."""

from typing import Any

import numpy as np

from pgimp.case.checks.exact_surfaces import exact_surfaces
from pgimp.case.outflow import exits_of
from pgimp.case.schema import Case
from pgimp.physics.shapes.gimp import GimpParameters
from pgimp.physics.shapes.parts import PartParameters

#: Most cells that a particle crosses in a step whose length pgimp chooses.
MOST_CELLS = 0.5


class Settings:
    """What the case says of the method.

    Attributes
    ----------
    lagrangian : (bodies,) bool
        Which bodies are in the initial configuration, where particles keep their layers and
        initial weights. `initial`: all are; `mixed`: some are.
    averaged : (bodies,) bool
        Which bodies have an averaged mass.
    shape : NamedTuple
        Parameters of the shape; its support has `vertices` per direction.
    initial_shape : NamedTuple
        That of bodies in the initial configuration, also beside others: then no wider than cells.
    uncut : NamedTuple
        Parameters of the shape of whole particles. `shape` differs where bodies are exact to their
        surface; in contact, at current positions, their particles are cut boxes as others.
    exact_surfaces : (bodies,) bool
        Which bodies are exact to their surface.
    follows : bool
        Whether supports follow the deformation.
    exact : NamedTuple or ()
        Parameters of the exact solution, if the case names one; `moves` if it gives the velocities.
    escapes : bool
        Whether particles may leave, in this stage or a previous one.
    damps : bool
        Whether there is damping, in this stage or a previous one.
    settles : bool
        Whether the run comes to rest before time 0, or the stage.
    flows : bool
        Whether a body is a liquid, a gas or loose soil, so that it has no stiffness in shear.
    loses : bool
        Whether there may be fewer particles than at the start.
    origins : bool
        Whether particles store their initial position.
    controlled : bool or float
        How steps follow the fastest wave, if at all; see `pgimp.kernels.update.pace`.
    """

    def __init__(self, case: Case) -> None:
        self.lagrangian = np.array(
            [b.formulation == "total-lagrangian" for b in case.bodies.values()], bool
        )
        self.averaged = np.array(
            [(b.mass or case.method.mass) == "averaged" for b in case.bodies.values()], bool
        )
        self.initial = bool(self.lagrangian.all())
        self.mixed = bool(self.lagrangian.any()) and not self.initial
        method = case.method
        self.exact_surfaces = np.array(exact_surfaces(case), bool)
        cell = tuple(case.grid.cell)
        self.initial_shape: Any = method.fixed(cell)
        if self.mixed and not method.in_cell:  # that is the shape of the others
            self.initial_shape = GimpParameters(tuple(0.5 / n for n in method.particles_per_cell))
        self.uncut = self.initial_shape if self.initial else method.parameters(cell)
        if self.exact_surfaces.any():  # whole particles have the same weights
            self.initial_shape = PartParameters(tuple(0.0 for _ in cell))
        self.shape = self.initial_shape if self.initial else self.uncut
        self.vertices: int = self.shape.vertices()
        self.follows = method.follows and not self.initial
        self.exact: Any = case.exact.parameters(case) if case.exact else ()
        self.moves = bool(case.exact) and case.exact.moves
        self.escapes = bool(exits_of(case.outflow)) or case.staged.escapes
        self.loses = self.escapes or bool(case.staged.removed)
        self.damps = case.damping is not None or case.staged.damped or case.rests
        self.settles = case.start.equilibrate is not None
        laws = [case.materials[body.material] for body in case.bodies.values() if body.material]
        self.flows = any(law.LIQUID or law.VOLUME_ONLY for law in laws)
        fields = case.output.fields
        self.origins = self.by_vertex or bool(case.exact) or "displacement" in fields
        self.origins |= bool(case.body_force) and case.body_force.initial
        self.controlled: bool | float = case.courant is not None
        if case.courant is not None and case.watched:
            self.controlled = case.courant / MOST_CELLS

    @property
    def by_vertex(self) -> bool:
        """Whether there are bodies whose vertices keep their motion: in the initial configuration.

        They are in contact at current positions, not on their own grids.
        """
        return self.initial or self.mixed

    @property
    def lagrangian_bodies(self) -> np.ndarray | None:
        """Mask of the bodies whose vertices keep their motion; None without any."""
        return self.lagrangian if self.by_vertex else None
