"""The active part of the grid, for output.

It is summed again from the current particles, as in the next step: the sums of the last step belong
to their former positions. So a frame of the grid belongs to the particles of its time, also at the
start, and after a resume. For bodies in the initial configuration it is the reference grid:
vertices and cells keep their initial positions.

Where the domain is periodic, vertices on its high faces are there as corners of cells, without
mass: what they have is at the low faces.
"""

from typing import NamedTuple

import numpy as np

from pgimp.kernels.data.motion import KEPT_VELOCITY
from pgimp.kernels.data.record import FORCE, MASS, MOMENTUM, RECORD
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.rank import Rank
from pgimp.solver.time.clock import Step
from pgimp.solver.transfers import join_seams, sum_particles
from pgimp.solver.vertices import fold_mirrors, vertex_update
from pgimp.storage.framefile import blocks

_UP, _DOWN = 5, 6
_BLOCK = 1 << 16

#: Corners of a cell in the order of VTK's line, quadrilateral and hexahedron, by dimension.
_CORNERS = (
    ((0, 0, 0), (1, 0, 0)),
    ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)),
    ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
)


class ActiveGrid(NamedTuple):
    """Vertices and cells of a rank, in order of x, y, z; the ranks follow each other."""

    #: (n, 3) float64: Positions of the vertices: all with mass, and corners of the cells.
    position: np.ndarray
    #: mass, momentum, force: (n,), (n, 3), (n, 3) float64: Sums over the particles; the force
    #: includes gravity.
    mass: np.ndarray
    momentum: np.ndarray
    force: np.ndarray
    contact: np.ndarray  #: (n, 3) float64: See `_contact`; zeros where it is not requested.
    #: (c, 2^D) int64: Vertices of the cells that contain centres of particles, numbered over all
    #: ranks.
    cells: np.ndarray
    first: tuple[int, int]  #: Number of the rank's first vertex and cell.
    total: tuple[int, int]  #: Vertices and cells of all ranks.


def active_grid(rank: Rank, time: float, dt: float = 0.0) -> ActiveGrid:
    """Sum the current particles into the grid, and extract its active part; collective.

    Parameters
    ----------
    dt : float
        Length of the step for the forces of contact; 0: without them.
    """
    comm, scene, grid, slab, ends = rank.comm, rank.scene, rank.grid, rank.slab, _ends(rank)
    contacts = rank.contact.at_vertices and dt > 0.0
    if contacts:  # before the first step all bodies share a field
        rank.contact.assign_fields(rank)
    marked = contacts and bool(scene.interaction.loads.constraints)
    sum_particles(rank, groups_of(rank), scene.interaction.loads.at(time), marked)
    rank.halo.finish(grid)
    join_seams(rank, marked)
    D, extent, own = scene.dimension, grid.window.extent, grid.owned + ends[1]
    fields = grid.G.reshape(grid.planes, 1 + max(grid.fields, default=0), *extent[1:], RECORD)
    fields = fields[:own].copy() if any(scene.domain.periodic) else fields[:own]
    fields[grid.active[:own] == 0] = 0.0
    fields[grid.owned :] = 0.0
    if scene.domain.seams:
        fields[fields[..., MASS] < 0.0] = 0.0
    if grid.motion:
        kept, mask = grid.by_vertex(grid.kept.values)[:own], grid.kept.fields
        velocity = kept[:, mask, ..., KEPT_VELOCITY : KEPT_VELOCITY + 3]
        fields[:, mask, ..., MOMENTUM : MOMENTUM + 3] = velocity * fields[:, mask, ..., :1]
    records = fields.sum(axis=1) if fields.shape[1] > 1 else fields[:, 0]

    cells, below = _cells(rank)
    vertices = records[..., MASS] > 0.0
    shown = np.concatenate([below[None], cells])
    for a, b, c in _CORNERS[D - 1]:
        vertices[:, b:, c:] |= shown[1 - a : 1 - a + own, : extent[1] - b, : extent[2] - c]

    counts = np.array(comm.allgather((int(vertices.sum()), int(cells.sum()))))
    first, total = counts[: comm.rank].sum(axis=0), counts.sum(axis=0)
    numbers = np.full((own + 1, *extent[1:]), -1, np.int64)
    numbers[:own][vertices] = first[0] + np.arange(counts[comm.rank, 0])
    lower, upper = None if ends[0] else slab.lower, None if ends[1] else slab.upper
    sent = None if lower is None else comm.isend(numbers[0], lower, _DOWN)
    if upper is not None:
        numbers[own] = comm.recv(source=upper, tag=_DOWN)
    if sent is not None:
        sent.wait()
    i, j, k = np.nonzero(cells)
    corners = [numbers[i + a, j + b, k + c] for a, b, c in _CORNERS[D - 1]]

    found, index = records[vertices], np.nonzero(vertices)
    contact = np.zeros((len(found), 3))
    if contacts:
        contact[: vertices[: grid.owned].sum()] = _contact(rank, time, dt)[vertices[: grid.owned]]
    position = np.zeros((len(found), 3))
    for d in range(D):
        number = index[d] + (grid.window.lower[d] - scene.domain.frame.ghost)
        position[:, d] = scene.domain.frame.origin[d] + number * scene.domain.frame.cell[d]
    mass = found[:, MASS].copy()
    return ActiveGrid(
        position,
        mass,
        found[:, MOMENTUM : MOMENTUM + 3].copy(),
        found[:, FORCE : FORCE + 3] + mass[:, None] * np.array(scene.domain.gravity(time)),
        contact,
        np.stack(corners, axis=1),
        (int(first[0]), int(first[1])),
        (int(total[0]), int(total[1])),
    )


