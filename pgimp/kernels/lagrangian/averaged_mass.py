"""Averaged mass of bodies in the initial configuration: waves at their speed.

The lumped mass L makes short waves slow, and the consistent mass C = sum m_p N N^T of the particles
at their initial positions makes them fast. With a part alpha of C - L the leading error cancels:

    M^-1 = L^-1 - alpha L^-1 (C - L) L^-1.

No system is solved for that. Forces f give a = f/L; vertices that are held get the acceleration
that they are made to have; then f <- f - alpha (C - L) a. C never changes, and its rows sum up to
L. So

    alpha ((C - L) a)_i = sum_j alpha C_ij (a_j - a_i):

momentum stays exact, and a uniform acceleration as it is. M^-1 is symmetric, and between L^-1 and
(1 + alpha) L^-1.

Where all cells round a vertex are whole ones of the lattice, the row is a product of three numbers
along each direction. Others are kept, see `pgimp.solver.lagrangian.mass_rows`.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.jit.vectors.simd import bits, lane, load, pack, stack, store, vector
from pgimp.kernels.data.motion import keeps, velocity_before
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.data.record import FORCE, MASS, RECORD
from pgimp.kernels.data.used_rows import next_rows, used_rows
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.grid.conditions import Holding, hold
from pgimp.kernels.grid.constraints import constrained_rate, is_marked
from pgimp.kernels.grid.faces import box_of, face_count
from pgimp.kernels.lagrangian.sums import vertex_count
from pgimp.kernels.transfer.lane_io import LANES, four_rows
from pgimp.kernels.transfer.parts import corner_weights
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, entry, first_offset, supports
from pgimp.physics.shapes.base import by_parts

#: Numbers of a vertex in the array of accelerations: one that is 0, and three components.
NUMBERS = 4

#: Offset of the vector with the force in a vertex's record.
_SECOND = FORCE - 1


class MassRows(NamedTuple):
    """Rows of alpha C at the vertices of a rank's planes, without their diagonal.

    Offsets are within a plane, in float64: of records in `Field.G`, and of accelerations.
    """

    start: IntArray  #: (planes + 1,) int64: Beginning of each plane's rows.
    vertex: IntArray  #: (rows,) int64: Offset of the vertex's record.
    pattern: IntArray  #: (rows,) int64: Number of the row's entries, which others may have too.
    first: IntArray  #: (patterns + 1,) int64: Beginning of each pattern's entries.
    column: IntArray  #: (entries,) int64: Distance of the other vertex's acceleration.
    value: FloatArray  #: (entries,) float64: Entries of alpha C.
    #: tuple of D float: Second differences that whole cells add along each direction, as a part.
    scale: tuple[float, ...]
    #: (planes + 1,) int64: Beginning of each plane's runs of vertices amid whole cells.
    run_start: IntArray
    #: (planes, 2) int64: Range of accelerations that a plane's runs need, in 3D in their rows.
    span: IntArray
    #: (runs, 2) int64: Offsets of the first acceleration and of the end of a run along the last
    #: direction.
    run: IntArray
    mass: FloatArray  #: (runs,) float64: alpha times the vertices' mass.
    reach: int  #: Planes to the farthest that rows need.


class Accelerations(NamedTuple):
    """Accelerations of vertices, and room for what lies between them and forces."""

    values: FloatArray  #: (planes * plane / 2,) float64: See `NUMBERS`.
    first: int  #: Number among these planes of the rank's first one; less than 0 if it is before.
    scratch: FloatArray  #: (faces, 3) float64: For impulses of faces, which are not booked.
    buffer: FloatArray  #: (plane / 2,) float64.


class Links(NamedTuple):
    """Entries of alpha C that do not count, see `pgimp.solver.lagrangian.bearing`."""

    force: IntArray  #: (n,) int64: Offset of the force of a vertex in `Field.G`.
    own: IntArray  #: (n,) int64: Offset of its acceleration.
    other: IntArray  #: (n,) int64: Offset of the other vertex's acceleration.
    value: FloatArray  #: (n,) float64: The entries.


@kernel
def leave_links(field, links, A):
    """Add to forces what `average_forces` has taken by some links.

    `A` are the accelerations.
    """
    for n in range(len(links.force)):
        for d in range(3):
            change = A[links.other[n] + d] - A[links.own[n] + d]
            field.G[links.force[n] + d] += links.value[n] * change


@kernel
def average_forces(frame, field, faces, forcing, accelerations, rows, found, planes):
    """Take alpha (C - L) a from the forces at a rank's vertices.

    First come accelerations with the lumped mass, after all conditions, of the planes `found`; each
    just before the forces of the first of `planes` that needs it.

    Parameters
    ----------
    frame, field, faces, forcing
        As in `update_momentum`, before it.
    accelerations, rows
        Accelerations, MassRows.
    found, planes : (int, int)
        Planes whose accelerations are set, and whose forces are averaged: from the first one up to
        the second.
    """
    ahead = found[0]
    for i in range(planes[0], planes[1]):
        until = min(i + rows.reach + 1, found[1])
        while ahead < until:
            _find_plane(frame, field, faces, forcing, accelerations, ahead)
            ahead += 1
        _average_plane(field, accelerations, rows, i)
    while ahead < found[1]:
        _find_plane(frame, field, faces, forcing, accelerations, ahead)
        ahead += 1


@inner_kernel
def _find_plane(frame, field, faces, forcing, accelerations, i):
    """Find the accelerations of the vertices of plane `i`, see `average_forces`."""
    G, window, plane = field.G, field.window, field.window.stride[0]
    half, size, row = plane // 2, field_size(window), window.stride[1]
    A, own = accelerations.values, (i + accelerations.first) * half
    g = pack(0.0, forcing.gravity[0], forcing.gravity[1], forcing.gravity[2])
    if field.active[i] == 0:
        A[own : own + half] = 0.0
        return
    for f in range(field_count(window)):
        if not keeps(field.motion, f):
            continue
        first, left = f * size, used_rows(field, i, f)
        while left:
            begin, end, left = next_rows(field, left)
            r, behind = i * plane + first + begin * row, i * plane + first + end * row
            while r < behind:
                at = own + (r - i * plane) // 2
                if r + 3 * RECORD < behind:  # a processor divides four at once
                    m = _four_masses(G, r)
                    if bits(m > forcing.mass_cutoff) == 15:
                        inverse = 1.0 / m
                        store(A, at, _scaled(lane(inverse, 0), G, r, g))
                        store(A, at + NUMBERS, _scaled(lane(inverse, 1), G, r + RECORD, g))
                        store(A, at + 2 * NUMBERS, _scaled(lane(inverse, 2), G, r + 2 * RECORD, g))
                        store(A, at + 3 * NUMBERS, _scaled(lane(inverse, 3), G, r + 3 * RECORD, g))
                        r += 4 * RECORD
                        continue
                m, a = G[r + MASS], vector(0.0)
                if m > forcing.mass_cutoff:
                    a = _scaled(1.0 / m, G, r, g)
                store(A, at, a)
                r += RECORD
        holding = Holding(faces, frame, forcing, accelerations.scratch, 0.0)
        for n in range(face_count(faces)):
            j0, j1, k0, k1 = box_of(faces, n, frame, window, i)
            for j in range(j0, j1):
                for k in range(k0, k1):
                    _hold(field, holding, f, (i, j, k), own, A)
        if len(forcing.marked):
            for j in range(window.extent[1]):
                for k in range(window.extent[2]):
                    r = i * plane + first + j * row + k * RECORD
                    if is_marked(forcing.marked, r):
                        _hold(field, holding, f, (i, j, k), own, A)


@inlined
def _scaled(inverse, G, r, g):
    """The force of the record at `r` over a mass, plus g, behind a zero."""
    return pack(0.0, inverse, inverse, inverse) * load(G, r + _SECOND) + g


@inlined
def _four_masses(G, r):
    """Masses of the record at `r` and of the next three."""
    return pack(*tuple(lane(load(G, r + j * RECORD), MASS) for j in range(4)))


@inner_kernel
def _hold(field, holding, f, vertex, own, A):
    """Set the acceleration of a vertex that faces or constraints may hold."""
    G, window, forcing = field.G, field.window, holding.forcing
    i, j, k = vertex
    at = f * field_size(window) + j * window.stride[1] + k * window.stride[2]
    r, dt, g = i * window.stride[0] + at, forcing.dt, forcing.gravity
    if not G[r + MASS] > forcing.mass_cutoff:
        return
    inverse = 1.0 / G[r + MASS]
    b = (
        G[r + FORCE] * inverse + g[0],
        G[r + FORCE + 1] * inverse + g[1],
        G[r + FORCE + 2] * inverse + g[2],
    )
    v = (
        velocity_before(field.motion, True, G, r, 0, inverse) + dt * b[0],
        velocity_before(field.motion, True, G, r, 1, inverse) + dt * b[1],
        velocity_before(field.motion, True, G, r, 2, inverse) + dt * b[2],
    )
    number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
    _, b = hold(holding, number, r, v, b, 0.0)
    b = constrained_rate(forcing.marked, r, b)
    store(A, own + at // 2, pack(0.0, b[0], b[1], b[2]))


@inner_kernel
def _average_plane(field, accelerations, rows, i):
    """See `average_forces`, for plane `i`."""
    G, plane, A = field.G, field.window.stride[0], accelerations.values
    if field.active[i] == 0:
        return
    own, to = (i + accelerations.first) * (plane // 2), i * plane + _SECOND
    if rows.run_start[i] < rows.run_start[i + 1]:
        _average_runs(field, A, rows, i, own, accelerations.buffer)
    for n in range(rows.start[i], rows.start[i + 1]):
        at = own + rows.vertex[n] // 2
        a, even, odd = load(A, at), vector(0.0), vector(0.0)
        begin, end = rows.first[rows.pattern[n]], rows.first[rows.pattern[n] + 1]
        column, value = rows.column[begin:end], rows.value[begin:end]
        pairs = (end - begin) // 2
        for e in range(pairs):
            even = even + value[2 * e] * (load(A, at + column[2 * e]) - a)
            odd = odd + value[2 * e + 1] * (load(A, at + column[2 * e + 1]) - a)
        if begin + 2 * pairs < end:
            even = even + value[2 * pairs] * (load(A, at + column[2 * pairs]) - a)
        r = to + rows.vertex[n]
        store(G, r, load(G, r) - (even + odd))


@inlined
def _average(scale, before, now, after):
    """A value with a part of its second difference; exactly itself if all three are equal."""
    return now + scale * ((before + after) - 2.0 * now)


@inlined
def _average_runs(field, A, rows, i, own, buffer):
    """As `average_forces`, for the vertices of plane `i` amid whole cells."""
    if len(rows.scale) == 2:
        return _average_lines(field, A, rows, i, own, buffer)
    return _average_areas(field, A, rows, i, own, buffer)


@inner_kernel
def _average_lines(field, A, rows, i, own, buffer):
    """See `_average_runs`, in 2D. The buffer has averages across planes."""
    G, plane = field.G, field.window.stride[0]
    half, to, low = plane // 2, i * plane + _SECOND, rows.span[i, 0]
    for k in range(low, rows.span[i, 1], NUMBERS):
        store(buffer, k - low, _across(A, own + k, half, rows.scale[0]))
    for n in range(rows.run_start[i], rows.run_start[i + 1]):
        begin, end, mass = rows.run[n, 0], rows.run[n, 1], rows.mass[n]
        before, now = load(buffer, begin - low - NUMBERS), load(buffer, begin - low)
        for at in range(begin, end, NUMBERS):
            after = load(buffer, at - low + NUMBERS)
            change = _average(rows.scale[1], before, now, after) - load(A, own + at)
            r = to + 2 * at
            store(G, r, load(G, r) - mass * change)
            before, now = now, after


@inlined
def _across(A, at, step, scale):
    """Average of vectors `step` apart, with the one at `at` in the middle."""
    return _average(scale, load(A, at - step), load(A, at), load(A, at + step))


@inner_kernel
def _average_areas(field, A, rows, i, own, buffer):
    """See `_average_runs`, in 3D.

    The buffer has averages across planes of three rows: of the runs' row and of those beside it.
    """
    G, plane, row = field.G, field.window.stride[0], field.window.stride[1] // 2
    half, scale, to = plane // 2, rows.scale, i * plane + _SECOND
    low, high, ahead = rows.span[i, 0], rows.span[i, 1], 0
    for n in range(rows.run_start[i], rows.run_start[i + 1]):
        begin, end, mass = rows.run[n, 0], rows.run[n, 1], rows.mass[n]
        y = begin // row
        ahead = max(ahead, y - 1)
        while ahead < y + 2:
            at = ahead * row
            for k in range(low, high, NUMBERS):
                store(buffer, ahead % 3 * row + k, _across(A, own + at + k, half, scale[0]))
            ahead += 1
        k, behind = begin - y * row, end - y * row
        b, c, d = (y - 1) % 3 * row + k, y % 3 * row + k, (y + 1) % 3 * row + k
        before = _along_y(buffer, b, c, d, -NUMBERS, scale[1])
        now = _along_y(buffer, b, c, d, 0, scale[1])
        for at in range(0, behind - k, NUMBERS):
            after = _along_y(buffer, b, c, d, at + NUMBERS, scale[1])
            change = _average(scale[2], before, now, after) - load(A, own + begin + at)
            r = to + 2 * (begin + at)
            store(G, r, load(G, r) - mass * change)
            before, now = now, after


@inlined
def _along_y(buffer, before, now, after, k, scale):
    """Average of vectors of three rows, which begin there, at `k`."""
    return _average(scale, load(buffer, before + k), load(buffer, now + k), load(buffer, after + k))


@kernel
def find_weights(setting, window, particles, order, first, weights):
    """Find the weights of some particles at their initial positions.

    Parameters
    ----------
    setting, window, particles, order
        See `KernelScene`, `Window`, `Particles`, `Order`.
    first : (n,) int64
        Set to the offset of the first vertex's record in its plane.
    weights : (n, D, 4) float64, or (n, 2^D) float64
        Set to the weights along each direction; zeros stay where a support has fewer vertices. Of
        parts of cells those of the cell's corners, the last direction innermost.
    """
    shape, frame, start = setting.shape, setting.frame, order.start
    D, buffer = len(setting.frame.origin), stack(SUPPORT_SIZE)
    vertices = vertex_count(shape)
    for layer in range(len(start) - 1):
        for k in range(start[layer], start[layer + 1], LANES):
            four = four_rows(order.rows, k, start[layer + 1])
            supports(shape, frame, window, particles, four, layer + window.lower[0], buffer, ())
            for j in range(min(LANES, start[layer + 1] - k)):
                first[k + j] = first_offset(buffer, j)
                if by_parts(shape):
                    for n in range(2**D):
                        corner = tuple(n >> (D - 1 - d) & 1 for d in range(D))
                        weights[k + j, n] = corner_weights(buffer, j, corner)[0]
                    continue
                for d in range(D):
                    for i in range(vertices):
                        weights[k + j, d, i] = entry(buffer, d, 0, i, j)
