"""Bodies in the initial configuration where they are now: what meets at the vertices of the grid.

Their own grid is that of the start, and knows no neighbour. Where they come near each other, a
rigid body or a wall that lets go, the particles there are summed once more, at their present
places, into the vertices of the domain's grid: part filled, surface, and gap follow as they do in
the current configuration (`pgimp.kernels.contact`). What an impulse at such a vertex does is in
`pgimp.kernels.accumulated`.

A vertex has a number for each *group* of bodies that are bonded; those of all vertices with mass
are found by a table of hashes, so that nothing depends on how far things that meet are apart.
"""

import numpy as np

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inner_kernel, kernel, specialise
from pgimp.jit.tuples import read
from pgimp.kernels.fields import field_of
from pgimp.kernels.holding import Holding, held_velocity
from pgimp.kernels.place import deformation, first_vertex
from pgimp.kernels.record import MASS, RECORD, VELOCITY
from pgimp.physics.shapes.base import size, weights

#: Columns of a particle near a meeting: where it is and was at the start, mass, volume, how far the
#: volume's centroid is off, what curvature adds, whether it is cut, body, group, field.
PLACE, START, WEIGHS, VOLUME, OFFSET, BENT, CUT, BODY, GROUP, FIELD = (
    0, 3, 6, 7, 8, 11, 12, 13, 14, 15,
)  # fmt: skip
NEAR = 16

#: Columns of a vertex of the grid of the start: mass, velocity, inverse of mass by component, which
#: is 0 where a face or a constraint holds it.
INERTIA, MOVES, YIELDS, STARTED = 0, 1, 4, 7

#: Columns of what a group has at a vertex: mass, volume, surface, what S is more where the volume
#: is, what curvature adds and the number it is the mean of, body.
HEAVY, FILLS, FACES, MORE, CURVED, OF_CUT, WHOSE, SUMMED = 0, 1, 2, 5, 6, 7, 8, 9


@kernel
def take_near(frame, particles, rows, groups, fields, table):
    """Copy what is known of particles near a meeting, (n, NEAR) float64, in canonical order."""
    for i in range(len(rows)):
        p, row = rows[i], table[i]
        row[:] = 0.0
        F = deformation(frame, particles, p)
        own, x = read(particles.offset, p, 0, frame.origin), read(particles.x, p, 0, frame.origin)
        X, D = read(particles.origin, p, 0, frame.origin), len(frame.origin)
        for d in range(D):
            row[PLACE + d], row[START + d] = x[d], X[d]
            for e in range(D):
                row[OFFSET + d] += F[D * d + e] * own[e]
            if own[d] != 0.0:
                row[CUT] = 1.0
        body = particles.body[p]
        row[WEIGHS], row[VOLUME] = particles.m[p], particles.V0[p] * determinant(F)
        row[BENT], row[BODY] = particles.excess[p, 0], body
        row[GROUP], row[FIELD] = groups[body], fields[body]


def _keep(out, i, values):
    """Set `out[i]`, `out[i + 1]`, ... to a tuple of numbers."""


@specialise(_keep)
def _keep_all(out, i, values):
    if len(values) == 0:
        return lambda out, i, values: None

    def keep(out, i, values):
        out[i] = values[0]
        _keep(out, i + 1, values[1:])

    return keep


def _support(shape, frame, identity, x, base, w, g, d, like):
    """Set first vertex, weights and gradients along the directions from `d` on."""


@specialise(_support)
def _support_along(shape, frame, identity, x, base, w, g, d, like):
    if len(like) == 0:
        return lambda shape, frame, identity, x, base, w, g, d, like: None

    def along(shape, frame, identity, x, base, w, g, d, like):
        half = size(shape, frame.cell, identity)[0]
        first = first_vertex(frame, d, half[d], x[d])
        f = (x[d] - frame.origin[d]) * frame.inverse[d] - (first - frame.ghost)
        values, slopes = weights(shape, half[d], f)
        base[d] = first
        _keep(w[d], 0, values)
        _keep(g[d], 0, slopes)
        _support(shape, frame, identity, x, base, w, g, d + 1, like[1:])

    return along


