"""Entries of rows of the coupling matrix: weights of a patch, or of what it meets, at vertices."""

from pgimp.jit.kernel import inner_kernel
from pgimp.jit.vectors.lanes import sum_of
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.kernels.contact.surfaces.patches.levels import FACET, NUMBER, WEIGHT
from pgimp.kernels.contact.surfaces.spread import spread_weights


@inner_kernel
def _add_cell(D, cells, c, place, at, seen, coupling):
    """Add to a row the sums over places in a cell, by its vertices; clears the sums.

    `place` are all sums, and the row of these; `at` is as in `add_row`. Returns the number of
    entries.
    """
    (r, used), (sums, m), column, entry = at, place, coupling.column, coupling.entry
    plain, first, count = cells.plain[c], 0, 1 << D
    known = plain and c < len(cells.corners)  # in memory that is at hand
    if not known:
        first, count = cells.start[c], cells.start[c + 1] - cells.start[c]
    for n in range(count):
        w, k = 0.0, first + n
        j = cells.corners[c, n] if known else cells.column[k]
        if plain:
            w = sums[m, n]
        elif D == 3:
            part = load_row(cells.weight, k, 0) * load_row(sums, m, 0)
            part = load_row(cells.weight, k, 4) * load_row(sums, m, 4) + part
            w = sum_of(part)
        else:
            for corner in range(1 << D):
                w += cells.weight[k, corner] * sums[m, corner]
        if w == 0.0:
            continue
        if seen[j, 0] != r:
            if used < len(column):
                seen[j, 0], seen[j, 1], column[used], entry[used, 0] = r, used, j, w
            used += 1
        elif seen[j, 1] < len(column):
            entry[seen[j, 1], 0] += w
    for corner in range(1 << D):
        sums[m, corner] = 0.0
    return used


@inner_kernel
def _add_places(D, sums, m, part, weights, row):
    """Add a part of the weights at a place to the sums of its cell."""
    if D == 3:
        store_row(sums, m, 0, part * load_row(weights, row, 0) + load_row(sums, m, 0))
        store_row(sums, m, 4, part * load_row(weights, row, 4) + load_row(sums, m, 4))
    else:
        for corner in range(1 << D):
            sums[m, corner] += part * weights[row, corner]


@inner_kernel
def add_row(frame, surface, cells, group, own, at, scratch, coupling):
    """Add a row of a patch's own body, or of the other; returns the number of entries.

    `group` are candidates, with those of the patch from `gather`; `at` the number of the row, and
    of entries so far.
    """
    (_, seen, (sums, known), pieces, kept), (every, gathered, numbers, count) = scratch, group
    D, found, m, (r, used) = len(frame.cell), 0, 0, at
    for n in range(count):
        part, f = gathered[WEIGHT, n], numbers[FACET, n]
        if part == 0.0:
            continue
        near, several = every[numbers[NUMBER, n]], 1
        if not own:
            f, several = near.other, near.pieces
            if several == 0:
                several = spread_weights(D, cells, surface.cell[f], near, pieces)
        for k in range(several):
            cell = surface.cell[f]
            if not own:
                cell = kept[0][near.piece + k] if near.pieces > 0 else pieces[0][k]
            if found == 0 or known[m] != cell:
                m = 0
                while m < found and known[m] != cell:
                    m += 1
                if m == len(known):  # many cells: begin anew
                    for each in range(found):
                        place = sums, each
                        used = _add_cell(D, cells, known[each], place, (r, used), seen, coupling)
                    m, found = 0, 0
                if m == found:
                    known[m] = cell
                    found += 1
            if own:
                _add_places(D, sums, m, part, surface.means, f)
            elif near.pieces > 0:
                _add_places(D, sums, m, part, kept[1], near.piece + k)
            else:
                _add_places(D, sums, m, part, pieces[1], k)
    for each in range(found):
        used = _add_cell(D, cells, known[each], (sums, each), (r, used), seen, coupling)
    return used
