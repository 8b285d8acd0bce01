"""Motion of vertices in the initial configuration: start, stages, checkpoints, sums.

See `pgimp.kernels.data.motion`. Between two steps it is in `Grid.motion`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.motion import KEPT_MASS, KEPT_VELOCITY
from pgimp.kernels.data.record import MASS, MOMENTUM
from pgimp.kernels.sums.errors import initial_velocities
from pgimp.solver.lagrangian.cells import find_beyond, mark_corners
from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.lagrangian.succession import hand_momentum_over
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.state.stored_motion import vertex_keys
from pgimp.solver.transfers import sum_particles

if TYPE_CHECKING:
    from pgimp.decomposition.grid import Grid
    from pgimp.solver.lagrangian.slaves import Slaves
    from pgimp.solver.rank import Rank

#: Tag of messages with the corners of cells in shared planes.
_CORNERS = 15

VECTOR = slice(MOMENTUM, MOMENTUM + 3)
_VELOCITY = slice(KEPT_VELOCITY, KEPT_VELOCITY + 3)


def begin_motion(rank: Rank, gradients: np.ndarray | None = None) -> None:
    """Project the particles' initial velocities on the vertices that keep them; collective.

    A vertex gets the mean of v_p + L_p (x_v - x_p), weighted with m_p S_vp, so that linear fields
    are exact. Where an exact solution gives the velocities, they are the solution's at x_v.

    Parameters
    ----------
    rank : Rank
        The rank, before its first step.
    gradients : (rows, D, D) float64, optional
        Velocity gradients L, in place of the particles' column.
    """
    scene, grid = rank.scene, rank.grid
    if scene.settings.lagrangian_bodies is None:
        return
    rank.contact.assign_fields(rank)
    particles, D = rank.up_to_date(), scene.dimension
    v, L = particles.v.copy(), np.zeros((particles.capacity, D, D))
    if gradients is not None:
        L = gradients
    elif particles.L.shape[1]:
        L = particles.L[:, : D * D].reshape(L.shape)  # at the start the hoop has no rate
    centre = (
        np.array(scene.domain.frame.origin)
        + 0.5 * np.array(scene.domain.frame.cells) * scene.domain.frame.cell
    )
    particles.v[:] -= np.einsum("pij,pj->pi", L, particles.origin - centre)
    mass, momentum = _sums(rank)
    grid.by_vertex(grid.kept.values)[..., KEPT_MASS] = mass
    if any(rank.comm.allgather(bool(L.any()))):
        x = _coordinates(grid)
        for d in range(D):
            particles.v[:] = L[:, :, d]
            momentum += _sums(rank)[1] * (x[d] - centre[d])[..., None]
    particles.v[:] = v
    mass, momentum = _joined(rank, mass), _joined(rank, momentum)
    m = mass[..., None]
    velocity = np.divide(momentum, m, out=np.zeros_like(momentum), where=m > 0.0)
    if scene.settings.moves:
        velocity = np.where(m > 0.0, _exact(rank), 0.0)
    kept = grid.kept.fields
    grid.by_vertex(grid.kept.values)[:, kept, ..., _VELOCITY] = velocity[:, kept]
    _forget_unreached(rank)
    if rank.slaves:
        _find_slaves(rank)
        rank.slaves.spread(rank, grid.kept.values, KEPT_VELOCITY)
        _share_seams(rank)
    if particles.L.shape[1] and not scene.carried.affine:
        rank.drop_gradients()


def _share_seams(rank: Rank) -> None:
    """Give vertices beyond seams across y and z the velocities of the same ones inside."""
    grid = rank.grid
    for seam in rank.scene.domain.seams:
        inside, beyond = grid.copies(grid.by_vertex(grid.kept.values), seam.axis)
        beyond[..., _VELOCITY] = inside[..., _VELOCITY]


def _joined(rank: Rank, values: np.ndarray) -> np.ndarray:
    """Values at the vertices, summed over both copies of those at seams across y and z."""
    for seam in rank.scene.domain.seams:
        inside, beyond = rank.grid.copies(values, seam.axis)
        inside += beyond
        beyond[:] = inside
    return values


def _sums(rank: Rank, order: Order | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Mass and momentum at a rank's vertices, zero without particles, by plane, field, y, z.

    Of all particles, or of those of an `order`, in the initial configuration.
    """
    scene, grid = rank.scene, rank.grid
    groups = groups_of(rank)
    if order is not None:  # kernels take as many groups as ever
        none = Order(order.rows[:0], np.zeros_like(order.start))
        groups = (*(replace(each, order=none) for each in groups[:-1]),
                  replace(groups[-1], order=order))  # fmt: skip
    sum_particles(
        rank, groups, scene.interaction.loads.at(0.0), bool(scene.interaction.loads.constraints)
    )
    rank.halo.finish(grid)
    records, defined = grid.by_vertex(grid.G), grid.active[:, None] != 0
    if grid.fields:
        defined = defined & (np.asarray(grid.field.used)[:-1] != 0)
    records[~np.broadcast_to(defined, records.shape[:2])] = 0.0
    return records[..., MASS].copy(), records[..., VECTOR].copy()


