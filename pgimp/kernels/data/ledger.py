"""Sums that a simulation books by plane from step to step, for the history."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

#: Columns of `Ledger.contact`, for each entry in a step: impulse on the first body; normal and
#: tangential impulse; friction heat; energy lost in impacts; area.
IMPULSE, NORMAL_IMPULSE, TANGENTIAL_IMPULSE, HEAT, LOSS, CONTACT_AREA, BOOKED = 0, 3, 4, 5, 6, 7, 8

#: Rows of `Ledger.contact_moments`, for each entry: moment on the first body about the origin;
#: normal impulse times place; normal impulse, once.
MOMENT, PLACED, PRESSED, PLACES = 0, 1, 2, 3

#: Columns of `Ledger.wall_energy`, for each face: heat of friction; energy lost in impacts.
WALL_HEAT, WALL_LOSS, WALL_BOOKED = 0, 1, 2

#: Columns of `Ledger.rigid_bodies`, accumulated for each rigid body: received impulse and angular
#: impulse about its reference point, and work done by it.
RIGID_IMPULSE, RIGID_MOMENT, RIGID_WORK, TOOLED = 0, 3, 6, 7

#: Columns of `Ledger.filled`, for each body: volume of flowing particles, and the part with room at
#: the vertices.
CARRIED, ROOM, VOLUMES = 0, 1, 2

#: Columns of `Ledger.damping`: energy and momentum taken so far; for kinetic damping the kinetic
#: energy of the vertices after the last step and after the step before it; while a run settles
#: the power of the unbalanced forces in their place, and magnitudes of forces, summed over the
#: vertices: of stresses and loads but gravity, and the unbalanced ones.
DAMPED_ENERGY, DAMPED_MOMENTUM, TAKEN = 0, 1, 4
KINETIC_NOW, KINETIC_BEFORE, INTERNAL, UNBALANCED, DAMPED = 4, 5, 6, 7, 8


class Ledger(NamedTuple):
    """Sums by plane; only planes that a rank owns count."""

    work: np.ndarray  #: (planes,) float64: Work of loads, faces and constraints on the material.
    impulse: np.ndarray  #: (planes, faces, 3) float64: Impulse of each face with a condition.
    outside_mass: np.ndarray  #: (planes, faces) float64: Mass beyond each face in the last step.
    #: (planes, constraints + turning ones, 3) float64: Impulse of each constraint, and then of each
    #: that turns the angular impulse about its centre at each step's beginning.
    constraint_impulse: np.ndarray
    #: (planes, faces, WALL_BOOKED) float64: Energy taken by each unilateral face, or each face that
    #: holds all components; the energy that left through an absorbing face, as a loss; else zeros.
    wall_energy: np.ndarray
    contact: np.ndarray  #: (planes, entries, BOOKED) float64: Sums of each entry of contact.
    rigid_bodies: np.ndarray  #: (planes, rigid bodies, TOOLED) float64: Sums of each rigid body.
    #: (planes, bodies, SUMS) float64: Sums of the particles that left, as in `layer_sums`; (planes,
    #: 0, 0) where none may leave.
    escaped: np.ndarray
    #: (planes, bodies, VOLUMES) float64: Volumes of flowing bodies at the last filling; else
    #: (planes, 0, VOLUMES).
    filled: np.ndarray
    #: (planes, DAMPED) float64: Sums of damping and of settling; (planes, 0) without them.
    damping: np.ndarray
    #: (planes, 2 flux gauges, 3) float64: What has left through each surface: (mass, 0, 0),
    #: momentum.
    crossed: np.ndarray
    #: (planes, tractions, 3) float64: Impulse of each traction on a face, and then of each on a
    #: region's surface.
    traction_impulse: np.ndarray
    #: (planes, PLACES entries, 3) float64: Where entries of contact act, of bodies that meet by
    #: their surfaces; else (planes, 0, 3).
    contact_moments: np.ndarray

    @classmethod
    def empty(
        cls,
        planes: int,
        faces: int,
        constraints: int,
        escaped: tuple[int, int] = (0, 0),
        contacts: int = 0,
        rigid_bodies: int = 0,
        others: tuple[int, int, int, int, int] = (0, 0, 0, 0, 0),
    ) -> Ledger:
        """Return the ledger of `planes` planes before the first step.

        Parameters
        ----------
        planes, faces, constraints : int
            Their numbers.
        escaped : (int, int)
            Bodies and `SUMS`, where particles may leave.
        contacts : int
            Entries of contact.
        others : (int, int, int, int, int)
            Bodies, in scenes where any flows; `DAMPED` with damping; flux gauges; tractions;
            entries of contact by surfaces.
        """
        flows, damping, fluxes, tractions, placed = others
        shapes = (
            (), (faces, 3), (faces,), (constraints, 3), (faces, WALL_BOOKED), (contacts, BOOKED),
            (rigid_bodies, TOOLED), escaped, (flows, VOLUMES), (damping,), (2 * fluxes, 3),
            (tractions, 3), (PLACES * placed, 3),
        )  # fmt: skip
        return cls(*(np.zeros((planes, *shape)) for shape in shapes))

    def first(self, planes: int) -> Ledger:
        """Return its first planes, such as a rank's own planes, without a copy."""
        return Ledger(*(part[:planes] for part in self))

    def datasets(self) -> dict[str, np.ndarray]:
        """Return the sums by their names in checkpoints."""
        stored = {"outside_mass": "beyond", "wall_energy": "walls", "rigid_bodies": "tools"}
        return {stored.get(name, name): sums for name, sums in self._asdict().items()}
