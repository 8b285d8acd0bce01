"""Calls of the contact kernels in the initial configuration, for compilation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.lagrangian.books import book_contacts, book_mirrored
from pgimp.kernels.contact.lagrangian.broad_phase import find_near, mark_blocks
from pgimp.kernels.contact.lagrangian.coupling import Coupling, find_coupling
from pgimp.kernels.contact.lagrangian.cut_supports import narrow_supports
from pgimp.kernels.contact.lagrangian.gauss_seidel import solve_impulses
from pgimp.kernels.contact.lagrangian.hash_table import empty_table, insert_keys
from pgimp.kernels.contact.lagrangian.pairs import ContactPairs, find_contact_pairs
from pgimp.kernels.contact.lagrangian.reactions import book_held
from pgimp.kernels.contact.lagrangian.reference_grid import (
    REFERENCE_VERTEX,
    ReferenceVertices,
    Seen,
    change_velocities,
    copy_reference_vertices,
    number_reference_vertices,
)
from pgimp.kernels.contact.lagrangian.shared_vertices import find_shared
from pgimp.kernels.contact.lagrangian.supports import Supports, find_supports, local_vertices
from pgimp.kernels.contact.lagrangian.vertices import (
    NEAR_PARTICLE,
    VERTEX_SUMS,
    ContactVertices,
    copy_near_particles,
    sum_at_contact_vertices,
)
from pgimp.kernels.contact.volumes import BOXES
from pgimp.kernels.data.arguments import Forcing
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.node import Call
from pgimp.scene.scene import Scene
from pgimp.solver.contact.lagrangian.bonds import separating_walls, with_walls
from pgimp.solver.contact.lagrangian.broad_phase import no_regions
from pgimp.solver.contact.lagrangian.lagrangian import ENOUGH, nothing_held
from pgimp.solver.contact.lagrangian.near_particles import mirrors_of, plain


def calls(
    scene: Scene, grid: Grid, particles: Any, forcing: Forcing, faces: Any, ledger: Ledger
) -> Iterator[Call]:
    """Calls of the kernels without particles; see `pgimp.solver.start.warmup`."""
    rigid_bodies: Any = scene.rigid_bodies.in_planes(1) if scene.rigid_bodies else ()
    pairs, count = with_walls(scene), len(scene.faces)
    contact = Contact.empty(pairs, np.empty(0), 1, 2, count, rigid_bodies)
    frame, shape, none = scene.frame, scene.shape, np.empty(0, np.int64)
    setting, mirrors = plain(scene), mirrors_of(scene)
    standing, walls = scene.standing_faces(), separating_walls(scene)
    holding = Holding(faces, frame, forcing, contact.scratch_impulse, forcing.loads.relaxation)
    free = nothing_held(holding)
    local = local_vertices(scene.vertices, scene.dimension)
    table, supports = np.empty(0, NEAR_PARTICLE), Supports.empty(0, local)
    vertices, contact_pairs = (
        ReferenceVertices(none, np.empty(0, REFERENCE_VERTEX)),
        ContactPairs.empty(0),
    )
    contact_vertices = ContactVertices(
        np.zeros(3, np.int64), none, 1, none, np.empty(0, VERTEX_SUMS), none
    )
    rows = Coupling(
        np.zeros(1, np.int64), none, np.empty((0, 3)), np.empty((0, 3)),
        np.empty((0, len(mirrors), 3)),
    )  # fmt: skip
    values = vertices.values
    regions, order = no_regions(scene.dimension), np.empty(0, np.int32)
    yield 0.3, lambda: mark_blocks(frame, particles, order, none, regions)
    yield 0.3, lambda: find_near(frame, particles, order, none, regions, none)
    yield (
        0.5,
        lambda: copy_near_particles(setting, particles, none, none, none, scene.lagrangian, table),
    )
    yield 1.0, lambda: find_supports(shape, frame, table, True, supports)
    yield (
        3.0,
        lambda: copy_reference_vertices(
            holding, grid.field, table, supports, mirrors, Seen(none, 0), vertices
        ),
    )
    numbers, boxes = np.empty((0, len(local)), np.int64), np.empty((0, 2, 3), np.int64)
    yield 1.0, lambda: find_shared(table, local, np.zeros(3, np.int64), boxes, contact_vertices)
    yield (
        1.0,
        lambda: sum_at_contact_vertices(
            frame, table, supports, supports, 0.0, none, numbers, contact_vertices
        ),
    )
    if isinstance(shape, BOXES):
        yield 0.5, lambda: narrow_supports(shape, frame, table, supports, supports)
    yield (
        4.0,
        lambda: find_contact_pairs(
            contact, frame, standing, walls, contact_vertices, 1.0, contact_pairs
        ),
    )
    yield 0.2, lambda: insert_keys(none, empty_table(0))
    yield 0.3, lambda: number_reference_vertices(frame, table, supports, mirrors, 1, empty_table(0))
    yield (
        2.0,
        lambda: find_coupling(
            frame, table, supports, supports, mirrors, contact_pairs, contact_vertices.sums, values
        ),
    )
    yield 2.0, lambda: solve_impulses(contact, free, contact_pairs, rows, values, 1, ENOUGH)
    yield (
        0.3,
        lambda: change_velocities(frame, grid.field, none, np.empty((0, 3)), forcing, ledger.work),
    )
    yield 1.0, lambda: book_held(holding, grid.field, vertices, ledger)
    if len(mirrors):
        yield 0.3, lambda: book_mirrored(contact_pairs, rows, mirrors, ledger)
    yield 2.0, lambda: book_contacts(contact, free, contact_pairs, rows, values, walls, ledger)