def keep_masses(rank: Rank) -> None:
    """Sum the masses of vertices that keep their motion; others have none; collective."""
    values = rank.grid.by_vertex(rank.grid.kept.values)
    values[..., KEPT_MASS] = _sums(rank)[0]
    _forget_unreached(rank)
    values[_joined(rank, values[..., KEPT_MASS].copy()) == 0.0] = 0.0
    if rank.slaves:
        _find_slaves(rank)


def _find_slaves(rank: Rank) -> None:
    """Find the vertices that hold next to nothing, and fold their masses; collective."""
    scene, grid, population = rank.scene, rank.grid, rank.population
    particles, order = rank.up_to_date(), population.ordered
    v, rows = particles.v.copy(), order.rows
    particles.v[rows, 0] = particles.V0[rows] / particles.m[rows]  # momentum is then volume
    shape = grid.by_vertex(grid.G).shape[:-1]
    volume, exact = np.zeros(shape), np.zeros(shape, bool)
    masses = np.zeros((len(scene.body_names), shape[0], *shape[2:]))
    for b in np.flatnonzero(scene.settings.lagrangian).tolist():
        mine = particles.body[order.rows] == b
        edges = np.concatenate([[0], np.cumsum(mine)])[order.start]
        mass, momentum = _sums(rank, Order(order.rows[mine], edges))
        field = velocity_field(grid, b)
        masses[b] = _joined(rank, mass)[:, field]
        volume[:, field] += _joined(rank, momentum)[:, field, ..., 0]
        exact[:, field] |= (masses[b] > 0.0) & scene.settings.exact_surfaces[b]
    particles.v[:] = v
    frame = scene.domain.frame
    keys = vertex_keys(grid, shape[1]).transpose(0, 3, 1, 2)
    *place, fields = Vertices.numbers(rank, keys)
    for seam in scene.domain.seams:  # of both copies the one inside counts
        exact &= place[seam.axis] < frame.ghost + frame.cells[seam.axis]
    keys, held = Vertices.joined(rank, place, fields), volume / np.prod(frame.cell)
    if scene.case.axisymmetric:  # whole cells of rings; of those on the axis the mean radius is h/6
        r = frame.origin[0] + (place[0] - frame.ghost) * frame.cell[0]
        held /= 2.0 * np.pi * np.maximum(r, frame.cell[0] / 6.0)
    faces = [
        (
            face.axis,
            frame.ghost + (frame.cells[face.axis] if face.side > 0 else 0),
            face.condition.motion(0.0) is not None,
        )
        for face in scene.domain.faces
        if not face.condition.approaches
    ]
    for axis, number, _ in faces:  # half of what they hold is beyond
        if not (scene.case.axisymmetric and axis == 0 and number == frame.ghost):
            held[place[axis] == number] *= 2.0
    rank.slaves.find(rank, Vertices(rank, keys, held, exact, faces), masses)
    rank.slaves.fold_masses(rank)
    if rank.mean_dilatation:
        rank.mean_dilatation.find(rank)
        rank.outdate_cells()


def _forget_unreached(rank: Rank) -> None:
    """Take mass and motion of vertices that no step reaches; collective.

    Steps go from cells to their corners. Weights of single particles reach further by rounding, to
    vertices that no force ever moves, and whose planes may take part on some ranks only.
    """
    if not rank.scene.by_cells:
        return
    masses, grid, comm = _sums(rank, rank.lattice_cells().off_lattice)[0], rank.grid, rank.comm
    reached, lower, upper = mark_corners(rank), rank.slab.lower, rank.slab.upper
    if lower == comm.rank:
        reached[:1] |= reached[rank.slab.layers :][:1]
    else:  # corners of the last layer's cells belong to the upper neighbour
        sent = None
        if upper is not None:
            sent = comm.isend(reached[rank.slab.layers], upper, _CORNERS)
        if lower is not None:
            reached[0] |= comm.recv(source=lower, tag=_CORNERS)
        if sent is not None:
            sent.wait()
    reached |= masses > 0.0
    values = grid.by_vertex(grid.kept.values)
    values[_joined(rank, reached.astype(float)) == 0.0] = 0.0
    rank.share_motion()


