"""Facets where bodies have moved to: centroids, normals, places in deformed cells."""

from math import sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.jit.vectors.simd import lane, pack, vector
from pgimp.kernels.contact.impulses.reference_grid import read_reference_vertices
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD

#: Square of the sine between half-edges, below which these do not tell a facet's normal.
_SHORT = 1e-8


@inner_kernel
def set_polynomial(D, cells, c, u, P):
    """Set the coefficients of the displacement in a cell, by the factors' bits, and its corners'.

    Entry e of the first 2^D rows is the coefficient of the product of the places along the
    directions of its bits, that of z the last. Displacements of the corners are in the others.
    """
    count = 1 << D
    for corner in range(count):
        row = load_row(u, cells.corners[c, corner], 0)
        store_row(P, corner, 0, row)
        store_row(P, count + corner, 0, row)
    for d in range(D):
        bit = 1 << (D - 1 - d)
        for corner in range(count):
            if corner & bit:
                store_row(P, corner, 0, load_row(P, corner, 0) - load_row(P, corner ^ bit, 0))


@inner_kernel
def gradient(frame, P, place):
    """Columns of the deformation gradient at a place in a cell, in lanes, and the displacement."""
    D, p, x = len(frame.cell), load_row(P, 0, 0), place[0]
    first, second, third = vector(0.0), vector(0.0), vector(0.0)
    if D == 1:
        first = load_row(P, 1, 0)
        p = x * first + p
    if D == 2:
        y, both = place[1], load_row(P, 3, 0)
        first = y * both + load_row(P, 2, 0)
        second = x * both + load_row(P, 1, 0)
        p = x * first + (y * load_row(P, 1, 0) + p)
    if D == 3:
        y, z, every = place[1], place[2], load_row(P, 7, 0)
        part, rest = z * every + load_row(P, 6, 0), z * load_row(P, 3, 0) + load_row(P, 2, 0)
        first = y * part + (z * load_row(P, 5, 0) + load_row(P, 4, 0))
        second = x * part + rest
        third = x * (y * every + load_row(P, 5, 0)) + (y * load_row(P, 3, 0) + load_row(P, 1, 0))
        p = x * first + (y * rest + (z * load_row(P, 1, 0) + p))
    return (
        frame.inverse[0] * first + pack(1.0, 0.0, 0.0, 0.0),
        (frame.inverse[1] if D > 1 else 0.0) * second + pack(0.0, 1.0, 0.0, 0.0),
        (frame.inverse[2] if D > 2 else 0.0) * third + pack(0.0, 0.0, 1.0, 0.0),
    ), (lane(p, 0), lane(p, 1), lane(p, 2))


@inner_kernel
def cross(a, b):
    """Cross product of vectors in lanes, a triple."""
    x, y, z = lane(a, 0), lane(a, 1), lane(a, 2)
    u, v, w = lane(b, 0), lane(b, 1), lane(b, 2)
    return y * w - z * v, z * u - x * w, x * v - y * u


@inner_kernel
def cofactors(F):
    """Columns of the cofactors of F, given its columns, and its determinant."""
    a, b, c = cross(F[1], F[2]), cross(F[2], F[0]), cross(F[0], F[1])
    J = lane(F[0], 0) * a[0] + lane(F[0], 1) * a[1] + lane(F[0], 2) * a[2]
    return (a, b, c), J


@inner_kernel
def turned_normal(K, n):
    """Cofactors times a normal, by Nanson's formula: along the current normal; a triple."""
    a, b, c = K
    return (
        n[0] * a[0] + n[1] * b[0] + n[2] * c[0], n[0] * a[1] + n[1] * b[1] + n[2] * c[1],
        n[0] * a[2] + n[1] * b[2] + n[2] * c[2],
    )  # fmt: skip


@inner_kernel
def set_hats(D, hats):
    """Set weights of a cell's vertices, given means of the products of places by their bits."""
    for d in range(D):
        for corner in range(1 << D):
            if not corner >> d & 1:
                hats[corner] -= hats[corner | 1 << d]


@inner_kernel
def set_means(D, place, edges, hats):
    """Set the means of the weights of a cell's vertices over a parallelogram about a place."""
    hats[0] = 1.0
    for d in range(D):
        hats[1 << (D - 1 - d)] = place[d]
    if D == 2:
        hats[3] = place[0] * place[1] + _product(edges, 0, 1)
    if D == 3:
        x, y, z = place[0], place[1], place[2]
        a, b, c = _product(edges, 1, 2), _product(edges, 0, 2), _product(edges, 0, 1)
        hats[3], hats[5], hats[6] = y * z + a, x * z + b, x * y + c
        hats[7] = x * (y * z + a) + y * b + z * c
    set_hats(D, hats)


@inner_kernel
def _product(edges, i, j):
    """Mean of the product of two coordinates over a parallelogram about zero."""
    return (edges[0, i] * edges[0, j] + edges[1, i] * edges[1, j]) / 3.0


