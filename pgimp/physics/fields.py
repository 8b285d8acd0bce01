"""Quantities of the particles that frames hold, and columns of the history: names and meaning."""

from __future__ import annotations

from typing import NamedTuple


class Field(NamedTuple):
    """One dataset of a frame."""

    components: str
    """Shape of a particle's value, in words."""
    meaning: str
    """Meaning, with the unit in square brackets where there is one."""


ALWAYS: dict[str, Field] = {
    "id": Field("1", "number of the particle, by body, then by initial position"),
    "body": Field("1", "index of the body; the names are in the attributes"),
    "material": Field("1", "index of the material; the names are in the attributes"),
    "position": Field("3", "position of the centre [length]; zeros beyond the case's dimensions"),
    "volume": Field("1", "current volume, det(F) times the initial one [length^dimensions]"),
    "radius": Field(
        "1", "half the side of a segment, square or cube of the current volume, to draw it [length]"
    ),
}
"""What every frame holds."""

FIELDS: dict[str, Field] = {
    "velocity": Field("3", "velocity [length/time]"),
    "stress": Field("6: xx yy zz xy yz xz", "Cauchy stress, tension positive [stress]"),
    "displacement": Field("3", "position less initial position [length]"),
    "deformation": Field("9: xx xy xz yx ... zz", "deformation gradient F, row by row"),
    "pressure": Field("1", "-(xx + yy + zz)/3 of the stress, compression positive [stress]"),
    "von-mises": Field("1", "von Mises equivalent stress [stress]"),
    "strain": Field(
        "6: xx yy zz xy yz xz",
        "Green-Lagrange strain, (F^T F - 1)/2, which a rotation leaves zero; tensor components: xy "
        "is half the angle of shear where that is small",
    ),
    "mass": Field("1", "mass, which never changes [mass]"),
    "density": Field("1", "mass over current volume [mass/length^dimensions]"),
    "rank": Field(
        "1",
        "rank of MPI that has the particle; as it depends on the number of ranks by its nature, "
        "`pgimp compare` leaves it out",
    ),
}
"""What ``output.fields`` may name."""

GRID: dict[str, Field] = {
    "mass": Field("1", "mass, the sum of w m over the particles [mass]"),
    "momentum": Field("3", "momentum, the sum of w m v [mass length/time]"),
    "velocity": Field("3", "momentum over mass [length/time]"),
    "force": Field(
        "3",
        "force by which the momentum will grow: of the stresses, of tractions and of gravity, "
        "before faces and constraints act; at rest minus their reaction [force]",
    ),
}
"""What ``output.grid`` may name, at the vertices."""

FAILURE: dict[str, Field] = {
    "fault": Field(
        "1",
        "0: a neighbour; 1: position, velocity or deformation is not a finite number; 2: inside "
        "out (det F <= 0); 3: moved by more than a cell in a step; 4: left the domain",
    )
}
"""What the particles in ``failure`` have besides."""

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

POINT: dict[str, str] = {
    "time": "simulated time [time]",
    "step": "steps done",
    "position-AXIS": "position of the particle that is followed [length]",
    "displacement-AXIS": "position less that at the start [length]",
    "velocity-AXIS": "velocity [length/time]",
    "stress-COMPONENT": "Cauchy stress, tension positive [stress]",
    "strain-COMPONENT": "Green-Lagrange strain, as the field of frames [1]",
    "pressure": "as the field of frames [stress]",
    "von-mises": "as the field of frames [stress]",
    "volume": "current volume [length^dimensions]",
    "density": "mass over current volume [mass/length^dimensions]",
}
"""Columns of a material point's file, in their order; COMPONENT stands for xx to xz."""

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
