"""The columns of history.csv: sums over the particles, work and reactions, in layer order."""

from math import frexp, ldexp
from typing import Any

import numpy as np

from pgimp.kernels.errors import (
    DISPLACEMENT,
    ERRORS,
    STRESS,
    STRESS_VOLUME,
    VELOCITY,
    VOLUME,
    layer_errors,
)
from pgimp.kernels.ledger import (
    BOOKED,
    CONTACT_AREA,
    HEAT,
    IMPULSE,
    LOSS,
    NORMAL_IMPULSE,
    TANGENTIAL_IMPULSE,
)
from pgimp.kernels.sums import (
    ANGULAR,
    HIGH,
    KINETIC,
    LOW,
    MASS,
    MOMENT,
    MOMENTUM,
    STRAIN,
    SUMS,
    exact_masses,
    layer_sums,
)
from pgimp.solver.clock import START, Step
from pgimp.solver.rank import Rank

AXES = "xyz"

#: Columns of what is booked of contact.
CONTACT = {
    "normal-impulse": NORMAL_IMPULSE,
    "tangential-impulse": TANGENTIAL_IMPULSE,
    "friction-heat": HEAT,
    "impact-loss": LOSS,
    "area": CONTACT_AREA,
}


def _mass(sums: np.ndarray, unit: float) -> float:
    """Mass in rows of `exact_masses`, rounded once."""
    high, low = (sum(map(int, column)) for column in sums.T)
    return ldexp(float((high << LOW) + low), -LOW) / unit


def column_names(scene: Any) -> list[str]:
    """Names of the columns that history.csv will have, found without a particle.

    Parameters
    ----------
    scene : Scene
        The scene of the run.
    """
    names = len(scene.body_names)
    contact = np.zeros((len(scene.pairs.law) if scene.pairs else 0, BOOKED))
    impulse = np.zeros((len(scene.faces) + len(scene.loads.constraints) + len(contact), 3))
    lines = Diagnostics()
    line = lines._columns(
        scene, START, np.zeros((names, SUMS)), 0.0, np.zeros(SUMS), 0.0, impulse,
        np.zeros(len(scene.faces)), contact,
    )  # fmt: skip
    if scene.exact:
        line |= lines._errors(np.zeros(ERRORS), np.zeros(ERRORS), scene.exact.scale(0.0))
    return list(line)


