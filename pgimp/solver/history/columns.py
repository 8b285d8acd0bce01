"""The columns of history.csv, each declared once: name, unit, meaning, and the value in a line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from pgimp.kernels.data.ledger import DAMPED_ENERGY, DAMPED_MOMENTUM
from pgimp.kernels.sums.sums import KINETIC, MASS, MOMENT, MOMENTUM, STRAIN
from pgimp.solver.history.contact_columns import MEETING, WALLS
from pgimp.solver.history.error_columns import ERRORS
from pgimp.solver.history.flow_columns import FLOWS
from pgimp.solver.history.gauge_columns import GAUGES
from pgimp.solver.history.passed_columns import ESCAPED, REMOVED_AND_CAME
from pgimp.solver.history.totals import Column, Group, Totals

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene


def _faces(scene: Scene) -> list[str]:
    return [face.name for face in scene.domain.faces]


def _constraints(scene: Scene) -> list[str]:
    return [*scene.case.constraints]


def _loss(name: str, meaning: str) -> Group:
    """The column of one of `LOSSES`, in scenes with materials that report it."""
    return Group(
        lambda scene: [""] if name in scene.materials.losses else [],
        (Column(name, "energy", meaning, lambda s, _: s.lost(name)),),
    )


HISTORY = (
    Group(lambda scene: [""], (
        Column("time", "time", "simulated time", lambda s, _: s.done.end),
        Column("step", "", "steps done", lambda s, _: s.done.number),
        Column("dt", "time", "length of the last step, 0 before the first", lambda s, _: s.done.dt),
        Column("mass", "mass", "mass of all particles", lambda s, _: s.total[MASS]),
        Column("momentum-AXIS", "mass length/time", "linear momentum",
            lambda s, _: s.along(s.total, MOMENTUM)),
        Column("angular-momentum-AXIS", "mass length^2/time",
            "angular momentum about the origin of the coordinates, counter-clockwise positive; "
            "about z alone in 2D, none in 1D",
            lambda s, _: s.moment(s.total)),
        Column("kinetic-energy", "energy", "kinetic energy of the particles",
            lambda s, _: s.total[KINETIC]),
        Column("strain-energy", "energy", "strain energy", lambda s, _: s.total[STRAIN]),
        Column("dissipated-energy", "energy",
            "what closes the balance: energy at the start plus external work less kinetic and "
            "strain energy, less that of particles that were removed, with that of particles that "
            "came (and with what stages have changed, `stages.strain-energy`); of the order of the "
            "time step also where nothing is lost, for instance in free fall, because work is "
            "force times displacement",
            lambda s, _: (
                s.first_energy
                + s.work
                - s.total[KINETIC]
                - s.total[STRAIN]
                - (s.escaped[KINETIC] + s.escaped[STRAIN])
                - (s.removed[KINETIC] + s.removed[STRAIN])
                + (s.added[KINETIC] + s.added[STRAIN])
                + (s.inflow[KINETIC] + s.inflow[STRAIN])
                + s.changed
            )),
        Column("external-work", "energy",
            "work of gravity, body forces, faces, tractions, constraints and rigid bodies on the "
            "material since the start: force times displacement; friction of what is at rest does "
            "none, what it takes is in dissipated-energy",
            lambda s, _: s.work),
    )),
    Group(lambda scene: [""] if scene.case.time.mass_scaling != 1.0 else [], (
        Column("mass-scaling", "",
            "only with `time.mass-scaling`: its factor on inertia, with which masses, momenta and "
            "kinetic energies are",
            lambda s, _: s.scene.case.time.mass_scaling),
    )),
    _loss("plastic-work",
        "only with materials that tell it, as the next columns: energy that plastic flow took "
        "since the start, a part of dissipated-energy; as all of these with what removed particles "
        "took along"),
    _loss("viscous-work", "energy that viscous stresses of materials took, likewise"),
    _loss("heat", "energy that became heat in materials with a temperature: a part of the others"),
    Group(lambda scene: [""] if scene.settings.damps else [], (
        Column("damped-energy", "energy",
            "only with `damping`: energy that it took since the start, a part of "
            "dissipated-energy: force times mean velocity in each step, and with `kinetic` the "
            "kinetic energy at each peak",
            lambda s, _: s.damping[DAMPED_ENERGY]),
        Column("damped-momentum-AXIS", "mass length/time",
            "momentum that it took since the start, likewise",
            lambda s, _: s.along(s.damping, DAMPED_MOMENTUM)),
    )),
    *ESCAPED,
    Group(lambda scene: [""] if scene.case.staged.number else [], (
        Column("stages.strain-energy", "energy",
            "only with `time.stages`, as the next columns: strain energy that materials got as "
            "stages began because their parameters are others, the stress and deformation being "
            "what they were",
            lambda s, _: s.changed),
    )),
    Group(lambda scene: [""] if scene.case.rests or scene.case.staged.settled else [], (
        Column("stages.settling-time", "time",
            "only with stages that come to rest: time that their steps have taken, which simulated "
            "time leaves out; mean forces are over both. In a stage at rest they are means over "
            "its last ten steps",
            lambda s, _: s.settling_time),
    )),
    *REMOVED_AND_CAME,
    Group(lambda scene: scene.body_names, (
        Column("body.NAME.mass", "mass", "mass of each body", lambda s, k: s.bodies[k, MASS]),
        Column("body.NAME.centre-AXIS", "length",
            "centre of mass of each body; nan when all its particles were removed",
            lambda s, k: s.along(s.bodies[k], MOMENT) / (s.bodies[k, MASS] or np.nan)),
        Column("body.NAME.momentum-AXIS", "mass length/time", "linear momentum of each body",
            lambda s, k: s.along(s.bodies[k], MOMENTUM)),
        Column("body.NAME.kinetic-energy", "energy", "kinetic energy of each body",
            lambda s, k: s.bodies[k, KINETIC]),
        Column("body.NAME.strain-energy", "energy", "strain energy of each body",
            lambda s, k: s.bodies[k, STRAIN]),
    )),
    *FLOWS,
    Group(_faces, (
        Column("reaction.FACE-AXIS", "force",
            "mean force of each named face on the material since the last line; compression at "
            "x-min gives a positive reaction.x-min-x",
            lambda s, k: s.along(s.force[k], 0)),
    )),
    Group(_constraints, (
        Column("constraint.NAME-AXIS", "force",
            "mean force of each constraint on the material since the last line",
            lambda s, k: s.along(s.force[len(s.scene.domain.faces) + k], 0)),
    )),
    Group(_constraints, (
        Column("displacement.NAME-AXIS", "length",
            "displacement of each constraint, none where it is free: the integral of its "
            "`velocity` since the start; its particles move in steps by the velocity at each "
            "step's end, so that theirs differs from it by an error of first order in the step. "
            "Where a `force` moves them, their own; where it turns, the displacement of its axis, "
            "which is exact",
            lambda s, k: s.scene.interaction.loads.displacement(k, s.done.end, s.moved[k])),
    )),
    Group(lambda scene: scene.interaction.loads.turning, (
        Column("angle.NAME", "",
            "only of constraints with a `rotation`, as the next column: angle by which each has "
            "turned since the start, the integral of its rate",
            lambda s, k: s.scene.interaction.loads.angle(k, s.done.end)),
        Column("torque.NAME-AXIS", "force length",
            "mean moment of each on the material since the last line, about `about` where the axis "
            "has moved it; about z alone in 2D",
            lambda s, k: s.torque(k)),
    )),
    Group(lambda scene: [*scene.case.tractions], (
        Column("traction.NAME-AXIS", "force",
            "mean force of each traction or pressure on the material since the last line, with the "
            "areas, normals and sizes that its steps had; of whole rings in axisymmetry, along the "
            "radius as a sum of magnitudes",
            lambda s, k: s.traction(k)),
    )),
    Group(_faces, (
        Column("overlap-mass.FACE", "mass",
            "mass that particles carry past each named face in the last step, on vertices beyond "
            "it: a particle of fixed size does where the material is compressed against a wall, "
            "and what lies there the wall bears",
            lambda s, k: s.outside_mass[k]),
    )),
    *WALLS,
    *MEETING,
    *GAUGES,
    *ERRORS,
)  # fmt: skip
"""Columns of ``history.csv``, in their order; AXIS stands for x, y, z, as many as there are."""


def line_of(totals: Totals) -> dict[str, float]:
    """Return a line of the history by the names of its columns."""
    line: dict[str, float] = {}
    for group in HISTORY:
        for number, name in enumerate(group.names(totals.scene)):
            for column in group.columns:
                label = column.name.replace("NAME", name).replace("FACE", name)
                line |= _cells(label, column.value(totals, number))
    return line


def _cells(label: str, value: Any) -> Iterator[tuple[str, float]]:
    """Yield the columns of a declared one, with their values."""
    if not label.endswith("AXIS"):
        yield label, value if isinstance(value, int) else float(value)
        return
    for axis, one in zip("xyz", value, strict=False):
        if one is not None:
            yield label.removesuffix("AXIS") + axis, float(one)
