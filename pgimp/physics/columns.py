"""Quantities of vertices, and columns of the history and of probes: names and meaning."""

from __future__ import annotations

from typing import NamedTuple

from pgimp.physics.fields import FIELDS


class Vertex(NamedTuple):
    """A quantity of the grid's vertices."""

    components: str
    """Names of the components in order; empty for a scalar."""
    meaning: str
    """Meaning, with the unit in square brackets where there is one."""


GRID: dict[str, Vertex] = {
    "mass": Vertex("", "mass, the sum of w m over the particles [mass]"),
    "momentum": Vertex("x y z", "momentum, the sum of w m v [mass length/time]"),
    "velocity": Vertex("x y z", "momentum over mass [length/time]"),
    "force": Vertex(
        "x y z",
        "force by which the momentum will grow: of the stresses, of tractions and of gravity, "
        "before faces and constraints act; at rest minus their reaction [force]",
    ),
}
"""What ``output.grid`` may name, at the vertices."""

HISTORY: dict[str, str] = {
    "time": "simulated time [time]",
    "step": "steps done",
    "dt": "length of the last step, 0 before the first [time]",
    "mass": "mass of all particles [mass]",
    "momentum-AXIS": "linear momentum [mass length/time]",
    "angular-momentum-AXIS": (
        "angular momentum about the origin of the coordinates, counter-clockwise positive; "
        "about z alone in 2D, none in 1D [mass length^2/time]"
    ),
    "kinetic-energy": "kinetic energy of the particles [energy]",
    "strain-energy": "strain energy [energy]",
    "dissipated-energy": (
        "what closes the balance: energy at the start plus external work less kinetic and strain "
        "energy, and less that of particles that were removed; of the order of the time step also "
        "where nothing is lost, for instance in free fall, because work is force times "
        "displacement [energy]"
    ),
    "external-work": "work of gravity, faces, tractions and constraints on the material since the "
    "start: force times displacement [energy]",
    "escaped.mass": (
        "only where `escape` removes particles, as all columns of this name: mass of those that "
        "were removed since the start, so that with `mass` it is constant [mass]"
    ),
    "escaped.momentum-AXIS": "their momentum when they were removed [mass length/time]",
    "escaped.angular-momentum-AXIS": "their angular momentum then [mass length^2/time]",
    "escaped.kinetic-energy": "their kinetic energy then [energy]",
    "escaped.strain-energy": "their strain energy then [energy]",
    "body.NAME.mass": "mass of each body [mass]",
    "body.NAME.centre-AXIS": (
        "centre of mass of each body; nan when all its particles were removed [length]"
    ),
    "body.NAME.momentum-AXIS": "linear momentum of each body [mass length/time]",
    "body.NAME.kinetic-energy": "kinetic energy of each body [energy]",
    "body.NAME.strain-energy": "strain energy of each body [energy]",
    "reaction.FACE-AXIS": (
        "mean force of each named face on the material since the last line; compression at x-min "
        "gives a positive reaction.x-min-x [force]"
    ),
    "constraint.NAME-AXIS": (
        "mean force of each constraint on the material since the last line [force]"
    ),
    "displacement.NAME-AXIS": (
        "displacement that each constraint prescribes, none where it is free: the integral of its "
        "`velocity` since the start; its particles move in steps by the velocity at each step's "
        "end, so that theirs differs from it by an error of first order in the step [length]"
    ),
    "contact.NAME-AXIS": (
        "for each entry of `contact` that names two bodies, NAME being their names with a + in "
        "between: mean force of the second on the first since the last line [force]"
    ),
    "contact.NAME.normal-impulse": (
        "for each entry of `contact`, `all` or the names of its bodies: sum, since the start and "
        "over the vertices, of what bodies exchanged along normals [mass length/time]"
    ),
    "contact.NAME.tangential-impulse": "likewise across the normals [mass length/time]",
    "contact.NAME.friction-heat": (
        "energy that friction turned into heat since the start: force times way [energy]"
    ),
    "contact.NAME.impact-loss": (
        "energy that forces along normals took since the start, force times way: what bodies lose "
        "that still close a gap while they are stopped, of first order in the cell size [energy]"
    ),
    "contact.NAME.area": (
        "area on which bodies pressed on each other in the last step [length^(dimensions - 1)]"
    ),
    "beyond.FACE": (
        "mass that particles carry past each named face in the last step, on vertices beyond it: a "
        "particle of fixed size does where the material is compressed against a wall, and what "
        "lies there the wall bears [mass]"
    ),
    "error": (
        "only with `exact`, as all that follows: error of the stress, the sum of |exact - s| times "
        "volume over the particles, over the initial volume times a reference stress: the column's "
        "weight, the stress behind the shock [1]"
    ),
    "error.displacement-l2": (
        "root of the mean square error of the displacement, by initial volume [length]"
    ),
    "error.displacement-max": "greatest error of the displacement of a particle [length]",
    "error.velocity-l2": "as for the displacement [length/time]",
    "error.velocity-max": "as for the displacement [length/time]",
    "error.stress-l2": "as for the displacement, of the Cauchy stress (Frobenius norm) [stress]",
    "error.stress-max": "as for the displacement, of the Cauchy stress [stress]",
}
"""Columns of ``history.csv``, in their order; AXIS stands for x, y, z, as many as there are."""

#: Fields of the particle that a material point follows, after time and step; states come to them.
FOLLOWED = (
    "position", "displacement", "velocity", "stress", "strain", "pressure", "von-mises", "volume",
    "density",
)  # fmt: skip


def patterns(name: str, components: int) -> str:
    """How a quantity's columns are named: AXIS stands for x, y, z and COMPONENT for xx to xz."""
    return f"{name}-{'AXIS' if components == 3 else 'COMPONENT'}" if components else name


POINT: dict[str, str] = {
    "time": "simulated time [time]",
    "step": "steps done",
} | {patterns(name, FIELDS[name].columns): FIELDS[name].meaning for name in FOLLOWED}
"""Columns of a material point's file, in their order."""

PLACE: dict[str, str] = {
    "time": "simulated time [time]",
    "step": "steps done",
    "volume-fraction": "sum of w V over the particles, over the volume of a cell [1]",
    "density": "sum of w m over sum of w V [mass/length^dimensions]",
    "velocity-AXIS": "sum of w m v over sum of w m [length/time]",
    "stress-COMPONENT": "sum of w V times the Cauchy stress, over sum of w V [stress]",
    "pressure": "of this stress [stress]",
    "von-mises": "of this stress [stress]",
}
"""Columns of a place's file, in their order."""
