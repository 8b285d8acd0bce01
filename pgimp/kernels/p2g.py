"""Particles to grid: mass and momentum (21, 22) and forces (16, 17, 18), layer by layer.

A vertex sum is defined so that no decomposition can change its bits: the particles of one layer
are summed, in canonical order, from zero into that layer's own planes; then the layers are added
in increasing order. Uniform gravity (17) is m_v b and needs no sum.
"""

from pgimp.kernels.jit import kernel
from pgimp.kernels.layer import sum_layer
from pgimp.kernels.simd import load, pack, store


@kernel
def particles_to_grid(
    shape, frame, window, particles, loads, order, start, scratch, G, active, partial, shared
):
    """Sum all particles of a rank into its planes.

    Parameters
    ----------
    shape, frame, window, particles
        See `pgimp.shapes`, `Frame`, `Window` (its first plane is that of the rank's first layer),
        `Particles`.
    loads : Loads
        See `pgimp.kernels.loads`.
    order : (n,) int32
        Rows of the particles in canonical order.
    start : (layers + 1,) int64
        Where each of the rank's layers begins in `order`.
    scratch : (vertices * plane,) float64
        A layer's own planes; zero on entry and on return.
    G : (planes * plane,) float64
        The window's planes. Only active ones are defined on return.
    active : (planes,) uint8
        Set here: 1 for the planes that layers of this rank add to.
    partial : (shared * (shared + 1) / 2 * plane,) float64
        The separate sums that the first `shared` layers add to the first `shared` planes; layer by
        layer, each from its own plane up.
    shared : int
        Number of planes shared with the rank below; 0 where there is none.
    """
    plane = window.stride[0]
    vertices = len(scratch) // plane
    active[:] = 0
    partial[:] = 0.0
    for layer in range(len(start) - 1):
        if start[layer] == start[layer + 1]:
            continue
        low, high = sum_layer(
            shape, frame, window, particles, loads, order, start[layer], start[layer + 1],
            layer + window.lower[0], scratch,
        )  # fmt: skip
        slot = layer * shared - layer * (layer - 1) // 2
        for i in range(vertices):
            target = layer + i
            if target < shared:
                _flush(scratch, i * plane, partial, (slot + i) * plane, low, high)
                continue
            if active[target] == 0:
                active[target] = 1
                G[target * plane : (target + 1) * plane] = 0.0
            _flush(scratch, i * plane, G, target * plane, low, high)


@kernel
def _flush(scratch, source, G, target, low, high):
    """Add places `low` to `high` of a plane of `scratch` to a plane of `G`, leaving zeros."""
    zero = pack(0.0, 0.0, 0.0, 0.0)
    for i in range(low, high, 4):
        store(G, target + i, load(G, target + i) + load(scratch, source + i))
        store(scratch, source + i, zero)


@kernel
def add_partials(G, first, partial, shared, plane):
    """Add the partial sums of a slab's first layers to the planes from `first` on, in layer order.

    Both sides of a slab boundary do this after the exchange, and then hold the same bits.
    """
    slot = 0
    for layer in range(shared):
        for i in range(layer, shared):
            target = (first + i) * plane
            for k in range(0, plane, 4):
                store(G, target + k, load(G, target + k) + load(partial, slot * plane + k))
            slot += 1
