"""Particles to grid: mass and momentum (21, 22) and forces (16, 17, 18), layer by layer.

A vertex sum is defined so that no decomposition can change its bits. The particles of one layer are
summed, in canonical order, from zero into that layer's own planes. Then the layers are added in
increasing order. Uniform gravity (17) is m_v b and needs no sum.

Layers may be computed in another order: layers for which neighbours wait come first, and sums to be
added later are deferred.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.simd import load, pack, store
from pgimp.kernels.data.arguments import KernelScene, Order
from pgimp.kernels.data.used_rows import (
    add_layer,
    clear_plane,
    end_layer,
    is_single,
    use,
    use_layer,
)
from pgimp.kernels.lagrangian.cells import CELL_VERTICES, Cells, add_cells
from pgimp.kernels.lagrangian.keep import begin_with_masses
from pgimp.kernels.lagrangian.part_cells import add_parts
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.step.sum_layer import sum_layer


class SecondGroup(NamedTuple):
    """Particles summed with another setting, into velocity fields of their own."""

    #: setting, loads, order: See `KernelScene`, `Loads`, `Order`; the order has the same layers.
    setting: KernelScene
    loads: Loads
    order: Order


@inlined
def _sum_second_group(second, field, particles, layer, span):
    """Sum the other particles of a layer; `span` is the range of a plane so far, and is widened."""
    if not is_record(second):
        return span
    if isinstance(second, Cells):
        span = add_cells(second, field, particles, layer, span)
        low, high = add_parts(second, field, layer, span)
        use_layer(field, low, high)
        return low, high
    start = second.order.start
    if start[layer] == start[layer + 1]:
        return span
    low, high = sum_layer(
        second.setting, field, particles, second.loads, second.order.rows,
        (start[layer], start[layer + 1]), layer + field.window.lower[0],
    )  # fmt: skip
    if span[1] == 0:
        return low, high
    return min(low, span[0]), max(high, span[1])


@inlined
def _begin_plane(second, field, by_cells_only, i):
    """Begin the sums of plane `i`: from zero, but from known masses where no particle adds any.

    `by_cells_only` says whether cells of the lattice have all of the rank's particles.
    """
    if is_single(field) and isinstance(second, Cells):
        if by_cells_only:
            begin_with_masses(field, i)
        else:
            clear_plane(field, i)
        return
    return clear_plane(field, i)


@inlined
def _reach(second, vertices):
    """Number of planes that the other particles of a layer reach, of shapes with so many."""
    if isinstance(second, Cells):
        return CELL_VERTICES
    return vertices


@kernel
def particles_to_grid(setting, field, particles, quantity, order, runs, second):
    """Sum the particles of some layers of a rank into its planes.

    Parameters
    ----------
    setting, field, particles, order
        See `KernelScene`, `Field`, `Particles`, `Order`.
    quantity : Loads or Quantity
        What is summed: mass, momentum and forces with the loads, or another `Quantity`.
    runs : (k, 3) int64
        Runs of layers to sum, one after the other: first layer, layer after the last one, and
        whether to defer. Deferred are the sums for planes not shared with the upper rank. Only the
        rank's last layers, as many as its shared planes, may be deferred.
    second : SecondGroup, Cells or ()
        Further particles: with another setting, or by cells of the lattice.
    """
    start, window, shared_lower = order.start, field.window, field.shared_lower
    active, scratch, deferred = field.active, field.scratch, field.deferred
    plane = window.stride[0]
    vertices = len(scratch) // plane
    shared = vertices - 1
    layers = len(start) - 1
    kept = shared_lower * (shared_lower + 1) // 2  # first deferred sum of the last layers
    for run in range(len(runs)):
        for layer in range(runs[run, 0], runs[run, 1]):
            low, high, reach = 0, 0, _reach(second, vertices)
            if start[layer] < start[layer + 1]:
                reach = vertices
                low, high = sum_layer(
                    setting, field, particles, quantity, order.rows,
                    (start[layer], start[layer + 1]), layer + window.lower[0],
                )  # fmt: skip
            low, high = _sum_second_group(second, field, particles, layer, (low, high))
            for i in range(vertices):
                target = layer + i
                if target < shared_lower:
                    slot = _slot(layer, shared) + i
                    _defer(scratch, i * plane, deferred, slot * plane, low, high, plane)
                    continue
                if high > 0 and active[target] == 0:
                    active[target] = 1
                    _begin_plane(second, field, start[layers] == 0, target)
                if runs[run, 2] != 0 and target < layers:
                    slot = kept + _slot(layer - layers + shared, shared) + i
                    _defer(scratch, i * plane, deferred, slot * plane, low, high, plane)
                    continue
                if i < reach:
                    add_layer(field, i * plane, target, low, high)
            end_layer(field)


@inner_kernel
def _slot(k, shared):
    """Offset, in planes, of the deferred sums of the k-th of `shared` layers."""
    return k * shared - k * (k - 1) // 2


@inner_kernel
def _defer(scratch, source, deferred, target, low, high, plane):
    """Move a plane of `scratch`, zero outside `low` to `high`, leaving zeros."""
    deferred[target : target + low] = 0.0
    zero = pack(0.0, 0.0, 0.0, 0.0)
    for i in range(low, high, 4):
        store(deferred, target + i, load(scratch, source + i))
        store(scratch, source + i, zero)
    deferred[target + high : target + plane] = 0.0


@kernel
def complete(field, shared, layers, kept, received):
    """Add the deferred sums, and the upper rank's deferred sums, to their planes.

    Both sides of a slab boundary do this after the exchange, and then hold the same bits.

    Parameters
    ----------
    field : Field
        The planes shared with the lower rank hold its sums.
    shared, layers : int
        Number of planes shared at a slab boundary, number of the rank's layers.
    kept : bool
        Whether the last layers have deferred sums in this step.
    received : float64
        The upper rank's deferred sums for the planes shared with it; empty without an upper rank.
    """
    deferred, shared_lower = field.deferred, field.shared_lower
    if shared_lower > 0:
        _add(field, 0, deferred, 0, shared)
    if kept:
        _add(field, layers - shared, deferred, shared_lower * (shared_lower + 1) // 2, shared)
    if len(received) > 0:
        _add(field, layers, received, 0, shared)


@inner_kernel
def _add(field, first, sums, slot, shared):
    """Add deferred sums, from `slot` on, to planes from `first` on, in layer order."""
    G, plane = field.G, field.window.stride[0]
    for i in range(shared):
        use(field, first + i, 0, plane)
    for layer in range(shared):
        for i in range(layer, shared):
            target = (first + i) * plane
            for k in range(0, plane, 4):
                store(G, target + k, load(G, target + k) + load(sums, slot * plane + k))
            slot += 1
