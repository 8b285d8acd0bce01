"""What a line of the history is computed from, sums over all ranks, and what a column is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pgimp.kernels.errors import VOLUME
from pgimp.kernels.sums import ANGULAR
from pgimp.solver.clock import Step


class Totals(NamedTuple):
    """What a line of the history is computed from, of all ranks.

    Attributes
    ----------
    scene : Scene
        The scene of the run.
    done : Step
        The last step.
    bodies : (bodies, SUMS) float64
        Sums over the particles of each body, as `layer_sums` has them.
    total : (SUMS,) float64
        Those over all particles.
    escaped : (SUMS,) float64
        Those of the particles that were removed since the start, when they were.
    first_energy : float
        Kinetic and strain energy at the start.
    work : float
        External work since the start.
    force : (faces + constraints + entries of contact + 2 rigid bodies, 3) float64
        Mean force of each on the material since the last line; of rigid bodies the mean forces on
        them, then the mean moments.
    beyond : (faces,) float64
        Mass beyond each face in the last step.
    contact : (entries, BOOKED) float64
        What is booked of contact.
    tools : (rigid bodies, TOOLED) float64
        What is booked of rigid bodies.
    errors, greatest : (ERRORS,) float64
        Sums and maxima of the errors, as `layer_errors` has them; zeros without exact solution.
    """

    scene: Any
    done: Step
    bodies: np.ndarray
    total: np.ndarray
    escaped: np.ndarray
    first_energy: float
    work: float
    force: np.ndarray
    beyond: np.ndarray
    contact: np.ndarray
    tools: np.ndarray
    errors: np.ndarray
    greatest: np.ndarray

    def along(self, sums: np.ndarray, first: int) -> np.ndarray:
        """Return a vector among sums, in the directions that the scene has."""
        return sums[first : first + self.scene.dimension]

    def moment(self, sums: np.ndarray) -> tuple[float | None, ...]:
        """Return the angular momentum among sums, None about axes where it is always zero."""
        return self._about_axes(sums[ANGULAR : ANGULAR + 3])

    def _about_axes(self, moment: np.ndarray) -> tuple[float | None, ...]:
        # A motion along x alone has no moment about the origin, one in the plane only that about z.
        axes = ((), (2,), (0, 1, 2))[self.scene.dimension - 1]
        return tuple(moment[i] if i in axes else None for i in range(3))

    def contact_force(self, k: int) -> np.ndarray | tuple[()]:
        """Return the force of an entry of contact, nothing where it is for more than two bodies."""
        if len(self.scene.case.contact[k].bodies) != 2:
            return ()
        others = len(self.scene.faces) + len(self.scene.case.constraints)
        return self.along(self.force[others + k], 0)

    def on_tool(self, k: int) -> np.ndarray:
        """Return the mean force on a rigid body."""
        return self.along(self.force[len(self.force) - 2 * len(self.tools) + k], 0)

    def moment_on_tool(self, k: int) -> tuple[float | None, ...]:
        """Return the mean moment on a rigid body, None about axes where it is always zero."""
        return self._about_axes(self.force[len(self.force) - len(self.tools) + k])

    def mean(self, column: int) -> float:
        """Return a mean over the initial volume; nan when all particles were removed."""
        volume = self.errors[VOLUME]
        return self.errors[column] / volume if volume else np.nan

    def reference_stress(self) -> float:
        """Return the stress that (47) refers to; 1 before the load sets in: there is no error."""
        return self.scene.exact.scale(self.done.end) or 1.0


class Column(NamedTuple):
    """A column of history.csv, or one for each axis.

    Attributes
    ----------
    name : str
        NAME or FACE stands for the group's names, AXIS for x, y, z.
    unit, meaning : str
        For the reference.
    value : callable
        Takes `Totals` and the number of the name in the group; returns a number, or with AXIS one
        for each axis, None for those that have no column.
    """

    name: str
    unit: str
    meaning: str
    value: Callable[[Totals, int], Any]


class Group(NamedTuple):
    """Columns that follow each other for each name.

    Attributes
    ----------
    names : callable
        Takes the scene; returns what NAME or FACE stands for. Columns without them are written
        once if there is any, whatever it is.
    columns : tuple of Column
        In their order.
    """

    names: Callable[[Any], Sequence[str]]
    columns: tuple[Column, ...]
