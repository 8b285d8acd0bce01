"""Calls of every kernel of a scene without particles, for compilation into the cache."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.population import Population
from pgimp.decomposition.slabs import Slab
from pgimp.jit.compiled.collector import spared
from pgimp.kernels.contact.colouring import colour_bodies, find_intervals
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.forces import contact_forces
from pgimp.kernels.contact.lagrangian.boxes import grow_boxes
from pgimp.kernels.contact.rigid_newton import find_rigid_impulses
from pgimp.kernels.contact.select import select_near
from pgimp.kernels.contact.vertex import find_contact_vertices
from pgimp.kernels.contact.volumes import volume_sums
from pgimp.kernels.data.arguments import Forcing, Order, Report
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.grid.constrained_vertices import mark_constrained_vertices
from pgimp.kernels.grid.constraints import apply_constraints
from pgimp.kernels.grid.filling import find_filling, fold_filling, reflect_filling
from pgimp.kernels.grid.mirror import fold, fold_volumes, reflect
from pgimp.kernels.grid.momentum import WHOLE, update_momentum
from pgimp.kernels.grid.wall_gap import find_clearances
from pgimp.kernels.lagrangian.displace import displace_particles
from pgimp.kernels.lagrangian.keep import (
    beyond_bounds,
    book_jumps,
    keep_motion,
    recall_masses,
)
from pgimp.kernels.lagrangian.sums import motion_sums
from pgimp.kernels.once.prestress import bearable_stress, remember_stress
from pgimp.kernels.order.layer_changes import pack_rows, partition_migrants, sort_rows, unpack_rows
from pgimp.kernels.order.order import grow_vertex_bounds, layers_of, locate, merge
from pgimp.kernels.rigid.fill import find_rigid_vertices
from pgimp.kernels.rigid.hold import count_inside, count_near
from pgimp.kernels.sums.errors import ERRORS, initial_velocities, layer_errors
from pgimp.kernels.sums.sums import exact_masses, fastest_rate, layer_sums
from pgimp.kernels.transfer.g2p import grid_to_particles
from pgimp.kernels.transfer.p2g import Others, complete, particles_to_grid
from pgimp.mpi.comm import Serial
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.node import Call, shared_out
from pgimp.scene.bodies.populate import prestressed
from pgimp.scene.checks.overstress import stressed
from pgimp.scene.scene import Scene
from pgimp.solver.configurations import groups_by_configuration
from pgimp.solver.contact.keeping import Keeping
from pgimp.solver.contact.lagrangian import warmup as presentcalls
from pgimp.solver.flows import idle, sums_of
from pgimp.solver.lagrangian.cells import no_cells
from pgimp.solver.time.clock import START
from pgimp.solver.vertices import on_particles, on_vertices


def _of_flows(scene: Scene, grid: Grid, p: Particles, order: Order) -> Iterator[Call]:
    """The calls for the filling of the vertices."""
    flows = scene.flows
    assert flows is not None
    own = Grid(scene.frame, scene.vertices, grid.slab, fields=flows.fields)
    own.store(grid.base)
    sums, rigid_bodies = sums_of(flows), _rigid_bodies(scene, grid)
    yield 6.0, lambda: particles_to_grid(
        scene.setting.without_materials(), own.field, p, sums, order, np.zeros((0, 3), np.int64), ()
    )
    yield (
        2.0,
        lambda: find_filling(
            scene.frame, own.field, flows.sides, rigid_bodies, flows.fills, sums.calming
        ),
    )
    for wall in flows.walls[:1]:
        yield 0.5, partial(fold_filling, scene.frame, own.field, wall)
        yield 0.5, partial(reflect_filling, scene.frame, own.field, wall)


def _of_motion(
    scene: Scene, grid: Grid, p: Particles, order: Order, forcing: Forcing
) -> Iterator[Call]:
    """The calls for the motion of vertices in the initial configuration."""
    frame, setting = scene.frame, scene.setting_lagrangian if scene.mixed else scene.setting
    faces, ledger = scene.face_parameters(0.0, 0.0), Ledger.empty(grid.planes, len(scene.faces), 1)
    sums = np.zeros((1, len(scene.body_names), scene.sums))
    yield 0.3, lambda: keep_motion(grid.field, 0.0)
    yield 0.5, lambda: book_jumps(frame, faces, grid.field, on_vertices(forcing), ledger)
    yield (
        1.5,
        lambda: motion_sums(setting.without_materials(), grid.field, p, order, sums),
    )
    if scene.by_cells:
        yield 0.2, lambda: recall_masses(grid.field)
        yield 0.3, lambda: beyond_bounds(frame, grid.field, np.zeros((len(frame.cell), 2)))
        yield 2.5, lambda: displace_particles(setting, frame, grid.motion_field, p, order)


def _rigid_bodies(scene: Scene, grid: Grid) -> Any:
    """The rigid bodies for kernels; () where there are none."""
    return scene.rigid_bodies.in_planes(grid.planes) if scene.rigid_bodies else ()


def warm_up(scene: Scene, comm: Communicator) -> None:
    """Call each kernel once with the types of the scene's steps; collective."""
    with spared():
        shared_out(comm, _calls(scene))