class Diagnostics:
    """Sums of one simulation; what refers to earlier lines is kept on rank 0."""

    def __init__(self) -> None:
        #: Greatest part of the mass beyond a face in any line, when, and which; on rank 0.
        self.beyond = (0.0, 0.0, "")
        self.first_energy: float | None = None
        self.last: tuple[float, np.ndarray, np.ndarray] | None = None

    def line(self, rank: Rank, done: Step) -> dict[str, float] | None:
        """One line of the history on rank 0, None elsewhere; collective.

        The reaction of a face, or of a constraint, is the mean force that it exerted on the
        material since the last line: its impulse over the time. The dissipated energy closes the
        balance: initial energy plus external work less kinetic and strain energy, also that of
        particles that were removed.
        """
        scene, population = rank.scene, rank.population
        sums = np.zeros((rank.slab.layers, len(scene.body_names), SUMS))
        setting = scene.setting.without_shape()
        layer_sums(setting, population.particles, population.ordered, sums)
        masses = np.zeros((len(scene.body_names), 2), np.int64)
        unit = 2.0 ** (HIGH - 2 - frexp(scene.most_mass)[1])  # see `Simulation.settle`
        exact_masses(population.particles, population.order, unit, masses)
        own = rank.booked()
        impulse = np.concatenate(
            [own.impulse, own.constraint_impulse, own.contact[:, :, IMPULSE : IMPULSE + 3]], axis=1
        )
        errors = self._own_errors(rank, done.end)
        parts = rank.comm.gather(
            (sums, own.work, (impulse, own.beyond, own.contact), errors, own.escaped, masses)
        )
        if parts is None:
            return None
        bodies = np.add.reduce(np.concatenate([part[0] for part in parts]), axis=0)
        work = float(np.concatenate([part[1] for part in parts]).sum())
        impulse, beyond, contact = (
            np.add.reduce(np.concatenate([part[2][i] for part in parts]), axis=0) for i in range(3)
        )
        escaped = np.add.reduce(np.concatenate([part[4] for part in parts]), axis=(0, 1))
        masses = np.stack([part[5] for part in parts])  # by rank and body
        bodies[:, MASS] = [_mass(masses[:, body], unit) for body in range(len(bodies))]
        mass = _mass(masses.reshape(-1, 2), unit)
        line = self._columns(scene, done, bodies, mass, escaped, work, impulse, beyond, contact)
        if scene.exact:
            added = np.add.reduce(np.concatenate([part[3][0] for part in parts]), axis=0)
            most = np.concatenate([part[3][1] for part in parts]).max(axis=0)
            line |= self._errors(added, most, scene.exact.scale(done.end))
        return line

    @staticmethod
    def _own_errors(rank: Rank, time: float) -> tuple[np.ndarray, ...]:
        """Sums and maxima of the errors by layer, of this rank's particles; () without any."""
        scene, population = rank.scene, rank.population
        if not scene.exact:
            return ()
        sums, most = np.zeros((2, rank.slab.layers, ERRORS))
        layer_errors(
            scene.exact, time, scene.follows, scene.setting, population.particles,
            population.ordered, sums, most,
        )  # fmt: skip
        return sums, most

    @staticmethod
    def _errors(sums: np.ndarray, most: np.ndarray, scale: float) -> dict[str, float]:
        """Columns of the errors; `scale` is the stress that (47) refers to."""
        if not sums[VOLUME]:  # all particles were removed
            sums = np.full_like(sums, np.nan)
        error = float(sums[STRESS_VOLUME] / sums[VOLUME])
        # Before the load sets in there is nothing to refer to, and no error.
        line = {"error": error / scale if scale else error}
        names = {"displacement": DISPLACEMENT, "velocity": VELOCITY, "stress": STRESS}
        for name, column in names.items():
            line[f"error.{name}-l2"] = float(np.sqrt(sums[column] / sums[VOLUME]))
            line[f"error.{name}-max"] = float(most[column])
        return line

    def _columns(
        self,
        scene: Any,
        done: Step,
        bodies: np.ndarray,
        mass: float,
        escaped: np.ndarray,
        work: float,
        impulse: np.ndarray,
        beyond: np.ndarray,
        contact: np.ndarray,
    ) -> dict[str, float]:
        axes = AXES[: scene.dimension]
        total = np.add.reduce(bodies, axis=0)
        total[MASS] = mass
        kinetic, strain = float(total[KINETIC]), float(total[STRAIN])
        if self.first_energy is None:
            self.first_energy = kinetic + strain
        line = {"time": done.end, "step": done.number, "dt": done.dt}
        line |= self._totals("", total, scene.dimension)
        left = float(escaped[KINETIC] + escaped[STRAIN]) if scene.exits else 0.0
        line["dissipated-energy"] = self.first_energy + work - kinetic - strain - left
        line["external-work"] = work
        if scene.exits:
            line |= self._totals("escaped.", escaped, scene.dimension)
        for name, sums in zip(scene.body_names, bodies, strict=True):
            line[f"body.{name}.mass"] = float(sums[MASS])
            for i, axis in enumerate(axes):
                centre = sums[MOMENT + i] / sums[MASS] if sums[MASS] else np.nan
                line[f"body.{name}.centre-{axis}"] = float(centre)
            for i, axis in enumerate(axes):
                line[f"body.{name}.momentum-{axis}"] = float(sums[MOMENTUM + i])
            line[f"body.{name}.kinetic-energy"] = float(sums[KINETIC])
            line[f"body.{name}.strain-energy"] = float(sums[STRAIN])
        force = self._reactions(done.end, impulse)
        names = [f"reaction.{face.name}" for face in scene.faces]
        names += [f"constraint.{name}" for name in scene.case.constraints]
        for name, row in zip(names, force, strict=False):
            for i, axis in enumerate(axes):
                line[f"{name}-{axis}"] = float(row[i])
        for name, entry in scene.case.constraints.items():
            for axis, way in zip(axes, entry.displacement(done.end), strict=True):
                if way is not None:
                    line[f"displacement.{name}-{axis}"] = way
        for face, mass in zip(scene.faces, beyond, strict=True):
            line[f"beyond.{face.name}"] = float(mass)
            if total[MASS]:
                part = float(mass / total[MASS])
                self.beyond = max(self.beyond, (part, done.end, face.name))
        meet = zip(scene.case.contact, force[len(names) :], contact, strict=False)
        for entry, row, booked in meet:
            for i, axis in enumerate(axes):
                if len(entry.bodies) == 2:
                    line[f"contact.{entry.name}-{axis}"] = float(row[i])
            for name, column in CONTACT.items():
                line[f"contact.{entry.name}.{name}"] = float(booked[column])
        return line

    @staticmethod
    def _totals(prefix: str, sums: np.ndarray, dimension: int) -> dict[str, float]:
        """Columns of mass, momentum, angular momentum and energies."""
        line = {"mass": sums[MASS]}
        for i, axis in enumerate(AXES[:dimension]):
            line[f"momentum-{axis}"] = sums[MOMENTUM + i]
        # A motion along x alone has no moment about the origin, one in the plane only that about z.
        for i in ((), (2,), (0, 1, 2))[dimension - 1]:
            line[f"angular-momentum-{AXES[i]}"] = sums[ANGULAR + i]
        line |= {"kinetic-energy": sums[KINETIC], "strain-energy": sums[STRAIN]}
        return {prefix + name: float(value) for name, value in line.items()}

    def _reactions(self, time: float, impulse: np.ndarray) -> np.ndarray:
        """Mean forces of faces and constraints since the last line, (faces + constraints, 3)."""
        if self.last is None:
            force = np.zeros_like(impulse)
        elif time > self.last[0]:
            force = (impulse - self.last[1]) / (time - self.last[0])
        else:
            return self.last[2]
        self.last = (time, impulse, force)
        return force
