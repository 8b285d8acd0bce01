"""How far surfaces have moved and turned since facets near others were searched for."""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.rows import load_row
from pgimp.jit.vectors.simd import lane, pack, vector
from pgimp.kernels.contact.surfaces.motion import cofactors, placed, turned_normal
from pgimp.kernels.contact.surfaces.nearest import PLANE


@inlined
def _rigid_shift(rigid_bodies, poses, surface, f):
    """Shift of a facet of a rigid body, a triple."""
    if not is_record(rigid_bodies):
        return 0.0, 0.0, 0.0
    n = surface.body[f] - rigid_bodies.bodies
    now = placed(rigid_bodies.motion[n], surface.x[f])
    before = placed(poses[n], surface.x[f])
    return now[0] - before[0], now[1] - before[1], now[2] - before[2]


@inlined
def _rigid_turn(rigid_bodies, poses, surface, f):
    """Greatest change of a unit vector that turns with a rigid body."""
    if not is_record(rigid_bodies):
        return 0.0
    n, square = surface.body[f] - rigid_bodies.bodies, 0.0
    for d in range(3):
        for k in range(3):
            square += (rigid_bodies.motion[n].rotation[d, k] - poses[n].rotation[d, k]) ** 2
    return sqrt(0.5 * square)


@inner_kernel
def _ends(D, cells, c, shifts):
    """Least and greatest shifts of the vertices of a cell, in lanes; nan if any are unknown."""
    low = load_row(shifts, cells.corners[c, 0], 0)
    high, whole = low, low
    for corner in range(1, 1 << D):
        shift = load_row(shifts, cells.corners[c, corner], 0)
        low, high, whole = min(low, shift), max(high, shift), whole + shift
    return low + 0.0 * whole, high + 0.0 * whole


@inner_kernel
def _shift(D, surface, cells, f, shifts):
    """Shift of a facet, in lanes."""
    found = vector(0.0)
    for corner in range(1 << D):
        row = load_row(shifts, cells.corners[surface.cell[f], corner], 0)
        found = surface.means[f, corner] * row + found
    return found


@inner_kernel
def _middle(frame, cells, c, u):
    """Cofactors of the deformation gradient at the middle of a cell, a triple of columns."""
    D, a, b, e = len(frame.cell), vector(0.0), vector(0.0), vector(0.0)
    for corner in range(1 << D):
        row = load_row(u, cells.corners[c, corner], 0)
        a = a + row if corner >> (D - 1) & 1 else a - row
        if D > 1:
            b = b + row if corner >> (D - 2) & 1 else b - row
        if D > 2:
            e = e + row if corner & 1 else e - row
    part = 2.0 / (1 << D)
    return cofactors((
        (part * frame.inverse[0]) * a + pack(1.0, 0.0, 0.0, 0.0),
        (part * frame.inverse[1] if D > 1 else 0.0) * b + pack(0.0, 1.0, 0.0, 0.0),
        (part * frame.inverse[2] if D > 2 else 0.0) * e + pack(0.0, 0.0, 1.0, 0.0),
    ))[0]  # fmt: skip


@inner_kernel
def _turn(K, before, n):
    """Square of the change of a unit normal, given cofactors now and before, and the initial n."""
    a, b = turned_normal(K, n), turned_normal(before, n)
    whole = sqrt((a[0] ** 2 + a[1] ** 2 + a[2] ** 2) * (b[0] ** 2 + b[1] ** 2 + b[2] ** 2))
    cosine = (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / whole
    return max(0.0, 2.0 - 2.0 * cosine)


@kernel
def find_shifts(frame, surface, cells, clusters, moved, rigid, ends):
    """Set the least shifts of the facets of clusters, and the least reversed ones, in cells.

    After those the greatest change of their unit normals, reversed: facets may meet as they turn.
    Of flat faces in 3D they are those of the vertices of their cells.

    Parameters
    ----------
    clusters : ((m + 1,) int64, (n,) int64)
        First entry of each cluster, and the facets of each.
    moved : ((v, 4) float64, (v, 4) float64, (v, 4) float64)
        Displacements of the surface vertices now, nan where the rank does not know them, and
        before, and the difference.
    rigid : (RigidBodies, (n,) MOTION) or ((), ())
        The rigid bodies, and their motion before.
    ends : (2, m, D + 1) float64
        inf before; facets are left out whose shifts the rank does not know.
    """
    (first, members), (rigid_bodies, poses), D = clusters, rigid, len(frame.cell)
    zero, (now, u, shifts) = (0.0, 0.0, 0.0), moved
    for c in range(len(first) - 1):
        last, of, K, before, turn = -1, zero, (zero, zero, zero), (zero, zero, zero), 0.0
        for n in range(first[c], first[c + 1]):
            f = members[n]
            cell, normal = surface.cell[f], surface.normal[f]
            if cell < 0:
                x = _rigid_shift(rigid_bodies, poses, surface, f)
                low = high = pack(x[0], x[1], x[2], 0.0)
                if n == first[c]:
                    turn = _rigid_turn(rigid_bodies, poses, surface, f) ** 2
            else:
                plane = D > 2 and surface.tip[f] & PLANE != 0
                same = cell == last and normal[0] == of[0] and normal[1] == of[1]
                if plane and same and normal[2] == of[2]:
                    continue
                if plane:
                    low, high = _ends(D, cells, cell, shifts)
                else:
                    low = high = _shift(D, surface, cells, f, shifts)
                if not lane(low, 0) == lane(low, 0):
                    continue
                if cell != last:
                    K, before = _middle(frame, cells, cell, now), _middle(frame, cells, cell, u)
                    last = cell
                of = normal[0], normal[1], normal[2]
                turn = max(turn, _turn(K, before, of))
            for d in range(D):
                ends[0, c, d] = min(ends[0, c, d], lane(low, d) * frame.inverse[d])
                ends[1, c, d] = min(ends[1, c, d], -lane(high, d) * frame.inverse[d])
        if ends[0, c, 0] < inf:
            ends[0, c, D] = ends[1, c, D] = -sqrt(turn)


@kernel
def least_left(pairs, left, most, turned, ends) -> float:
    """Cells by which clusters may still move relative to each other before facets may meet anew.

    Parameters
    ----------
    pairs : (k, 2) int64
        Clusters near each other. In place of the second -1 - 2 d is a wall below along direction d,
        and one less a wall above.
    left : (k,) float64
        Cells by which these might move when shifts were zero.
    most : (float, float)
        The same of all other pairs; of turns likewise.
    turned : (float, float)
        What clusters may turn relative to each other and to walls, in cells that this counts for.
    ends : (2, clusters, D + 1) float64
        See `find_shifts`; turns in cells that they count for.
    """
    least, (_, count, numbers) = most[0], ends.shape
    D, near = numbers - 1, most[0] + turned[0] - most[1]
    for c in range(count):
        least = min(least, most[1] + 2.0 * ends[0, c, D])
        for d in range(D):
            least = min(least, most[0] + 2.0 * min(ends[0, c, d], ends[1, c, d]))
            if ends[0, c, d] == inf:  # nobody knows
                return -inf
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        if b < 0:
            way = -ends[(-1 - b) % 2, a, (-1 - b) // 2]
            least = min(least, left[k] - way, turned[1] + ends[0, a, D])
            continue
        for d in range(D):
            way = max(-ends[1, a, d] - ends[0, b, d], -ends[1, b, d] - ends[0, a, d])
            least = min(least, left[k] - way)
        turns = turned[0] + ends[0, a, D] + ends[0, b, D]
        least = min(least, left[k] - near + turns)  # those that are far have to come near first
    return least
