"""Matrices of the particles of some lattice cells, for eight particles at a time.

A material's stress is a long chain of operations, each of which waits for the one before. So the
deformation gradients of several cells come first, then the stresses of all in their place, then the
forces: a processor then works at the next particles while it waits.
"""

from pgimp.jit.kernel import inlined
from pgimp.jit.vectors.simd import halves, join, load, stack, store
from pgimp.kernels.lagrangian.cell_derivatives import CellSizes, sizes_of

#: Groups of four particles that are worked at together, or those of two cells.
_TOGETHER = 16


@inlined
def groups_of(sizes: CellSizes) -> int:
    """Groups of four particles of a cell."""
    return sizes.slices * sizes.groups


@inlined
def most_together(sizes: CellSizes) -> int:
    """Greatest number of cells that are worked at together."""
    return max(2, _TOGETHER // groups_of(sizes))


@inlined
def matrices(cells):
    """Buffer for the matrices of the particles of `most_together` cells."""
    sizes = sizes_of(cells)
    pairs = (groups_of(sizes) * most_together(sizes) + 1) // 2
    size = 8 * sizes.dimension**2 * pairs
    return stack(size)


@inlined
def keep_four(buffer, group, F):
    """Store the row-major matrices of group number `group`."""
    size = 8 * len(F)
    return _keep(buffer, group // 2 * size + 4 * (group % 2), F)


@inlined
def _keep(buffer, at, F):
    """Store the vectors `F`, of four particles, in every other place from `at` on."""
    if len(F):
        store(buffer, at, F[0])
        _keep(buffer, at + 8, F[1:])


@inlined
def of_four(cells, buffer, group):
    """The matrices of group number `group`."""
    like = (0.0,) * sizes_of(cells).dimension ** 2
    size = 8 * len(like)
    return _take(buffer, group // 2 * size + 4 * (group % 2), like)


@inlined
def _take(buffer, at, like):
    """The vectors of four particles in every other place from `at` on."""
    if len(like) == 0:
        return ()
    return (load(buffer, at), *_take(buffer, at + 8, like[1:]))


@inlined
def of_eight(cells, buffer, pair):
    """The matrices of groups 2 `pair` and the next."""
    like = (0.0,) * sizes_of(cells).dimension ** 2
    size = 8 * len(like)
    return _take_both(buffer, size * pair, like)


@inlined
def _take_both(buffer, at, like):
    """The vectors of eight particles from `at` on."""
    if len(like) == 0:
        return ()
    return (join(load(buffer, at), load(buffer, at + 4)), *_take_both(buffer, at + 8, like[1:]))


@inlined
def keep_eight(buffer, pair, P):
    """Store the matrices of groups 2 `pair` and the next."""
    size = 8 * len(P)
    return _keep_both(buffer, size * pair, P)


@inlined
def _keep_both(buffer, at, P):
    """Store the vectors of eight particles from `at` on."""
    if len(P):
        low, high = halves(P[0])
        store(buffer, at, low)
        store(buffer, at + 4, high)
        _keep_both(buffer, at + 8, P[1:])