def _calls(scene: Scene) -> Iterator[Call]:
    """The calls, with the seconds of each one's compilation, in 3D on one machine."""
    setting, frame, shape, vertices = scene.setting, scene.frame, scene.shape, scene.vertices
    shaped, material = setting.without_materials(), setting.without_shape()
    p = Particles.empty(1, scene.carried)
    loads, constraints = scene.loads.at(0.0), scene.loads.constraints_at(0.0, 0.0)
    rows = np.empty(0, np.int32)
    start = np.zeros(2, np.int64)
    order = Order(rows, start)
    bounds = np.array([[2**62] * 2, [-(2**62)] * 2])
    fields = (0,) * len(scene.body_names) if scene.pairs else ()
    grid = Grid(
        frame, vertices, Slab(0, 1, None, None), fields=fields,
        bounds=scene.bounds if scene.initial else None, lagrangian=scene.lagrangian_bodies,
    )  # fmt: skip
    grid.cover(np.full((2, 2), vertices))
    wire = np.empty(0, np.int64)
    bodies, faces = len(scene.material_of), scene.face_parameters(0.0, 0.0)
    count = len(scene.faces)
    marked = (constraints, grid.marks) if constraints else ()
    clearances = np.empty((count, 0)) if scene.approached else ()
    controlled = scene.controlled
    forcing = Forcing(
        1.0,
        scene.gravity(0.0),
        0.0,
        loads,
        constraints,
        marked,
        scene.walls(0.0, 0.0),
        controlled,
        clearances,
    )
    vertex_forcing = on_vertices(forcing)
    report = Report(bounds, rows.copy(), np.zeros((1, 2), np.int64))
    ledger = Ledger.empty(grid.planes, count, len(constraints))
    contact: Any = ()
    if scene.mixed or (scene.initial and (scene.pairs or scene.unilateral_walls)):
        yield 0.3, lambda: grow_boxes(frame, p, rows, np.zeros((2, bodies, len(frame.cell))))
        yield from presentcalls.calls(scene, grid, p, vertex_forcing, faces, ledger)
    elif scene.pairs:
        rigid_bodies = _rigid_bodies(scene, grid)
        contact = Contact.empty(scene.pairs, grid.G, grid.planes, 1, count, rigid_bodies)
        if scene.rigid_bodies.free:
            yield (
                2.0,
                lambda: find_rigid_impulses(contact, faces, frame, grid.field, vertex_forcing),
            )
        if rigid_bodies:
            yield (
                1.0,
                lambda: find_rigid_vertices(
                    frame, grid.field, rigid_bodies, contact.vertex_counts, contact.vertex_ranges
                ),
            )
        if "contact" in scene.case.output.grid:
            yield (
                2.0,
                lambda: contact_forces(
                    contact, faces, frame, grid.field, vertex_forcing, True, np.zeros((0, 3))
                ),
            )
        yield (
            0.3,
            lambda: find_contact_vertices(
                grid.field,
                np.zeros(grid.planes, bool),
                contact.vertex_counts,
                contact.vertex_ranges,
            ),
        )
        yield (
            0.3,
            lambda: select_near(
                frame,
                grid.window,
                p,
                order,
                contact.vertex_ranges,
                vertices - 1,
                rows.copy(),
                start.copy(),
            ),
        )
        boxes, none = np.zeros((2, len(fields), len(frame.cell))), np.zeros(0, np.int64)
        yield 0.3, lambda: grow_boxes(frame, p, rows, boxes)
        yield 0.3, lambda: colour_bodies(boxes[:, :0], 1.0, 2, 64, np.zeros(1, np.int64), none)
        yield 0.3, lambda: find_intervals(boxes[:, :0], none, 1.0, np.zeros((0, 2)))
        yield (
            6.0,
            lambda: particles_to_grid(
                shaped, grid.field, p, volume_sums(shape), order, np.zeros((0, 3), np.int64), ()
            ),
        )
    summed = []
    particle_forcing = on_particles(forcing)
    if scene.flows:
        yield from _of_flows(scene, grid, p, order)
        particle_forcing = particle_forcing._replace(filling=idle(scene.flows))
    if keepers := Keeping(scene, Serial(), None, 1).at(START, p, rows):
        particle_forcing = particle_forcing._replace(keepers=keepers)
        numbers = np.zeros(len(scene.rigid_bodies), np.int64)
        yield 1.0, lambda: count_inside(keepers.rigid_bodies, scene.pairs, p, rows, 0.0, numbers)
        if scene.rigid_bodies.free:
            most = np.zeros(len(scene.rigid_bodies))
            yield 0.5, lambda: count_near(keepers.rigid_bodies, p, rows, 0.0, numbers, most)
    for part in groups_by_configuration(
        scene, Population(p, 0, shape, scene.placing, grid.slab, start)
    ):
        yield 10.4, partial(
            grid_to_particles, part.setting, part.bounded(scene, grid.field), p, order,
            np.zeros(0, np.int64), part.forced(particle_forcing), report, ledger,
        )  # fmt: skip
        yield 1.0, partial(fastest_rate, part.setting.without_shape(), p, rows, controlled)
        summed.append((part.setting.without_materials(), part.loaded(loads.summed()), order))
    others: Any = Others(*summed[1]) if len(summed) > 1 else ()
    if scene.by_cells:
        others = no_cells(scene, 1)
    yield (
        6.3 * len(summed),
        lambda: particles_to_grid(
            shaped,
            grid.field,
            p,
            summed[0][1],
            order,
            np.zeros((0, 3), np.int64),
            others,
        ),
    )
    yield (
        2.8,
        lambda: update_momentum(frame, grid.field, faces, vertex_forcing, ledger, contact, WHOLE),
    )
    yield 1.4, lambda: locate(shape, scene.placing, p, rows, frame.vertices)
    yield 1.4, lambda: layer_sums(material, p, order, np.zeros((1, bodies, scene.sums)))
    yield 0.7, lambda: complete(grid.field, 0, 1, False, np.empty(0))
    yield 0.7, lambda: merge(p, rows, start, rows, 0, rows, rows.copy(), start.copy())
    yield 0.5, lambda: pack_rows(*p.columns(), rows, wire, 0, 0)
    yield 0.4, lambda: unpack_rows(*p.columns(), rows, wire, 0, 0)
    yield 0.4, lambda: grow_vertex_bounds(shape, scene.placing, p, rows, bounds)
    yield 0.4, lambda: exact_masses(p, rows, 1.0, np.zeros((bodies, 2), np.int64))
    yield 0.3, lambda: sort_rows(p.layer, p.cell, p.id, rows, rows.copy())
    yield 0.3, lambda: partition_migrants(p.layer, rows, rows, 0, 1, rows.copy(), rows.copy())
    placing, none = scene.placing, np.empty(0, np.int64)
    yield 0.2, lambda: layers_of(shape, placing, scene.identity, np.empty(0), none)
    if scene.lagrangian_bodies is not None:
        yield from _of_motion(scene, grid, p, order, forcing)
    for wall in scene.approached[:1]:
        yield 0.5, partial(find_clearances, frame, grid.field, wall, False, clearances)
    for mirror in scene.mirrors:
        yield 1.0, partial(fold, frame, grid.field, mirror, vertex_forcing, ledger)
        if contact:
            yield 0.5, partial(fold_volumes, frame, grid.field, grid.G, mirror)
        yield 1.0, partial(reflect, frame, grid.field, mirror, vertex_forcing, ledger)
    if marked:
        for each, _, _ in summed:
            yield 1.0, partial(mark_constrained_vertices, each, grid.window, p, order, grid.marks)
        yield 1.0, lambda: apply_constraints(grid.field, vertex_forcing, ledger)
    if scene.exact:
        yield 2.0, lambda: layer_errors(
            scene.exact, 0.0, scene.follows, setting, p, order, np.zeros((1, ERRORS)),
            np.zeros((1, ERRORS)),
        )  # fmt: skip
    if prestressed(scene):
        yield 1.0, lambda: remember_stress(material, p, np.empty(0, np.int64))
    if stressed(scene):
        yield 2.0, lambda: bearable_stress(material, p, np.empty(0, np.int64), p.sigma[:0])
    if scene.moves:
        yield 1.0, lambda: initial_velocities(scene.exact, frame, p.x[:0], p.v[:0])
