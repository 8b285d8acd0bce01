"""Pairs of two ways to meet as one list, in the order of their places, with their vertices."""

from pgimp.jit.kernel import inner_kernel, kernel


@inner_kernel
def _mark_used(joint, marks):
    """Mark the vertices that rows have, by 0; others by -1."""
    _, coupling, (keys, _) = joint
    for n in range(len(keys)):
        marks[n] = -1
    for k in range(coupling.start[len(coupling.answer)]):
        marks[coupling.column[k]] = 0


@inner_kernel
def _copy_vertex(values, n, into, number):
    """Copy a vertex's record."""
    for k in range(values.shape[1]):
        into[number, k] = values[n, k]


@inner_kernel
def _merge_vertices(one, other, marks, into):
    """Merge the used vertices of both, by their keys; sets their numbers; returns how many."""
    (a, first), (b, second), (keys, values) = one[2], other[2], into[2]
    m, n, found = 0, 0, 0
    while True:
        while m < len(a) and marks[0, m] < 0:
            m += 1
        while n < len(b) and marks[1, n] < 0:
            n += 1
        if m >= len(a) and n >= len(b):
            return found
        if n >= len(b) or (m < len(a) and a[m] <= b[n]):
            keys[found] = a[m]
            _copy_vertex(first, m, values, found)
            if n < len(b) and b[n] == a[m]:
                marks[1, n] = found
                n += 1
            marks[0, m] = found
            m += 1
        else:
            keys[found] = b[n]
            _copy_vertex(second, n, values, found)
            marks[1, n] = found
            n += 1
        found += 1


@inner_kernel
def _copy_pair(joint, k, marks, into, at):
    """Copy pair `k`, with its rows; `at` are the numbers of pairs, rows and entries so far."""
    (pairs, coupling, _), (more, rows, _), (n, r, e) = joint, into, at
    more.ends[n], more.states[n] = pairs.ends[k], pairs.states[k]
    for i in range(3):
        for d in range(3):
            more.rigid[n, i, d] = pairs.rigid[k, i, d]
    for side in range(2):
        s = pairs.ends[k].rows[side]
        if s < 0:
            continue
        more.ends[n].rows[side] = r
        for k_entry in range(coupling.start[s], coupling.start[s + 1]):
            rows.column[e] = marks[coupling.column[k_entry]]
            rows.entry[e, 0] = coupling.entry[k_entry, 0]
            e += 1
        for d in range(3):
            rows.answer[r, d] = coupling.answer[s, d]
        r += 1
        rows.start[r] = e
    return n + 1, r, e


@inner_kernel
def _before(one, m, other, n):
    """Whether the place of pair `m` of one is before that of pair `n` of the other, or the same."""
    for d in range(3):
        a, b = one.ends[m].vertex[d], other.ends[n].vertex[d]
        if a != b:
            return a < b
    return True


@kernel
def merge_pairs(one, other, marks, into) -> tuple[int, int, int, int]:
    """Merge the pairs of two ways to meet; returns the numbers of pairs, rows, entries, vertices.

    Parameters
    ----------
    one, other : (ContactPairs, Coupling, ((v,) int64, (v, NUMBERS) float64))
        Pairs by their places, with keys that ascend, and records, of vertices. At equal places
        those of `one` come first.
    marks : (2, room) int64
        Scratch, for the vertices of each.
    into : like `one`
        Filled, with room for both.
    """
    _mark_used(one, marks[0])
    _mark_used(other, marks[1])
    vertices = _merge_vertices(one, other, marks, into)
    m, n, at, into_rows = 0, 0, (0, 0, 0), into[1]
    into_rows.start[0] = 0
    while m < len(one[0].ends) or n < len(other[0].ends):
        first = n >= len(other[0].ends)
        if not first and m < len(one[0].ends):
            first = _before(one[0], m, other[0], n)
        if first:
            at = _copy_pair(one, m, marks[0], into, at)
            m += 1
        else:
            at = _copy_pair(other, n, marks[1], into, at)
            n += 1
    return at[0], at[1], at[2], vertices
