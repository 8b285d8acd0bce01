"""Sums behind the columns of history.csv: over particles, work, reactions, in layer order."""

from __future__ import annotations

from copy import copy, deepcopy
from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.gauges import flux_gauges
from pgimp.kernels.data.ledger import (
    BOOKED,
    DAMPED,
    IMPULSE,
    PLACES,
    RIGID_IMPULSE,
    RIGID_MOMENT,
    TOOLED,
    VOLUMES,
    WALL_BOOKED,
    Ledger,
)
from pgimp.kernels.sums.errors import ERRORS, layer_errors
from pgimp.kernels.sums.sums import KINETIC, MASS, STRAIN, SUMS
from pgimp.physics.materials.base import LOSSES
from pgimp.solver.contact.penetration import QUARTER, particles_inside
from pgimp.solver.history.body_sums import own_sums, reduced
from pgimp.solver.history.columns import line_of
from pgimp.solver.history.gauge_means import Means
from pgimp.solver.history.gauges import measure
from pgimp.solver.history.tearing import TearingWatch
from pgimp.solver.history.totals import Totals
from pgimp.solver.lagrangian.pieces import by_layers
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import START, Step

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

#: Part of the volume of flowing bodies without room on the grid that is worth a warning.
LOST = 0.02


def _impulses(own: Ledger) -> np.ndarray:
    """Impulses by plane: of faces, constraints, tractions, contact and rigid bodies, and moments.

    Where contact acts, and what crossed the surfaces of flux gauges, too: see `Totals.force`.
    """
    return np.concatenate(
        [
            own.impulse,
            own.constraint_impulse,
            own.traction_impulse,
            own.contact[:, :, IMPULSE : IMPULSE + 3],
            own.contact_moments,
            own.crossed,
            own.rigid_bodies[:, :, RIGID_IMPULSE : RIGID_IMPULSE + 3],
            own.rigid_bodies[:, :, RIGID_MOMENT : RIGID_MOMENT + 3],
        ],
        axis=1,
    )


def _fluxes(scene: Scene, force: np.ndarray) -> dict[str, np.ndarray]:
    """Mass and momentum that left per time since the last line, by gauge; see `Totals.force`."""
    names = list(flux_gauges(scene.case.gauges))
    end = len(force) - 2 * len(scene.interaction.rigid_bodies)
    rows = force[end - 2 * len(names) : end].reshape(len(names), 6)
    if scene.case.axisymmetric:  # what points along the radius vanishes all round
        rows = rows * [1.0, 1.0, 1.0, 0.0, 1.0, 1.0]
    return {name: row[[0, 3, 4, 5]] for name, row in zip(names, rows, strict=True)}


def column_names(scene: Scene) -> list[str]:
    """Names of the columns of history.csv, found without particles.

    Parameters
    ----------
    scene : Scene
        The scene of the run.
    """
    faces = len(scene.domain.faces)
    pairs = scene.interaction.pairs
    contact = np.zeros((len(pairs.kind) if pairs else 0, BOOKED))
    rigid_bodies = np.zeros((len(scene.interaction.rigid_bodies), TOOLED))
    moved = np.zeros((len(scene.case.constraints), 3))
    loads = scene.interaction.loads
    held = len(loads.booked_constraints) + len(loads.booked_tractions)
    crossed = 2 * len(flux_gauges(scene.case.gauges))
    touching = (1 + scene.settings.by_vertex * PLACES) * len(contact)
    force = np.zeros((faces + held + touching + crossed + 2 * len(rigid_bodies), 3))
    none = np.zeros(scene.materials.sums)
    bodies = np.zeros((len(scene.body_names), scene.materials.sums))
    errors, losses = np.zeros(ERRORS), np.zeros(len(LOSSES))
    totals = Totals(
        scene, START, bodies, none, none, none, none, none, 0.0, 0.0, losses, 0.0, 0.0, force,
        np.zeros(faces), np.zeros((faces, WALL_BOOKED)), contact, rigid_bodies,
        np.zeros(len(rigid_bodies), np.int64), np.zeros((len(bodies), VOLUMES)), np.zeros(DAMPED),
        {}, moved, errors, errors, {}, {},
    )  # fmt: skip
    return list(line_of(totals))