def _coordinates(grid: Grid, periodic: Sequence[bool] = ()) -> list[np.ndarray]:
    """Coordinates of the vertices along each direction, each (planes, 1, y, z).

    Those beyond the seam of a `periodic` direction have the coordinates of the same ones inside.
    """
    frame, window = grid.frame, grid.window
    numbers = np.meshgrid(*map(np.arange, (grid.planes, *window.extent[1:])), indexing="ij")
    found = []
    for d in range(len(frame.cell)):
        number = numbers[d] + window.lower[d] - frame.ghost
        if any(periodic) and periodic[d]:
            number %= frame.cells[d]
        found.append((frame.origin[d] + number * frame.cell[d])[:, None])
    return found


def _exact(rank: Rank) -> np.ndarray:
    """Velocities of the exact solution at the vertices at time 0, (planes, 1, y, z, 3)."""
    scene = rank.scene
    x = np.stack(_coordinates(rank.grid, scene.domain.periodic), axis=-1)
    v = np.zeros((*x.shape[:-1], 3))
    flat = np.zeros((x[..., 0].size, scene.dimension))
    initial_velocities(scene.settings.exact, scene.domain.frame, x.reshape(flat.shape), flat)
    v[..., : scene.dimension] = flat.reshape(x.shape)
    return v


def enter_motion(rank: Rank, before: Grid, slaves: Slaves | None) -> None:
    """Hand the motion over to the grid of a stage; collective.

    What the stage's conditions change of velocities is booked in its first step. Fields that become
    one move at the mean of their momenta. Vertices that removed bodies leave have no motion.

    Parameters
    ----------
    rank : Rank
        The rank in the stage.
    before : Grid
        The grid of the stage before, with the same planes.
    slaves : Slaves or None
        The slaves of the stage before.
    """
    scene = rank.scene
    if scene.settings.lagrangian_bodies is None:
        return
    rank.contact.assign_fields(rank)
    grid = rank.grid
    was, now = before.by_vertex(before.kept.values), grid.by_vertex(grid.kept.values)
    bodies = [
        b
        for b, name in enumerate(scene.body_names)
        if scene.settings.lagrangian[b] and name not in scene.case.staged.removed
    ]
    pairs = {(velocity_field(grid, b), velocity_field(before, b)) for b in bodies}
    if len({new for new, _ in pairs}) == len(pairs):
        for new, old_field in pairs:
            now[:, new] = was[:, old_field]
    else:
        _regroup(rank, bodies, before, was, now)
    keep_masses(rank)  # a resumed run has no room for vertices far from others
    if rank.slaves:
        mine = [new for new, _ in pairs]
        came = {new: old_field for new, old_field in pairs if mine.count(new) == 1}
        hand_momentum_over(rank, slaves, 1 + max(before.fields, default=0), came)
        _share_seams(rank)


def velocity_field(grid: Grid, body: int) -> int:
    """Number of a body's velocity field in a grid."""
    return grid.fields[body] if grid.fields else 0


def _regroup(rank: Rank, bodies: list[int], before: Grid, was: np.ndarray, now: np.ndarray) -> None:
    """Motion of fields whose bodies had different ones: means, weighted with the bodies' masses."""
    population, order = rank.population, rank.population.ordered
    mass = np.zeros(now.shape[:-1])
    for b in bodies:
        mine = rank.up_to_date().body[order.rows] == b
        edges = np.concatenate([[0], np.cumsum(mine)])[order.start]
        population.order, population.start = order.rows[mine], edges
        try:
            own = _sums(rank)[0][:, velocity_field(rank.grid, b)]
        finally:
            population.order, population.start = order.rows, order.start
        new = velocity_field(rank.grid, b)
        mass[:, new] += own
        part = np.divide(own, mass[:, new], out=np.zeros_like(own), where=own > 0.0)
        now[:, new] += part[..., None] * (was[:, velocity_field(before, b)] - now[:, new])


def rehearse_motion(rank: Rank) -> None:
    """Call the kernels that only particles that are asked for need."""
    if rank.scene.by_cells:
        rank.displacement.update()
        find_beyond(rank)
