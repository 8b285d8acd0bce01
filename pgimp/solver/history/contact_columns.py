"""The columns of history.csv about contact and rigid bodies; see `pgimp.solver.history.columns`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pgimp.kernels.data.ledger import (
    CONTACT_AREA,
    HEAT,
    LOSS,
    NORMAL_IMPULSE,
    RIGID_WORK,
    TANGENTIAL_IMPULSE,
    WALL_HEAT,
    WALL_LOSS,
)
from pgimp.scene.rigid.free_body import FreeBody, Six
from pgimp.solver.history.totals import Column, Group, entries_of_two

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

#: Stand-in for a body's six numbers before it is measured, where only names matter.
_SIX: Six = (0.0,) * 6


def _letting(scene: Scene) -> list[int]:
    """Numbers of the unilateral faces."""
    return [n for n, face in enumerate(scene.domain.faces) if face.condition.approaches]


def _absorbing(scene: Scene) -> list[int]:
    """Numbers of the absorbing faces."""
    return [n for n, _ in scene.domain.absorbing]


def _taking(scene: Scene) -> list[int]:
    """Numbers of the faces that may take energy: unilateral, or holding every component."""
    holding = [
        n for n, face in enumerate(scene.domain.faces) if face.condition.motion(0.0) is not None
    ]
    return sorted(_letting(scene) + holding)


def _placed(scene: Scene) -> list[str]:
    """Names of the entries of two bodies that meet by their surfaces."""
    entries = entries_of_two(scene) if scene.settings.by_vertex else []
    return [scene.case.contact[k].name for k in entries]


WALLS = (
    Group(lambda scene: [scene.domain.faces[n].name for n in _letting(scene)], (
        Column("wall.FACE.friction-heat", "energy",
            "for each `unilateral` face: energy that its friction turned into heat since the "
            "start, force times way; a part of dissipated-energy, as friction-heat of contact",
            lambda s, k: s.walls[_letting(s.scene)[k], WALL_HEAT]),
    )),
    Group(lambda scene: [scene.domain.faces[n].name for n in _absorbing(scene)], (
        Column("radiated.FACE", "energy",
            "for each `absorbing` face: energy that left through it since the start, force of its "
            "dashpots times mean velocity; a part of dissipated-energy",
            lambda s, k: s.walls[_absorbing(s.scene)[k], WALL_LOSS]),
    )),
    Group(lambda scene: [scene.domain.faces[n].name for n in _taking(scene)], (
        Column("wall.FACE.impact-loss", "energy",
            "for each `unilateral` face, and each that holds every component of the velocity, "
            "likewise: what its force along the normal took from what still moves into it while it "
            "is stopped; what particles lose that a face holds, and that keep the velocity with "
            "which they came",
            lambda s, k: s.walls[_taking(s.scene)[k], WALL_LOSS]),
    )),
)  # fmt: skip
"""Groups of columns of walls, in their order."""

MEETING = (
    Group(lambda scene: [entry.name for entry in scene.case.contact], (
        Column("contact.NAME-AXIS", "force",
            "for each entry of `contact` that names two bodies, NAME being their names with a + in "
            "between: mean force of the second on the first since the last line",
            lambda s, k: s.contact_force(k)),
        Column("contact.NAME.normal-impulse", "mass length/time",
            "for each entry of `contact`, `all` or the names of its bodies: sum, since the start "
            "and over the vertices, of what bodies exchanged along normals",
            lambda s, k: s.contact[k, NORMAL_IMPULSE]),
        Column("contact.NAME.tangential-impulse", "mass length/time", "likewise across the normals",
            lambda s, k: s.contact[k, TANGENTIAL_IMPULSE]),
        Column("contact.NAME.friction-heat", "energy",
            "energy that friction turned into heat since the start: force times way",
            lambda s, k: s.contact[k, HEAT]),
        Column("contact.NAME.impact-loss", "energy",
            "energy that forces along normals took since the start, force times way: what bodies "
            "lose that still close a gap while they are stopped, of first order in the cell size, "
            "and what rigid bodies that move freely lose at once as they hit; a part of "
            "dissipated-energy, as friction-heat is",
            lambda s, k: s.contact[k, LOSS]),
        Column("contact.NAME.area", "length^(dimensions - 1)",
            "area on which bodies pressed on each other in the last step; by surfaces that of the "
            "undeformed bodies",
            lambda s, k: s.contact[k, CONTACT_AREA]),
    )),
    Group(_placed, (
        Column("contact.NAME.moment-AXIS", "force length",
            "of bodies that meet by their surfaces, as the next column, for each entry that names "
            "two: mean moment of the second on the first since the last line, about the origin of "
            "the coordinates; about z alone in 2D, none in 1D",
            lambda s, k: s.contact_moment(k)),
        Column("contact.NAME.centre-AXIS", "length",
            "centre of pressure: mean place of the normal forces since the last line; nan without "
            "any",
            lambda s, k: s.centre_of_pressure(k)),
    )),
    Group(lambda scene: scene.interaction.rigid_bodies.names, (
        Column("rigid.NAME.force-AXIS", "force",
            "for each rigid body: mean force of the material on it since the last line",
            lambda s, k: s.on_tool(k)),
        Column("rigid.NAME.torque-AXIS", "force length",
            "its mean moment, about the body's axis where it turns, about its centre of mass where "
            "it moves freely, else about the origin of the coordinates, which moves with it; about "
            "z alone in 2D, none in 1D",
            lambda s, k: s.moment_on_tool(k)),
        Column("rigid.NAME.work", "energy",
            "work of the rigid body on the material since the start, a part of external-work; of "
            "one that moves freely the energy that it gives up: impulse times the mean of its "
            "velocities at a step's beginning and end",
            lambda s, k: s.rigid_bodies[k, RIGID_WORK]),
        Column("rigid.NAME.penetrating-particles", "1",
            "number of particles whose centres, of cut ones the centroids, are deeper in it than a "
            "quarter of a cell's smallest side; not those that pass by `law: ignore`",
            lambda s, k: int(s.inside[k])),
        Column("rigid.NAME.displacement-AXIS", "length",
            "way of the rigid body since the start: of its axis where it turns, of its centre of "
            "mass where it moves freely",
            lambda s, k: s.displacement_of_tool(k)),
    )),
    Group(
        lambda scene: [
            name for name, rigid_body in scene.case.rigid_bodies.items() if rigid_body.free
        ],
        (
            Column("rigid.NAME.velocity-AXIS", "length/time",
                "for each rigid body that moves freely: velocity of its centre of mass",
                lambda s, k: s.along(s.of_free(k, FreeBody.velocities, _SIX), 0)),
            Column("rigid.NAME.angular-velocity-AXIS", "1/time",
                "its angular velocity; about z alone in 2D, none in 1D, as the next two",
                lambda s, k: s.about_axes(s.of_free(k, FreeBody.velocities, _SIX)[3:])),
            Column("rigid.NAME.angle-AXIS", "1",
                "the integral of its angular velocity since the start",
                lambda s, k: s.about_axes(s.of_free(k, FreeBody.angle, _SIX))),
            Column("rigid.NAME.angular-momentum-AXIS", "mass length^2/time",
                "its angular momentum about the origin of the coordinates",
                lambda s, k: s.about_axes(s.of_free(k, FreeBody.moments, _SIX)[3:])),
            Column("rigid.NAME.momentum-AXIS", "mass length/time", "its momentum",
                lambda s, k: s.along(s.of_free(k, FreeBody.moments, _SIX), 0)),
            Column("rigid.NAME.kinetic-energy", "energy", "its kinetic energy",
                lambda s, k: s.of_free(k, FreeBody.energy, 0.0)),
        )),
)  # fmt: skip
"""Groups of columns, in their order."""
