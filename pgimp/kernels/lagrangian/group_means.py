"""Means over groups of cells: mean dilatation of bodies that are exact to their surface.

See `pgimp.solver.lagrangian.mean_dilatation`. Sums go cell by cell, then from cell to cell in their
order, so that no bit depends on which rank has a cell.
"""

from typing import NamedTuple

from pgimp.jit.kernel import kernel
from pgimp.kernels.data.particles import IntArray


class CellGroups(NamedTuple):
    """Groups of cells, and the particles in them."""

    first: IntArray  #: (groups + 1,) int64: Beginning of each group's cells.
    #: (cells + 1,) int64: Beginning of each cell's particles; cells of other ranks have none.
    start: IntArray
    rows: IntArray  #: (n,) int64: Rows of the particles.


@kernel
def sum_cells(groups, volumes, values, sums):
    """Sum initial volumes, and with these some values, over the particles of each cell.

    Parameters
    ----------
    groups : CellGroups
    volumes : (capacity,) float64
    values : (capacity, k) float64
    sums : (cells, 1 + k) float64
        Set, but for cells without particles here.
    """
    k = values.shape[1]
    for cell in range(len(groups.start) - 1):
        begin, end = groups.start[cell], groups.start[cell + 1]
        if begin == end:
            continue
        for i in range(1 + k):
            sums[cell, i] = 0.0
        for n in range(begin, end):
            row = groups.rows[n]
            V = volumes[row]
            sums[cell, 0] += V
            for i in range(k):
                sums[cell, 1 + i] += V * values[row, i]


@kernel
def set_means(groups, sums, values):
    """Set values of particles to the mean over their group, from `sum_cells`; see there."""
    k = values.shape[1]
    for group in range(len(groups.first) - 1):
        begin, end = groups.first[group], groups.first[group + 1]
        for i in range(k):
            V = total = 0.0
            for cell in range(begin, end):
                V += sums[cell, 0]
                total += sums[cell, 1 + i]
            for n in range(groups.start[begin], groups.start[end]):
                values[groups.rows[n], i] = total / V