def _contact(rank: Rank, time: float, dt: float) -> np.ndarray:
    """Find the forces of contact at the vertices of a rank's own planes, (planes, y, z, 3).

    As the next step does, of the length `dt`, without booking; collective.
    """
    scene, grid = rank.scene, rank.grid
    t = Step(1, time, dt, time + dt)
    scratch = type(rank.ledger)(*map(np.zeros_like, rank.ledger))
    rank.contact.detect(rank, t, scratch)
    update = vertex_update(rank, t, scene.interaction.loads.at(time), scratch)
    fold_mirrors(rank, update)
    if rank.absorbing:
        rank.absorbing.add_forces(rank, update, find=False)
    if rank.damping and not rank.scene.domain.settling:  # whose forces vanish at rest
        rank.damping.add_forces(rank, update)
    extent = grid.window.extent
    found = np.zeros((grid.owned * extent[1] * extent[2], 3))
    rank.contact.forces(rank, update, found)
    return found.reshape(grid.owned, *extent[1:], 3)


def _cells(rank: Rank) -> tuple[np.ndarray, np.ndarray]:
    """Cells that hold centres of particles, by their lowest vertex; collective.

    Returns
    -------
    cells : (own planes, y, z) bool
        Cells of this rank.
    below : (y, z) bool
        Cells of the last plane of the lower rank.
    """
    grid, slab, own, window = rank.grid, rank.slab, rank.grid.owned, rank.grid.window
    p, order, frame = rank.up_to_date(), rank.population.order, rank.scene.domain.frame
    marks = np.zeros((grid.planes, *window.extent[1:]), bool)
    for begin, end in blocks(len(order), _BLOCK):
        x = rank.scene.weighed(p, order[begin:end])
        index = [np.zeros(len(x), np.int64)] * 3
        for d in range(rank.scene.dimension):
            cell = np.floor((x[:, d] - frame.origin[d]) * frame.inverse[d])
            index[d] = cell.astype(np.int64)
            if d and rank.scene.domain.periodic[d]:
                index[d] %= frame.cells[d]
            index[d] += frame.ghost - window.lower[d]
        marks[tuple(index)] = True
    # A particle of the last layer may be in the next cell, whose vertex the upper rank has. Other
    # layers do not reach beyond, so that the plane before is complete.
    sent, last = None, marks[own - 1 : own + 1].copy()
    if slab.upper == rank.comm.rank:
        marks[0] |= last[1]
    elif slab.upper is not None:
        sent = rank.comm.isend(last, slab.upper, _UP)
    below = np.zeros(window.extent[1:], bool)
    if slab.lower not in (None, rank.comm.rank):
        below, shared = rank.comm.recv(source=slab.lower, tag=_UP)
        marks[0] |= shared
    if sent is not None:
        sent.wait()
    first, end = _ends(rank)
    if first:  # the corners of the cells below are at the other side of the seam
        below = np.zeros_like(below)
    if end:
        marks[own] = False
    return marks[: own + end], below


def _ends(rank: Rank) -> tuple[bool, bool]:
    """Whether a rank has the first and the last layer of a ring."""
    slab, domain = rank.slab, rank.scene.domain
    if domain.ring is None or not slab.layers:
        return False, False
    end = slab.first + slab.layers == domain.ring + domain.ring_layers
    return slab.first == domain.ring, end
