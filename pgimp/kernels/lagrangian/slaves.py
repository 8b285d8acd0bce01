"""Forces of vertices that hold next to nothing, and their motion, by their masters'.

See `pgimp.solver.lagrangian.slaves`.
"""

from pgimp.jit.kernel import kernel
from pgimp.kernels.data.record import FORCE, MASS, RECORD


@kernel
def take_vectors(values, size, first, rows, found):
    """Set vectors to those of some records; zero where the rank has none.

    Parameters
    ----------
    values : (records * size,) float64
        Records of vertices.
    size : int
        Numbers of a record.
    first : int
        Entry of a record with the first component.
    rows : (n,) int64
        Numbers of the records; -1 for those of other ranks.
    found : (n, 3) float64
    """
    for n in range(len(rows)):
        for d in range(3):
            found[n, d] = values[rows[n] * size + first + d] if rows[n] >= 0 else 0.0


@kernel
def leave_to_masters(G, mass, slaves, masters):
    """Take forces and masses from slaves, and set the masses that their masters have with them.

    Parameters
    ----------
    G : (records * RECORD,) float64
        Records of the sums.
    mass : (m,) float64
        Masses of the masters.
    slaves, masters : (n,) int64, (m,) int64
        Numbers of their records; -1 for those of other ranks.
    """
    for row in slaves:
        if row >= 0:
            G[row * RECORD + MASS] = 0.0
            for d in range(3):
                G[row * RECORD + FORCE + d] = 0.0
    for m in range(len(masters)):
        if masters[m] >= 0:
            G[masters[m] * RECORD + MASS] = mass[m]


@kernel
def fold_vectors(values, first, vectors, of, weights, masters):
    """Add the vectors of slaves to their masters', in the order of the slaves.

    Parameters
    ----------
    values : (records * RECORD,) float64
        Records of vertices.
    first : int
        Entry of a record with the first component.
    vectors : (n, 3) float64
        The slaves' vectors.
    of, weights : (n, 2^D) int64, (n, 2^D) float64
        Numbers and weights of their masters.
    masters : (m,) int64
        Numbers of the masters' records; -1 for those of other ranks.
    """
    for s in range(len(of)):
        for e in range(of.shape[1]):
            row = masters[of[s, e]]
            if row >= 0:
                for d in range(3):
                    values[row * RECORD + first + d] += weights[s, e] * vectors[s, d]


@kernel
def fold_averages(values, first, forces, lumped, known, of, weights, masters):
    """Add what the averaged mass takes from slaves to their masters', in the order of the slaves.

    Of slaves and masters it is alpha T^T (C - L) T a. Masters have the mass of slaves, so that
    their rows miss alpha sum_s T_si L_s (a_s - a_i).

    Parameters
    ----------
    values, first, of, weights, masters
        As in `fold_vectors`.
    forces : (n, 3) float64
        The forces - alpha (C - L) a at slaves.
    lumped : (n,) float64
        alpha L of the slaves.
    known : (m, 3) float64
        The masters' accelerations.
    """
    for s in range(len(of)):
        for d in range(3):
            mean = 0.0
            for e in range(of.shape[1]):
                mean += weights[s, e] * known[of[s, e], d]
            for e in range(of.shape[1]):
                row = masters[of[s, e]]
                if row >= 0:
                    missing = lumped[s] * (mean - known[of[s, e], d])
                    values[row * RECORD + first + d] += weights[s, e] * (forces[s, d] - missing)


@kernel
def spread_vectors(values, size, first, known, of, weights, slaves):
    """Set vectors at slaves to what their masters' give.

    Parameters
    ----------
    values, size, first
        As in `take_vectors`.
    of, weights
        As in `fold_vectors`.
    known : (m, 3) float64
        The masters' vectors.
    slaves : (n,) int64
        Numbers of the slaves' records; -1 for those of other ranks.
    """
    for s in range(len(of)):
        if slaves[s] < 0:
            continue
        for d in range(3):
            total = 0.0
            for e in range(of.shape[1]):
                total += weights[s, e] * known[of[s, e], d]
            values[slaves[s] * size + first + d] = total
