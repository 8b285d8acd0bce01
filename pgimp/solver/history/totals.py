"""Sums over all ranks for a line of the history, and the types of its columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from pgimp.kernels.data.ledger import MOMENT, PLACED, PLACES, PRESSED
from pgimp.kernels.sums.errors import VOLUME
from pgimp.kernels.sums.sums import ANGULAR, SUMS
from pgimp.physics.materials.base import LOSSES
from pgimp.physics.rigid import Free
from pgimp.scene.rigid.free_body import FreeBody, State
from pgimp.solver.time.clock import Step

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

T = TypeVar("T")


def entries_of_two(scene: Scene) -> list[int]:
    """Numbers of the entries of contact that name two bodies."""
    return [k for k, entry in enumerate(scene.case.contact) if len(entry.bodies) == 2]


class Totals(NamedTuple):
    """Data of all ranks for a line of the history."""

    scene: Scene  #: The scene of the run.
    done: Step  #: The last step.
    #: (bodies, columns) float64: Sums over the particles of each body, see `layer_sums`.
    bodies: np.ndarray
    total: np.ndarray  #: (columns,) float64: Sums over all particles.
    #: (columns,) float64: Sums of the particles removed since the start, at their removal.
    escaped: np.ndarray
    #: removed, added: (columns,) float64: Sums of bodies removed by stages, at their removal, and
    #: of bodies that came in stages.
    removed: np.ndarray
    added: np.ndarray
    #: (columns,) float64: Sums of the particles that have entered by inflow, as they did.
    inflow: np.ndarray
    changed: float  #: Strain energy added by new parameters of materials as stages began.
    settling_time: float  #: Time that the steps of stages that settle have taken.
    #: (LOSSES,) float64: Losses in the particles' state that do not belong to this run: initial
    #: losses, and changes by new parameters.
    initial_losses: np.ndarray
    first_energy: float  #: Kinetic and strain energy at the start.
    work: float  #: External work since the start.
    #: (faces + constraints + turning + tractions + entries of contact + rows below, 3) float64:
    #: Mean force of each on the material since the last line, mean moment of each constraint that
    #: turns. After contact the rows of `Ledger.contact_moments`, per time. At the end two rows for
    #: each flux gauge: (mass, 0, 0) and momentum that left per time. For rigid bodies mean forces
    #: on them, then mean moments.
    force: np.ndarray
    outside_mass: np.ndarray  #: (faces,) float64: Mass beyond each face in the last step.
    walls: np.ndarray  #: (faces, WALL_BOOKED) float64: Energy taken by each face.
    contact: np.ndarray  #: (entries, BOOKED) float64: The ledger of contact.
    rigid_bodies: np.ndarray  #: (rigid bodies, TOOLED) float64: The ledger of rigid bodies.
    inside: np.ndarray  #: (rigid bodies,) int64: Particles deeper in each than a quarter of a cell.
    filled: np.ndarray  #: (bodies, VOLUMES) float64: The ledger of volumes of flowing bodies.
    damping: np.ndarray  #: (DAMPED,) float64: The ledger of damping; (0,) without it.
    #: dict of int to (FreeBody, State): The free rigid bodies, by number, and their states.
    free: dict[int, tuple[FreeBody, State]]
    #: (constraints, 3) float64: Displacements of constraints under given forces, zeros without any.
    moved: np.ndarray
    #: errors, greatest: (ERRORS,) float64: Sums and maxima of the errors, see `layer_errors`; zeros
    #: without exact solution.
    errors: np.ndarray
    greatest: np.ndarray
    #: gauges, means: What the gauges measure, see `pgimp.solver.history.gauges`, and means over
    #: time.
    gauges: dict[str, np.ndarray]
    means: dict[str, np.ndarray]

    def along(self, sums: Any, first: int) -> Any:
        """Return a vector among sums, in the directions of the scene."""
        return sums[first : first + self.scene.dimension]

    def moment(self, sums: np.ndarray) -> tuple[float | None, ...]:
        """Return the angular momentum among sums, None about axes where it is always zero."""
        return self.about_axes(sums[ANGULAR : ANGULAR + 3])

    def about_axes(self, moment: Sequence[float] | np.ndarray) -> tuple[float | None, ...]:
        """Return the components of a moment, None about axes where it is always zero."""
        # A motion along x alone has no moment about the origin, a motion in the plane only about z.
        axes = ((), (2,), (0, 1, 2))[self.scene.dimension - 1]
        return tuple(moment[i] if i in axes else None for i in range(3))

    def lost(self, name: str) -> float:
        """Return one of `LOSSES` of all particles since the start, including removed ones."""
        number = LOSSES.index(name)
        column = SUMS + number
        there = self.total[column] + self.escaped[column] + self.removed[column]
        return there - self.inflow[column] - self.initial_losses[number]

    def contact_force(self, k: int) -> np.ndarray | tuple[()]:
        """Return the force of an entry of contact, nothing for an entry of more than two bodies."""
        if len(self.scene.case.contact[k].bodies) != 2:
            return ()
        return self.along(self.force[self._first_contact + k], 0)

    @property
    def _first_contact(self) -> int:
        """Row of the force of the first entry of contact."""
        loads = self.scene.interaction.loads
        others = len(self.scene.domain.faces) + len(loads.booked_constraints)
        return others + len(loads.booked_tractions)

    def contact_moment(self, k: int) -> tuple[float | None, ...]:
        """Return the moment of an entry of contact by surfaces that names two bodies."""
        return self.about_axes(self.force[self._placed(k) + MOMENT])

    def centre_of_pressure(self, k: int) -> np.ndarray:
        """Return where the normal forces of such an entry act; nan without any."""
        row = self._placed(k)
        normal = self.force[row + PRESSED, 0]
        return self.along(self.force[row + PLACED], 0) / (normal or np.nan)

    def _placed(self, k: int) -> int:
        """First row of the k-th entry of `Ledger.contact_moments` that names two bodies."""
        number = entries_of_two(self.scene)[k]
        return self._first_contact + len(self.contact) + PLACES * number

    def traction(self, k: int) -> np.ndarray:
        """Return the mean force of the k-th traction of the case."""
        loads = self.scene.interaction.loads
        first = len(self.scene.domain.faces) + len(loads.booked_constraints)
        number = loads.booked_tractions.index([*self.scene.case.tractions][k])
        return self.along(self.force[first + number], 0)

    def torque(self, k: int) -> tuple[float | None, ...]:
        """Return the mean moment of the k-th constraint that turns."""
        first = len(self.scene.domain.faces) + len(self.scene.case.constraints)
        return self.about_axes(self.force[first + k])

    def on_tool(self, k: int) -> np.ndarray:
        """Return the mean force on a rigid body."""
        return self.along(self.force[len(self.force) - 2 * len(self.rigid_bodies) + k], 0)

    def moment_on_tool(self, k: int) -> tuple[float | None, ...]:
        """Return the mean moment on a rigid body, None about axes where it is always zero."""
        return self.about_axes(self.force[len(self.force) - len(self.rigid_bodies) + k])

    def displacement_of_tool(self, k: int) -> tuple[float, ...]:
        """Return the displacement of a rigid body since the start."""
        if k in self.free:
            body, state = self.free[k]
            displacement = tuple(x - y for x, y in zip(state.centre, body.bulk.centre, strict=True))
        else:
            motion = self.scene.interaction.rigid_bodies.entries[k].rigid
            displacement = (
                (0.0,) * 3 if isinstance(motion, Free) else motion.displacement(self.done.end)
            )
        return displacement[: self.scene.dimension]

    def of_free(self, k: int, what: Callable[[FreeBody, State], T], unknown: T) -> T:
        """Return a value of the k-th free rigid body, once it is known."""
        return what(*list(self.free.values())[k]) if self.free else unknown

    def mean(self, column: int) -> float:
        """Return a mean over the initial volume; nan after all particles were removed."""
        volume = self.errors[VOLUME]
        return self.errors[column] / volume if volume else np.nan

    def reference_stress(self) -> float:
        """Reference stress of (47); 1 before loading, when the error is zero."""
        return self.scene.settings.exact.scale(self.done.end) or 1.0


class Column(NamedTuple):
    """A column of history.csv, or one for each axis."""

    name: str  #: NAME or FACE stands for the group's names, AXIS for x, y, z.
    #: unit, meaning: Texts for the reference.
    unit: str
    meaning: str
    #: Takes `Totals` and the number of the name in the group; returns a number. With AXIS it
    #: returns one for each axis, None for axes without a column.
    value: Callable[[Totals, int], Any]


class Group(NamedTuple):
    """Columns that follow each other for each name."""

    #: Takes the scene; returns the names for NAME or FACE. Columns without them are written once if
    #: there is any name.
    names: Callable[[Scene], Sequence[str]]
    columns: tuple[Column, ...]  #: In their order.
