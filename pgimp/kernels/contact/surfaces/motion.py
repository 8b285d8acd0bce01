"""Facets where bodies have moved to: centroids, normals, places in deformed cells."""

from math import sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel


@inner_kernel
def hat(D, place, corner):
    """Weight of a cell's vertex at a place in it, also beyond."""
    w = 1.0
    for d in range(D):
        w *= place[d] if corner >> (D - 1 - d) & 1 else 1.0 - place[d]
    return w


@inner_kernel
def set_polynomial(D, cells, c, u, P):
    """Set the coefficients of the displacement in a cell, (2^D, 3), by the factors' bits.

    Entry e is the coefficient of the product of the places along the directions of its bits, see
    `hat`.
    """
    for corner in range(1 << D):
        v = cells.corners[c, corner]
        for i in range(3):
            P[corner, i] = u[v, i]
    for d in range(D):
        bit = 1 << (D - 1 - d)
        for corner in range(1 << D):
            if corner & bit:
                for i in range(3):
                    P[corner, i] -= P[corner ^ bit, i]


@inner_kernel
def deform(frame, P, place, x, F):
    """Add the displacement at a place in a cell to `x`, and set the deformation gradient F."""
    D = len(frame.cell)
    for i in range(3):
        x[i] += P[0, i]
        for j in range(3):
            F[i, j] = 1.0 if i == j else 0.0
    for e in range(1, 1 << D):
        whole = 1.0
        for d in range(D):
            whole *= place[d] if e >> (D - 1 - d) & 1 else 1.0
        for i in range(3):
            x[i] += P[e, i] * whole
        for j in range(D):
            if e >> (D - 1 - j) & 1:
                part = frame.inverse[j]
                for d in range(D):
                    part *= place[d] if d != j and e >> (D - 1 - d) & 1 else 1.0
                for i in range(3):
                    F[i, j] += P[e, i] * part


@inner_kernel
def turned_normal(F, normal):
    """Cofactor of F times a normal, by Nanson's formula: along the current normal; a triple."""
    x, y, z = 0.0, 0.0, 0.0
    for j in range(3):
        a, b, n = (j + 1) % 3, (j + 2) % 3, normal[j]
        x += n * (F[1, a] * F[2, b] - F[1, b] * F[2, a])
        y += n * (F[2, a] * F[0, b] - F[2, b] * F[0, a])
        z += n * (F[0, a] * F[1, b] - F[0, b] * F[1, a])
    return x, y, z


@inner_kernel
def set_means(D, place, edges, hats):
    """Set the means of the weights of a cell's vertices over a parallelogram about a place."""
    for corner in range(1 << D):
        w = hat(D, place, corner)
        for i in range(D):
            for j in range(i + 1, D):
                product = (edges[0, i] * edges[0, j] + edges[1, i] * edges[1, j]) / 3.0
                if (corner >> (D - 1 - i) & 1) != (corner >> (D - 1 - j) & 1):
                    product = -product
                for d in range(D):
                    if d != i and d != j:
                        product *= place[d] if corner >> (D - 1 - d) & 1 else 1.0 - place[d]
                w += product
        hats[corner] = w


@inner_kernel
def set_own_means(frame, surface, f, pieces):
    """Set the means of the weights of a facet's own cell over it, the first of `pieces`."""
    edges = pieces[2][0]
    for d in range(3):
        inverse = frame.inverse[d] if d < len(frame.cell) else 0.0
        edges[0, d] = surface.edges[f, 0, d] * inverse
        edges[1, d] = surface.edges[f, 1, d] * inverse
    set_means(len(frame.cell), surface.place[f], edges, pieces[1][0])


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


@kernel
def move_facets(frame, rigid_bodies, surface, cells, u, some, scratch):
    """Set the mean current positions, half-edges and normals of some facets.

    Parameters
    ----------
    u : (vertices, 3) float64
        Displacements of the surface vertices.
    some : (n,) int64
        The facets.
    scratch : ((3, 3) float64, (2^D, 3) float64, (3,) float64, pieces)
        Scratch; the last as of `spread_weights`.
    """
    D, (F, P, _, pieces), last = len(frame.cell), scratch, -1
    for n in range(len(some)):
        f = some[n]
        c = surface.cell[f]
        if c < 0:
            _move_rigid(rigid_bodies, surface, f)
            continue
        if c != last:
            set_polynomial(D, cells, c, u, P)
            last = c
        deform(frame, P, surface.place[f], surface.now[f], F)
        set_own_means(frame, surface, f, pieces)
        for i in range(3):
            surface.now[f, i] = surface.x[f, i]
            for corner in range(1 << D):
                surface.now[f, i] += pieces[1][0, corner] * u[cells.corners[c, corner], i]
            for side in range(2):
                whole = 0.0
                for j in range(3):
                    whole += F[i, j] * surface.edges[f, side, j]
                surface.extent[f, side, i] = whole
        normal = turned_normal(F, surface.normal[f])
        length = sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        for d in range(3):
            surface.turned[f, d] = normal[d] / length