@kernel
def find_supports(shape, frame, identity, table, first, base, w, g):
    """Find the supports of particles whose places stand in `table` from column `first` on.

    Parameters
    ----------
    base : (n, 3) int64
        Set to the first vertices.
    w, g : (n, 3, 4) float64
        Set to weights and gradients times the cell; along directions that the scene does not have
        there is one vertex.
    """
    for i in range(len(table)):
        base[i, :] = 0
        w[i, :, :] = 0.0
        g[i, :, :] = 0.0
        w[i, :, 0] = 1.0
        _support(
            shape, frame, identity, table[i, first : first + 3], base[i], w[i], g[i], 0,
            frame.origin,
        )  # fmt: skip


@inner_kernel
def slot(hashes, key):
    """Place of a key, or of the hole where it belongs, in a table of a power of two of places."""
    mask, mixed = len(hashes) - 1, key * 0x9E3779B97F4A7C1
    at = (mixed ^ (mixed >> 31)) & mask
    while hashes[at, 0] != key and hashes[at, 0] >= 0:
        at = (at + 1) & mask
    return at


@inner_kernel
def _across(frame):
    """Number of vertices along y and z."""
    y, z, more = 1, 1, 1 + 2 * frame.ghost
    for d in range(len(frame.cell)):
        y, z = frame.cells[d] + more if d == 1 else y, frame.cells[d] + more if d == 2 else z
    return y, z


