"""Vertices at which no surfaces reach each other in a step: nothing is exchanged there.

Most contact vertices are such. They are told from the others before normals are found, by a bound,
and then by the law's own condition in both passes.
"""

from typing import Any, NamedTuple

import numpy as np

import pgimp.jit.functions  # noqa: F401  so that they work on vectors of four particles, too
from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.jit.vectors.simd import lane, load
from pgimp.kernels.contact.gap import LEAST_FILLED
from pgimp.kernels.contact.law import parts, rests_apart
from pgimp.kernels.contact.rigid_fields import set_rigid_velocity
from pgimp.kernels.data.arguments import Field
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.record import FORCE, HELD, MASS, MOMENTUM, RECORD
from pgimp.kernels.grid.faces import beyond_any, face_count

#: What rounding may change: factor of a bound's square, part of a neighbourhood or a velocity.
MORE, ROUNDING = 1.0 + 1e-6, 1e-9


class Search(NamedTuple):
    """Where vertices are searched, and for which pass."""

    faces: Any
    frame: Frame
    field: Field
    dt: float
    last: bool  #: Whether only the last pass is to come, and the grid holds velocities.
    gravity: tuple[float, float, float]
    #: Mass of fields that no force accelerates; infinite where momenta may change before the
    #: passes, so that all vertices are listed.
    light: float
    held: np.ndarray  #: (vertices,) int64: Marks of constrained ones; empty without any.


@inner_kernel
def velocity(search, r, d, after):
    """Component `d` of a field's velocity before or after forces act; its record is at `r`."""
    G = search.field.G
    if search.last:
        return G[r + MOMENTUM + d]
    by = 1.0 / G[r + MASS]
    if after:
        return by * G[r + MOMENTUM + d] + search.dt * (by * G[r + FORCE + d] + search.gravity[d])
    return by * G[r + MOMENTUM + d]


@inner_kernel
def _way(search, r, s):
    """Bound of the way by which two fields may come closer in the step; records at `r` and `s`."""
    G = search.field.G
    u, v, a, b = load(G, r), load(G, s), load(G, r + HELD), load(G, s + HELD)
    if not search.last:
        by_r, by_s = 1.0 / lane(u, 0), 1.0 / lane(v, 0)
        u, v, a, b = by_r * u, by_s * v, by_r * a, by_s * b
    before = v - u
    both = max(abs(before), abs(before + search.dt * (b - a)))
    return search.dt * (lane(both, 1) + lane(both, 2) + lane(both, 3))


@inner_kernel
def _moves_freely(contact, search, number, count):
    """Whether walls, constraints and small masses leave the `count` bodies at a vertex alone."""
    for a in range(count):
        if not contact.fields[a].mass > search.light:
            return False
        if len(search.held) > 0 and search.held[contact.offsets[a] // RECORD] != 0:
            return False
    return not beyond_any(search.faces, face_count(search.faces), search.frame, number)


@inner_kernel
def are_apart(contact, search, number, count):
    """Whether the `count` bodies at a vertex are certainly too far apart, by their volumes.

    A gap is at least the missing part of the neighbourhood, by the root of twice the smaller part,
    times a cell's least side; see `pgimp.kernels.contact.gap`.
    """
    fields, missing, side = contact.fields, 1.0, search.frame.cell[0]
    for d in range(len(search.frame.cell)):
        side = min(side, search.frame.cell[d])
    for a in range(count):
        missing -= fields[a].filled
    if not missing > ROUNDING:
        return False
    for a in range(count):
        for b in range(a + 1, count):
            one, other = contact.bodies[a], contact.bodies[b]
            entry = contact.pairs.entry[min(one, other), max(one, other)]
            if entry == 0:
                continue
            if not parts(contact.pairs, abs(entry) - 1):
                return False
            if min(fields[a].filled, fields[b].filled) < LEAST_FILLED:
                continue  # as in `find_pairs`
            way = _way(search, contact.offsets[a], contact.offsets[b])
            way += max(fields[a].curvature_gap + fields[b].curvature_gap, 0.0)
            part = min(2.0 * min(fields[a].filled, fields[b].filled), 1.0)
            if not (missing * side) ** 2 > MORE * part * way * way:
                return False
    return _moves_freely(contact, search, number, count)


@inner_kernel
def stay_apart(contact, search, number, count, rigid, pairs):
    """Whether no pair at a vertex closes its gap, in either pass.

    Of the fields `count` are bodies and `rigid` are rigid bodies, with prescribed motion.
    """
    for after in range(1 if search.last else 0, 2):
        for a in range(count):
            for d in range(3):
                contact.fields[a].velocity[d] = velocity(search, contact.offsets[a], d, after == 1)
        _set_rigid(contact, contact.rigid_bodies, search.frame, number, count, rigid, after == 1)
        for pair in range(pairs):
            row, ends = contact.pair_states[pair], contact.ends[pair]
            u, v = contact.fields[ends.fields[0]], contact.fields[ends.fields[1]]
            apart, terms = row.gap_rate, 0.0
            for d in range(3):
                apart += (v.velocity[d] - u.velocity[d]) * row.normal[d]
                terms += abs(v.velocity[d]) + abs(u.velocity[d])
            if not (apart > ROUNDING * terms and rests_apart(contact.pairs, ends.law - 1, row)):
                return False
    if _any_free(contact, contact.rigid_bodies, count, rigid):
        return False
    return _moves_freely(contact, search, number, count)


@inlined
def _set_rigid(contact, rigid_bodies, frame, number, count, rigid, after):
    """Set the velocities of the rigid bodies at a vertex."""
    if not is_record(rigid_bodies):
        return None
    for a in range(count, count + rigid):
        t = contact.bodies[a] - rigid_bodies.bodies
        set_rigid_velocity(contact.fields[a], rigid_bodies, t, frame, number, after)


@inlined
def _any_free(contact, rigid_bodies, count, rigid):
    """Whether any of the rigid bodies at a vertex moves freely."""
    if not is_record(rigid_bodies):
        return False
    found = False
    for a in range(count, count + rigid):
        found = found or rigid_bodies.lattice[contact.bodies[a] - rigid_bodies.bodies].free >= 0
    return found
