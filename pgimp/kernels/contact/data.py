"""Data of contact at a vertex shared by the velocity fields of several bodies.

Two passes: the first projects the momenta from the particles before forces act, the second the
velocities after the forces. Particles receive the second pass's change as an acceleration, but not
the first's: it would turn velocities that the grid cannot resolve into a force. Together the passes
make two tied bodies move as one, to rounding.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel
from pgimp.jit.memory import structure
from pgimp.kernels.contact.listed import VertexList
from pgimp.kernels.contact.select import VERTEX_RANGE
from pgimp.kernels.rigid.bodies import AnyRigidBodies
from pgimp.physics.contact.pairs import Pairs

#: Sweeps over the pairs of a vertex where one is not enough: with more than two fields, or with
#: fields held by walls or constraints.
SWEEPS = 8

#: A velocity field at a vertex. `filled` is the filled part of the neighbourhood, `surface` the sum
#: of V grad S. `inverse_mass`, by component, is 0 where the field is held;
#: `bilateral_inverse_mass` only where it is held at any velocity, not by unilateral walls.
#: A rigid body has infinite mass.
FIELD_STATE = structure(
    ("mass", "f8"),
    ("filled", "f8"),
    ("surface", "f8", 3),
    ("curvature_gap", "f8"),
    ("velocity", "f8", 3),
    ("velocity_before", "f8", 3),
    ("inverse_mass", "f8", 3),
    ("bilateral_inverse_mass", "f8", 3),
)

#: A pair of fields. `normal` is from the first to the second, `gap_rate` the velocity that closes
#: the gap within the step. Impulses are accumulated; `sticking` is the tangential impulse over the
#: sticking impulse. `adhesion` and `shear_adhesion` bound the adhesive impulses along the normal
#: and across it. `adhesion_used` is the adhesive impulse along the normal over the impulse required
#: to hold.
PAIR_STATE = structure(
    ("normal", "f8", 3),
    ("gap_rate", "f8"),
    ("area", "f8"),
    ("normal_impulse", "f8"),
    ("tangential_impulse", "f8", 3),
    ("sticking", "f8"),
    ("adhesion", "f8"),
    ("shear_adhesion", "f8"),
    ("adhesion_used", "f8"),
)

#: The two fields of a pair, and the entry of its law.
PAIR_ENDS = np.dtype([("fields", "i8", 2), ("law", "i8")], align=True)


class Contact(NamedTuple):
    """The data of contact for the kernels."""

    pairs: Pairs  #: The law of each pair of bodies.
    #: (planes * plane,) float64: The sums of `VolumeSums`, for the planes with contact vertices.
    volumes: np.ndarray
    used: np.ndarray  #: (planes + 1, fields) int64: Their used rows, see `Field`.
    vertex_counts: np.ndarray  #: (planes,) int64: Number of the contact vertices in each plane.
    #: (planes,) VERTEX_RANGE: Range of these vertices in each plane, see `select_near`.
    vertex_ranges: np.ndarray
    #: The vertices at which pairs act on each other, found once for the passes of a step.
    listed: VertexList
    #: (planes, y, z) int64: Bits of the fields that have mass at a vertex, see
    #: `find_contact_vertices`; empty where vertices are not marked.
    marks: np.ndarray
    present: np.ndarray  #: (fields,) int64: Scratch: fields that may have mass at a vertex.
    #: offsets, bodies: (fields,) int64: Scratch: offsets of the fields' records at a vertex, and
    #: their bodies.
    offsets: np.ndarray
    bodies: np.ndarray
    fields: np.ndarray  #: (fields,) FIELD_STATE: Scratch: their states.
    #: (pairs,) PAIR_ENDS: Scratch: the fields of each pair at a vertex, and its law.
    ends: np.ndarray
    pair_states: np.ndarray  #: (pairs,) PAIR_STATE: Scratch: the states of the pairs.
    scratch_impulse: np.ndarray  #: (faces, 3) float64: Scratch for unbooked impulses of faces.
    #: (planes, y, z) int8: Whether a vertex is near rigid bodies, see `find_rigid_vertices`; empty
    #: without any.
    near: np.ndarray
    #: RigidBodies or (): The rigid bodies, which count as fields without records in the grid, and
    #: with infinite mass.
    rigid_bodies: AnyRigidBodies

    @classmethod
    def empty(
        cls,
        pairs: Pairs,
        volumes: np.ndarray,
        planes: int,
        fields: int,
        faces: int,
        rigid_bodies: AnyRigidBodies = (),
    ) -> "Contact":
        """Allocate for `planes` planes, with at most `fields` bodies at a vertex."""
        most = fields + (len(rigid_bodies.motion) if rigid_bodies else 0)
        count = most * (most - 1) // 2
        return cls(
            pairs, volumes, np.zeros((0, 0), np.int64),
            np.zeros(planes, np.int64), np.zeros(planes, VERTEX_RANGE), VertexList.empty(planes),
            np.zeros((0, 0, 0), np.int64), *np.zeros((3, most), np.int64),
            np.zeros(most, FIELD_STATE), np.zeros(count, PAIR_ENDS), np.zeros(count, PAIR_STATE),
            np.zeros((faces, 3)), np.zeros((0, 0, 0), np.int8), rigid_bodies,
        )  # fmt: skip


@inner_kernel
def fields_of(contact, pair):
    """The two fields of a pair."""
    fields = contact.ends[pair].fields
    return fields[0], fields[1]


@inner_kernel
def impulse_of(row, d):
    """Component `d` of the impulse that a pair has exchanged."""
    return row.tangential_impulse[d] + row.normal_impulse * row.normal[d]


@inner_kernel
def clear_field(row):
    """Set the state of a field to zero."""
    row.mass = row.filled = row.curvature_gap = 0.0
    for d in range(3):
        row.surface[d] = row.velocity[d] = row.velocity_before[d] = 0.0
        row.inverse_mass[d] = row.bilateral_inverse_mass[d] = 0.0


@inner_kernel
def clear_pair(row):
    """Set the state of a pair to zero."""
    row.gap_rate = row.area = row.normal_impulse = row.sticking = 0.0
    row.adhesion = row.shear_adhesion = row.adhesion_used = 0.0
    for d in range(3):
        row.normal[d] = row.tangential_impulse[d] = 0.0
