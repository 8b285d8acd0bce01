"""How far surfaces have moved and turned since facets near others were searched for."""

from math import inf, sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.simd import pack, vector
from pgimp.kernels.contact.surfaces.motion import cofactors, placed, square_of


@inlined
def _rigid_shift(rigid_bodies, poses, surface, f):
    """Shift of a facet of a rigid body, a triple."""
    if not is_record(rigid_bodies):
        return 0.0, 0.0, 0.0
    n = surface.body[f] - rigid_bodies.bodies
    now = placed(rigid_bodies.motion[n], surface.x[f])
    before = placed(poses[n], surface.x[f])
    return now[0] - before[0], now[1] - before[1], now[2] - before[2]


@inner_kernel
def _shift(surface, cells, moved, f):
    """Shift of a facet by those of its cell's vertices, a triple."""
    x, y, z = 0.0, 0.0, 0.0
    for corner in range(surface.means.shape[1]):
        v, w = cells.corners[surface.cell[f], corner], surface.means[f, corner]
        x, y, z = x + w * moved[v, 0], y + w * moved[v, 1], z + w * moved[v, 2]
    return x, y, z


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
def _gradient(frame, cells, moved, c):
    """Gradient of a field in the middle of a cell, a triple of columns in lanes."""
    D, columns = len(frame.cell), (vector(0.0), vector(0.0), vector(0.0))
    for corner in range(1 << D):
        x = moved[cells.corners[c, corner]]
        u = pack(x[0], x[1], x[2], 0.0)
        columns = (
            columns[0] + (u if corner >> (D - 1) & 1 else -u),
            columns[1] + (u if D > 1 and corner >> (D - 2) & 1 else -u),
            columns[2] + (u if D > 2 and corner & 1 else -u),
        )
    part = 2.0 / (1 << D)
    return (
        (part * frame.inverse[0]) * columns[0],
        (part * frame.inverse[1] if D > 1 else 0.0) * columns[1],
        (part * frame.inverse[2] if D > 2 else 0.0) * columns[2],
    )


@inner_kernel
def _turn(frame, cells, moved, before, c):
    """Change of a unit vector that turns with the middle of a cell, and of strain as much.

    Both are relative to the cell as it was before.
    """
    G, F, square = _gradient(frame, cells, moved, c), _gradient(frame, cells, before, c), 0.0
    F = (
        F[0] + pack(1.0, 0.0, 0.0, 0.0), F[1] + pack(0.0, 1.0, 0.0, 0.0),
        F[2] + pack(0.0, 0.0, 1.0, 0.0),
    )  # fmt: skip
    K, J = cofactors(F)
    for d in range(3):
        own = K[0][d] * G[0] + (K[1][d] * G[1] + K[2][d] * G[2])
        square += square_of(own)
    return sqrt(0.5 * square) / J if J > 0.0 else inf


@kernel
def find_shifts(frame, surface, cells, clusters, moved, rigid, ends):
    """Set the least shifts of the facets of clusters, and the least reversed ones, in cells.

    After those the greatest change of their normals, reversed: facets may meet as they turn.

    Parameters
    ----------
    clusters : ((m + 1,) int64, (n,) int64)
        First entry of each cluster, and the facets of each.
    moved : (v, 3) float64, (v, 3) float64
        Shifts of the surface vertices, nan where the rank does not know them; and displacements
        when shifts were zero.
    rigid : (RigidBodies, (n,) MOTION) or ((), ())
        The rigid bodies, and their motion when shifts were zero.
    ends : (2, m, D + 1) float64
        inf before; facets are left out whose shifts the rank does not know.
    """
    (first, members), (rigid_bodies, poses), D = clusters, rigid, len(frame.cell)
    shifts, displacements = moved
    for c in range(len(first) - 1):
        before, turn = -1, 0.0
        for n in range(first[c], first[c + 1]):
            f = members[n]
            cell = surface.cell[f]
            if cell >= 0:
                x = _shift(surface, cells, shifts, f)
            else:
                x = _rigid_shift(rigid_bodies, poses, surface, f)
            if x[0] == x[0]:
                if n == first[c] or cell != before:
                    if cell >= 0:
                        turn = _turn(frame, cells, shifts, displacements, cell)
                    else:
                        turn = _rigid_turn(rigid_bodies, poses, surface, f)
                    before = cell
                ends[0, c, D] = min(ends[0, c, D], -turn)
                ends[1, c, D] = ends[0, c, D]
                for d in range(D):
                    way = x[d] * frame.inverse[d]
                    ends[0, c, d] = min(ends[0, c, d], way)
                    ends[1, c, d] = min(ends[1, c, d], -way)


@kernel
def least_left(pairs, left, most, ends) -> float:
    """Cells by which clusters may still move relative to each other before facets may meet anew.

    Parameters
    ----------
    pairs : (k, 2) int64
        Clusters near each other; -1 - d in place of the second is a wall across direction d.
    left : (k,) float64
        Cells by which these might move when shifts were zero.
    most : float
        The same of all other pairs.
    ends : (2, clusters, D + 1) float64
        See `find_shifts`; of turns the cells that they count for, less those that may be.
    """
    least, (_, count, numbers) = most, ends.shape
    for c in range(count):
        for d in range(numbers):
            least = min(least, most + 2.0 * min(ends[0, c, d], ends[1, c, d]))
            if ends[0, c, d] == inf:  # nobody knows
                return -inf
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        for d in range(numbers):
            low, high = 0.0, 0.0
            if b >= 0:
                low, high = ends[0, b, d], -ends[1, b, d]
            elif d != -1 - b and d < numbers - 1:
                continue
            way = max(-ends[1, a, d] - low, high - ends[0, a, d])
            least = min(least, left[k] - way)
    return least