@kernel
def find_means(frame, surface, edges):
    """Set the means of the weights of each facet's own cell over it.

    `edges` is scratch, (2, 3) float64.
    """
    for f in range(len(surface.x)):
        if surface.cell[f] < 0:
            continue
        for d in range(3):
            inverse = frame.inverse[d] if d < len(frame.cell) else 0.0
            edges[0, d] = surface.edges[f, 0, d] * inverse
            edges[1, d] = surface.edges[f, 1, d] * inverse
        set_means(len(frame.cell), surface.place[f], edges, surface.means[f])


@inlined
def _move_rigid(rigid_bodies, surface, f):
    """Move a facet of a rigid body."""
    if not is_record(rigid_bodies):
        return None
    row = rigid_bodies.motion[surface.body[f] - rigid_bodies.bodies]
    for d in range(3):
        x, n = row.centre[d], 0.0
        for side in range(2):
            surface.extent[f, side, d] = 0.0
        for k in range(3):
            x += row.rotation[d, k] * (surface.x[f, k] - row.reference[k])
            n += row.rotation[d, k] * surface.normal[f, k]
            for side in range(2):
                surface.extent[f, side, d] += row.rotation[d, k] * surface.edges[f, side, k]
        surface.now[f, d], surface.turned[f, d] = x, n


@inlined
def rigid_position(rigid_bodies, surface, f):
    """Position of a facet of a rigid body, a triple."""
    if not is_record(rigid_bodies):
        return 0.0, 0.0, 0.0
    return placed(rigid_bodies.motion[surface.body[f] - rigid_bodies.bodies], surface.x[f])


@inner_kernel
def placed(row, x):
    """Position of a point of a rigid body, given its motion and initial coordinates; a triple."""
    R, c = row.rotation, row.centre
    r = (x[0] - row.reference[0], x[1] - row.reference[1], x[2] - row.reference[2])
    return (
        c[0] + R[0, 0] * r[0] + R[0, 1] * r[1] + R[0, 2] * r[2],
        c[1] + R[1, 0] * r[0] + R[1, 1] * r[1] + R[1, 2] * r[2],
        c[2] + R[2, 0] * r[0] + R[2, 1] * r[1] + R[2, 2] * r[2],
    )


@kernel
def move_facets(frame, rigid_bodies, surface, cells, u, some, scratch):
    """Set the mean current positions, half-edges and normals of some facets.

    Parameters
    ----------
    u : (vertices, 4) float64
        Displacements of the surface vertices; the last entries are not looked at.
    some : (n,) int64
        The facets.
    scratch : tuple
        See `pgimp.kernels.contact.surfaces.spread.scratch_of`.
    """
    D, P, last = len(frame.cell), scratch[0], -1
    for n in range(len(some)):
        f = some[n]
        c = surface.cell[f]
        if c < 0:
            _move_rigid(rigid_bodies, surface, f)
            continue
        if c != last:
            set_polynomial(D, cells, c, u, P)
            last = c
        way = surface.means[f, 0] * load_row(P, 1 << D, 0)
        for corner in range(1, 1 << D):
            way = surface.means[f, corner] * load_row(P, (1 << D) + corner, 0) + way
        F, _ = gradient(frame, P, surface.place[f])
        _turn(D, surface, f, F)
        surface.now[f, 0] = surface.x[f, 0] + lane(way, 0)
        surface.now[f, 1] = surface.x[f, 1] + lane(way, 1)
        surface.now[f, 2] = surface.x[f, 2] + lane(way, 2)


@inner_kernel
def _turn(D, surface, f, F):
    """Set half-edges and normal of a facet: across its edges, where these are not too short."""
    normal, square, most = (0.0, 0.0, 0.0), 0.0, 1.0
    if D > 1:
        e = surface.edges[f, 0]
        a = e[0] * F[0] + (e[1] * F[1] + e[2] * F[2])
        set_triple(surface.extent[f, 0], a)
        if D == 2:
            normal, most = (lane(a, 1), -lane(a, 0), 0.0), 0.0
        else:
            e = surface.edges[f, 1]
            b = e[0] * F[0] + (e[1] * F[1] + e[2] * F[2])
            set_triple(surface.extent[f, 1], b)
            normal, most = cross(a, b), _SHORT * square_of(a) * square_of(b)
        square = normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2
    if not square > most:
        normal = turned_normal(cofactors(F)[0], surface.normal[f])
        square = normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2
    length = 1.0 / sqrt(square)
    set_triple(surface.turned[f], length * pack(normal[0], normal[1], normal[2], 0.0))


@inner_kernel
def square_of(v):
    """Square of the first three components of a vector in lanes."""
    whole = v * v
    return lane(whole, 0) + lane(whole, 1) + lane(whole, 2)


@inner_kernel
def set_triple(into, v):
    """Store three components."""
    into[0], into[1], into[2] = lane(v, 0), lane(v, 1), lane(v, 2)


@kernel
def read_vertices(holding, field, keys, records, values, u):
    """Copy surface vertices.

    Parameters
    ----------
    holding, field, keys, values
        See `read_reference_vertices`.
    records : (m,) int64
        Numbers of their records.
    u : (m, 4) float64
        Set to their displacements; the last entries mean nothing.
    """
    motion = field.motion.values
    read_reference_vertices(holding, field, keys, values)
    for n in range(len(keys)):
        for d in range(4):
            u[n, d] = motion[records[n] * RECORD + DISPLACEMENT + d]