class Diagnostics:
    """Sums of one simulation; references to earlier lines are kept on rank 0."""

    def __init__(self) -> None:
        #: Greatest part of the mass beyond a face in any line, its time and face; on rank 0.
        self.most_outside = (0.0, 0.0, "")
        self.first_energy: float | None = None
        #: Warnings not shown yet, on rank 0; whether the warnings of rigid bodies and of volumes
        #: were made.
        self.said: list[str] = []
        self.warned = False
        self.lost: set[str] = set()
        self.tearing = TearingWatch()
        #: Time (with `settling_time`), impulses and forces of the last line.
        self.last: tuple[float, np.ndarray, np.ndarray] | None = None
        #: Likewise of the last reading by a function of a program, on every rank.
        self.read: tuple[float, np.ndarray, np.ndarray] | None = None
        #: Time that the steps of stages that settle have taken, on every rank.
        self.settling_time = 0.0
        #: Sums of earlier stages, see `Totals`; of use on rank 0.
        self.removed: np.ndarray | None = None
        self.added: np.ndarray | None = None
        self.changed = 0.0
        self.initial_losses = np.zeros(len(LOSSES))
        #: Means of the gauges, on rank 0.
        self.means = Means()

    def removed_so_far(self, scene: Scene) -> np.ndarray:
        """Sums of the bodies that stages have removed."""
        return np.zeros(scene.materials.sums) if self.removed is None else self.removed

    def added_so_far(self, scene: Scene) -> np.ndarray:
        """Sums of the bodies that have come in stages."""
        return np.zeros(scene.materials.sums) if self.added is None else self.added

    def line(self, rank: RankState, done: Step) -> dict[str, float] | None:
        """One line of the history on rank 0, None elsewhere; collective.

        The reaction of a face, or of a constraint, is its mean force on the material since the last
        line: its impulse over the time. The dissipated energy closes the balance. It is the initial
        energy plus external work plus additions between stages, less kinetic and strain energy,
        also of removed particles.
        """
        torn = self.tearing.look(rank, done) + rank.contact.overrun(rank, done)
        line = self._line(rank, done, bool(rank.scene.case.gauges))
        self.said += torn if line is not None else []
        return line

    def reading(self, rank: RankState, done: Step, gauges: bool) -> dict[str, float] | None:
        """As `line`, for a function of a program: lines stay as they are without it; collective.

        Mean forces are over the time since the last reading; `read` on rank 0 is then this one.
        Without `gauges` their columns are nan.
        """
        own = copy(self)
        own.means, own.said, own.lost = deepcopy(self.means), [], set(self.lost)
        none = np.zeros((self.rows(rank), 3))
        own.last = self.read or (0.0, none, none)
        line = own._line(rank, done, gauges and bool(rank.scene.case.gauges))
        self.read = own.last
        return line

    @staticmethod
    def rows(rank: RankState) -> int:
        """Number of mean forces and moments in a line, see `Totals.force`."""
        return _impulses(rank.booked()).shape[1]

    def _line(self, rank: RankState, done: Step, gauged: bool) -> dict[str, float] | None:
        scene = rank.scene
        sums, masses, unit = own_sums(rank, scene, rank.population.ordered)
        own = rank.booked()
        impulse = _impulses(own)
        errors = self._own_errors(rank, done.end)
        gauges = measure(rank, done.end) if gauged else {}
        inside = particles_inside(rank, rank.population.order, done.end, QUARTER)
        booked = (
            impulse, own.outside_mass, own.contact, own.rigid_bodies, own.wall_energy, own.filled,
            own.damping,
        )  # fmt: skip
        parts = rank.comm.gather((sums, own.work, booked, errors, own.escaped, masses, inside))
        if parts is None or gauges is None:
            return None
        bodies, every = reduced([part[0] for part in parts], [part[5] for part in parts], unit)
        work = float(np.concatenate([part[1] for part in parts]).sum())
        impulse, outside_mass, contact, rigid_bodies, walls, filled, damping = (
            np.add.reduce(np.concatenate([part[2][i] for part in parts]), axis=0) for i in range(7)
        )
        inside = np.sum([part[6] for part in parts], axis=0)
        self._tell_inside(scene, done.end, inside)
        self._tell_volumes(scene, done.end, filled)
        total = np.add.reduce(bodies, axis=0)
        total[MASS] = every
        if self.first_energy is None:
            self.first_energy = float(total[KINETIC] + total[STRAIN])
            if not done.end:
                self.initial_losses[: len(total) - SUMS] = total[SUMS:]
        escaped, added, most = np.zeros(scene.materials.sums), np.zeros(ERRORS), np.zeros(ERRORS)
        if scene.settings.escapes:
            escaped = np.add.reduce(np.concatenate([part[4] for part in parts]), axis=(0, 1))
        inflow = rank.inflow.sums if rank.inflow else np.zeros(scene.materials.sums)
        if scene.settings.exact:
            added = np.add.reduce(np.concatenate([part[3][0] for part in parts]), axis=0)
            most = np.concatenate([part[3][1] for part in parts]).max(axis=0)
        for face, mass in zip(scene.domain.faces, outside_mass, strict=True):
            if total[MASS]:
                share = (float(mass / total[MASS]), done.end, face.name)
                self.most_outside = max(self.most_outside, share)
        counted = self.last is not None and done.end > 0.0
        force = self._forces(done.end + self.settling_time, impulse)
        if counted:
            gauges |= _fluxes(scene, force)
        means = self.means.add(scene, done.end, gauges) if gauged else {}
        moved = rank.grips.moved if rank.grips else np.zeros((len(scene.case.constraints), 3))
        return line_of(
            Totals(
                scene, done, bodies, total, escaped, self.removed_so_far(scene),
                self.added_so_far(scene), inflow, self.changed,
                self.settling_time, self.initial_losses, self.first_energy, work,
                force, outside_mass, walls, contact, rigid_bodies, inside,
                filled, damping, rank.free.now if rank.free else {}, moved, added, most,
                gauges, means,
            )
        )  # fmt: skip

    def note_forces(self, rank: RankState, done: Step) -> None:
        """Take mean forces from here on, as if there were a line; collective."""
        parts = rank.comm.gather(_impulses(rank.booked()))
        if parts is not None:
            impulse = np.add.reduce(np.concatenate(parts), axis=0)
            self._forces(done.end + self.settling_time, impulse)

    def _tell_inside(self, scene: Scene, time: float, inside: np.ndarray) -> None:
        """Warn, once, of particles inside rigid bodies."""
        if self.warned or not inside.any():
            return
        self.warned = True
        each = [
            f"{n} in '{name}'"
            for name, n in zip(scene.interaction.rigid_bodies.names, inside, strict=True)
            if n
        ]
        self.said.append(
            f"particles are deeper in rigid bodies than a quarter of a cell: {', '.join(each)} "
            f"at time {time:.6g}; what is there takes no part in contact as it should. The columns "
            "rigid.NAME.penetrating-particles of history.csv go on counting"
        )

    def _tell_volumes(self, scene: Scene, time: float, filled: np.ndarray) -> None:
        """Warn, once of each, of bodies that flow and have lost volume."""
        for name, (carried, room) in zip(scene.body_names, filled, strict=False):
            if name not in self.lost and room < (1.0 - LOST) * carried:
                self.lost.add(name)
                self.said.append(
                    f"body '{name}', which flows, fills {1.0 - room / carried:.1%} less of the "
                    f"grid than its volume at time {time:.6g}: its particles crowd. In a splash "
                    f"that passes; where it lasts, '{name}' lies too low. The column volume.{name} "
                    "of history.csv goes on counting"
                )

    @staticmethod
    def _own_errors(rank: RankState, time: float) -> tuple[np.ndarray, ...]:
        """Sums and maxima of the errors by layer, of this rank's particles; () without any."""
        scene = rank.scene
        if not scene.settings.exact:
            return ()
        sums, most = np.zeros((2, rank.slab.layers, ERRORS))
        what = scene.settings.exact, time, scene.settings.follows, scene.setting
        by_layers(
            rank, rank.population.ordered,
            lambda particles, order: layer_errors(*what, particles, order, sums, most),
        )  # fmt: skip
        return sums, most

    def _forces(self, time: float, impulse: np.ndarray) -> np.ndarray:
        """Mean forces and moments since the last line, (rows, 3), see `Totals.force`."""
        if self.last is None:
            force = np.zeros_like(impulse)
        elif time > self.last[0]:
            force = (impulse - self.last[1]) / (time - self.last[0])
        else:
            return self.last[2]
        self.last = (time, impulse, force)
        return force