@kernel
def take_vertices(faces, forcing, frame, vertices, field, particles, rows, base, w, seen, step,
                  unbooked, keys, values):  # fmt: skip
    """Copy what is known of the vertices of the grid of the start that particles have weight on.

    Parameters
    ----------
    faces, forcing
        Those that hold vertices, after the update of momentum.
    vertices : int
        Vertices a direction in a support.
    rows, base, w
        The particles, and their supports at the start.
    seen : (planes * plane / 8,) int64
        The step in which a vertex has been copied last.
    keys : (m,) int64
        Set to the numbers of the vertices, and of their fields.
    values : (m, STARTED) float64
        Set to what is known of them.

    Returns
    -------
    int
        How many there are.
    """
    window, G, found, D = field.window, field.G, 0, len(frame.origin)
    holding = Holding(faces, frame, forcing, unbooked)
    count = window.stride[0] // (RECORD * window.extent[1] * window.extent[2])
    ny, nz = _across(frame)
    my, mz = (vertices if D > 1 else 1), (vertices if D > 2 else 1)
    for i in range(len(rows)):
        begin = field_of(window, particles, rows[i])
        one = begin // (RECORD * window.extent[1] * window.extent[2])
        for a in range(vertices):
            for b in range(my):
                for c in range(mz):
                    if w[i, 0, a] == 0.0 or w[i, 1, b] == 0.0 or w[i, 2, c] == 0.0:
                        continue
                    x, y, z = base[i, 0] + a, base[i, 1] + b, base[i, 2] + c
                    r = begin + (x - window.lower[0]) * window.stride[0]
                    r += (y - window.lower[1]) * window.stride[1]
                    r += (z - window.lower[2]) * window.stride[2]
                    if seen[r // RECORD] == step:
                        continue
                    seen[r // RECORD] = step
                    m, row = G[r + MASS], values[found]
                    keys[found] = ((x * ny + y) * nz + z) * count + one
                    v = (G[r + VELOCITY], G[r + VELOCITY + 1], G[r + VELOCITY + 2])
                    row[INERTIA] = m
                    u = held_velocity(holding, (x, y, z), r, v, True)
                    for d in range(3):
                        row[MOVES + d], row[YIELDS + d] = v[d], 0.0
                        if d < D and m > forcing.lightest:
                            pushed = (
                                v[0] + (1.0 if d == 0 else 0.0), v[1] + (1.0 if d == 1 else 0.0),
                                v[2] + (1.0 if d == 2 else 0.0),
                            )  # fmt: skip
                            s = held_velocity(holding, (x, y, z), r, pushed, True)
                            row[YIELDS + d] = 0.0 if s[d] == u[d] else 1.0 / m
                    found += 1
    return found


@kernel
def number_vertices(keys, hashes):
    """Put the places of `keys` into a table of hashes: of those that are there twice, the first."""
    for i in range(len(keys)):
        at = slot(hashes, keys[i])
        if hashes[at, 0] < 0:
            hashes[at, 0], hashes[at, 1] = keys[i], i


@kernel
def find_starts(base, w, fields, frame, vertices, count, hashes, at):
    """Find the number of each vertex of supports at the start, (n, vertices^D) int64; -1: none."""
    D = len(frame.origin)
    ny, nz = _across(frame)
    my, mz = (vertices if D > 1 else 1), (vertices if D > 2 else 1)
    for i in range(len(base)):
        q = 0
        for a in range(vertices):
            for b in range(my):
                for c in range(mz):
                    at[i, q] = -1
                    if w[i, 0, a] != 0.0 and w[i, 1, b] != 0.0 and w[i, 2, c] != 0.0:
                        x, y, z = base[i, 0] + a, base[i, 1] + b, base[i, 2] + c
                        key = ((x * ny + y) * nz + z) * count + int(fields[i])
                        at[i, q] = hashes[slot(hashes, key), 1]
                    q += 1


@kernel
def sum_present(frame, vertices, table, base, w, g, low, extent, groups, hashes, at, keys, sums):
    """Sum particles into the vertices at their present places, by group.

    Parameters
    ----------
    low, extent : (int, int, int)
        The least vertex, and how many there may be from it on, by direction.
    at : (n, vertices^D) int64
        Set to the number of each vertex and group in `keys` and `sums`; -1 without weight.
    keys : (m,) int64
        Set to what tells them apart; in the order of x, y, z, group if sorted.
    sums : (m, SUMMED) float64
        Set to the sums.

    Returns
    -------
    int
        How many there are.
    """
    found, D = 0, len(frame.origin)
    my, mz = (vertices if D > 1 else 1), (vertices if D > 2 else 1)
    for i in range(len(table)):
        row, q = table[i], 0
        for a in range(vertices):
            for b in range(my):
                for c in range(mz):
                    S = w[i, 0, a] * w[i, 1, b] * w[i, 2, c]
                    at[i, q] = -1
                    if S != 0.0:
                        x, y, z = base[i, 0] + a, base[i, 1] + b, base[i, 2] + c
                        key = (x - low[0]) * extent[1] + y - low[1]
                        key = (key * extent[2] + z - low[2]) * groups + int(row[GROUP])
                        s = slot(hashes, key)
                        if hashes[s, 0] < 0:
                            hashes[s, 0], hashes[s, 1] = key, found
                            keys[found] = key
                            sums[found, :] = 0.0
                            sums[found, WHOSE] = row[BODY]
                            found += 1
                        n = hashes[s, 1]
                        at[i, q] = n
                        one = sums[n]
                        one[HEAVY] += row[WEIGHS] * S
                        one[FILLS] += row[VOLUME] * S
                        one[CURVED] += row[BENT] * S
                        one[OF_CUT] += row[CUT] * S
                        for d in range(D):
                            slope = g[i, 0, a] if d == 0 else w[i, 0, a]
                            slope *= g[i, 1, b] if d == 1 else w[i, 1, b]
                            slope *= g[i, 2, c] if d == 2 else w[i, 2, c]
                            slope *= frame.inverse[d] * row[VOLUME]
                            one[FACES + d] += slope
                            one[MORE] += slope * row[OFFSET + d]
                    q += 1
    return found


@kernel
def give_to_start(frame, field, keys, changes, dt):
    """Change velocities and accelerations of the vertices of the start that a rank has.

    Parameters
    ----------
    keys : (m,) int64
        As of `take_vertices`, from all ranks.
    changes : (m, 3) float64
        Of their velocities.
    """
    window, G, active = field.window, field.G, field.active
    size = RECORD * window.extent[1] * window.extent[2]
    count = window.stride[0] // size
    ny, nz = _across(frame)
    for n in range(len(keys)):
        rest, one = keys[n] // count, keys[n] % count
        z = rest % nz - window.lower[2]
        y = rest // nz % ny - window.lower[1]
        x = rest // (nz * ny) - window.lower[0]
        if x < 0 or x >= len(active) or y < 0 or y >= window.extent[1]:
            continue
        if z < 0 or z >= window.extent[2] or active[x] == 0:
            continue
        r = x * window.stride[0] + one * size + y * window.stride[1] + z * window.stride[2]
        for d in range(3):
            G[r + VELOCITY + d] += changes[n, d]
            G[r + VELOCITY + 4 + d] += changes[n, d] / dt


def room_for(count: int) -> np.ndarray:
    """Make an empty table of hashes for so many keys."""
    return np.full((1 << max(4, int(2 * count).bit_length()), 2), -1, np.int64)
