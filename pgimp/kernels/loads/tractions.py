"""Surface tractions (18): forces on faces of boxes, carried by the particles along the face.

With uniform stress, the particles' internal forces (16) cancel inside the body and leave -sigma
grad(sum_p chi_p) at its surface. A traction is spread over the support of that gradient. With boxes
these are the outermost particles' outer sides, or the ends of these sides where weights are means
over a box's ends. With tents it is the layer in which their sum falls to zero. Where the surface
cuts particles, they are the outer sides of these and of their inner neighbours, in proportion. In
equilibrium it then cancels the internal force at every vertex beyond the surface, however light,
after any motion of the body.

So a particle at the face carries a patch: its initial area is stored, its position relative to the
particle is common to all. Patches move, stretch and turn as the particles of the shape do. Where
sizes follow F they stay exact for stretches along the grid and quarter turns. In between they have
the right second moments, within the particle's own box, beyond which there may be no mass. Points
(mpm) carry the force at their positions.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import class_of, inlined, inner_kernel
from pgimp.jit.vectors.lanes import zeros
from pgimp.jit.vectors.simd import lane, pack, stack
from pgimp.kernels.data.velocity_fields import field_of
from pgimp.kernels.transfer.first_vertex import (
    coordinate,
    deformation,
    first_vertex,
    half_widths,
    is_axial,
)
from pgimp.kernels.transfer.gather import gather_products
from pgimp.kernels.transfer.rings import ring_weights
from pgimp.kernels.transfer.scatter import Share, scatter_products
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, keep_support
from pgimp.kernels.transfer.transfer import Support
from pgimp.physics.shapes.stretch import LARGEST


@inlined
def columns(F):
    """Columns of the deformation gradient as vectors of three; 1 in missing directions."""
    if len(F) == 1:
        return ((F[0], 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    if len(F) == 4:
        return ((F[0], F[2], 0.0), (F[1], F[3], 0.0), (0.0, 0.0, 1.0))
    if len(F) == 5:
        return ((F[0], F[2], 0.0), (F[1], F[3], 0.0), (0.0, 0.0, F[4]))
    return ((F[0], F[3], F[6]), (F[1], F[4], F[7]), (F[2], F[5], F[8]))


@inner_kernel
def patch_force(traction, F, area):
    """Force on a patch: per area, with the area vector J F^-T N A by Nanson's formula."""
    C = columns(F)
    a, b = C[(traction.axis + 1) % 3], C[(traction.axis + 2) % 3]
    A = traction.side * area
    n0 = A * (a[1] * b[2] - a[2] * b[1])
    n1 = A * (a[2] * b[0] - a[0] * b[2])
    n2 = A * (a[0] * b[1] - a[1] * b[0])
    size = sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    t, q = traction.traction, traction.pressure
    return t[0] * size - q * n0, t[1] * size - q * n1, t[2] * size - q * n2


@inner_kernel
def _rounding(tent, half, u):
    """Excess of the mean of abs(u + x), over x in a box or tent about 0, over abs(u)."""
    r = half - abs(u)
    if not r > 0.0:
        return 0.0
    return r * r * r / (3.0 * half * half) if tent else r * r / (2.0 * half)


@inner_kernel
def _mean(ends, tent, half, g):
    """Mean of the tent function of a vertex over a box or tent about g, in cells from the vertex.

    With `ends`, over the two ends of a box. Half-widths may be zero; small means have no
    cancellation.
    """
    if ends:
        return 0.5 * (max(1.0 - abs(g - half), 0.0) + max(1.0 - abs(g + half), 0.0))
    corners = _rounding(tent, half, g - 1.0) + _rounding(tent, half, g + 1.0)
    return max(1.0 - abs(g), 0.0) + 0.5 * corners - _rounding(tent, half, g)


@inlined
def means(ends, tent, half, g, like):
    """Means at vertices 0, 1, ..., as many as in `like`."""
    if len(like) == 1:
        return (_mean(ends, tent, half, g),)
    return (_mean(ends, tent, half, g), *means(ends, tent, half, g - 1.0, like[1:]))


@inner_kernel
def _along(traction, frame, F, x, d, vertex, like):
    """Weights of the support's vertices along direction `d`; the patch stays within the support."""
    D = len(frame.origin)
    centre, deep, wide, own = 0.0, 0.0, 0.0, 0.0
    for j in range(D):
        stretch = F[d * D + j] if traction.follows else (1.0 if j == d else 0.0)
        if j == traction.axis:
            centre = stretch * traction.side * traction.reach
            deep = (stretch * traction.half[j]) ** 2
            own += (stretch * (2.0 if traction.tents else 1.0) * traction.reach) ** 2
        else:
            wide += (stretch * traction.half[j]) ** 2
            own += (stretch * traction.half[j]) ** 2
    own = sqrt(own) * frame.inverse[d]
    if traction.follows and own > LARGEST:  # where chi_p does not grow any more, nor does the patch
        centre *= LARGEST / own
        deep *= (LARGEST / own) ** 2
        wide *= (LARGEST / own) ** 2
        own = LARGEST
    # The larger of the two is a box or tent as given; a tent has half the second moment of a box.
    tent = traction.tents and wide > 2.0 * deep
    if tent:
        deep *= 2.0
    elif traction.tents:
        wide *= 0.5
    last = len(like) - 1.0
    half = min(sqrt(deep + wide) * frame.inverse[d], 0.5 * last)
    position = (x - frame.origin[d]) * frame.inverse[d] - (vertex - frame.ghost)
    g = position + centre * frame.inverse[d]
    if traction.follows and not traction.tents:  # a face that is inclined reaches past the box
        half = min(half, own)
        g = min(max(g, position - own + half), position + own - half)
    return means(traction.ends, tent, half, min(max(g, half), last - half), like)


@inlined
def _support(traction, layout, window, particles, p, layer, F, buffer):
    """Store the weights of the vertices under a patch; returns the first offset.

    `layout` is the shape and the frame.
    """
    (shape, frame), D = layout, len(layout[1].origin)
    like = (0.0,) * class_of(shape).vertices()
    half = half_widths(shape, frame, particles, p)
    x = tuple(coordinate(frame, particles, p, d) for d in range(D))
    first = (layer, *tuple(first_vertex(frame, d, half[d], x[d]) for d in range(1, D)))
    for d in range(D):
        w = _along(traction, frame, F, x[d], d, first[d], like)
        if d == 0 and is_axial(frame) and traction.axis == 1:
            # A plane ring, whose parts weigh with their radius.
            f = (x[0] - frame.origin[0]) * frame.inverse[0] - (layer - frame.ghost)
            w = ring_weights(shape, half[0], f, x[0] * frame.inverse[0])[0]
        keep_support(buffer, d, w, w)
    return sum((first[d] - window.lower[d]) * window.stride[d] for d in range(1, D))


@inner_kernel
def scatter_tractions(tractions, setting, field, particles, rows, span, layer):
    """Add the forces on the patches of a layer's particles, in canonical order, to its own planes.

    A separate loop: in the loop over all particles it would cost registers.

    Parameters
    ----------
    tractions
        tuple of Traction.
    setting, field, particles
        As in `particles_to_grid`.
    rows, span, layer
        As in `sum_layer`, with the layer's number.
    """
    shape, frame, window, scratch = setting.shape, setting.frame, field.window, field.scratch
    buffer = stack(SUPPORT_SIZE)
    zero = pack(0.0, 0.0, 0.0, 0.0)
    nothing = zeros(frame.origin)
    for k in range(span[0], span[1]):
        p = rows[k]
        for t in range(len(tractions)):
            area = particles.patch[p, tractions[t].column]
            if area == 0.0:
                continue
            F = deformation(frame, particles, p)
            f = patch_force(tractions[t], F, area)
            offset = _support(tractions[t], (shape, frame), window, particles, p, layer, F, buffer)
            offset += field_of(window, particles, p)
            force = pack(0.0, f[0], f[1], f[2])
            share = Share(zero, force, nothing, (), (), ())
            scatter_products(shape, scratch, Support(buffer, 0), offset, window.stride, share)


@inner_kernel
def half_step(follows, half):
    """Half of the step, `half`, if a load follows its surface, else 0.

    A load that keeps its direction does the work force times displacement, with the velocity of the
    end. One that turns with a body would so lose work in every step: its velocity is the mean one.
    """
    return half if follows else 0.0


class Booking(NamedTuple):
    """Where a step books the impulses of loads."""

    dt: float  #: Time for which the loads act.
    impulse: np.ndarray  #: (planes, tractions, 3) float64: See `Ledger.traction_impulse`.
    first: int  #: Row of the first load.
    half: float  #: See `half_step`.


@inner_kernel
def book_force(booking, plane, number, f):
    """Add the impulse of a force in a step to the row of its load."""
    own = booking.impulse[plane, booking.first + number]
    for d in range(3):
        own[d] += booking.dt * f[d]


@inner_kernel
def traction_power(tractions, setting, field, particles, rows, span, layer, booking):
    """Power of the tractions on a layer: the patches' forces times the vertices' velocities.

    For the arguments see `scatter_tractions` and `Booking`.
    """
    shape, frame, window, G = setting.shape, setting.frame, field.window, field.G
    start = (layer - window.lower[0]) * window.stride[0]
    buffer = stack(SUPPORT_SIZE)
    power = 0.0
    for k in range(span[0], span[1]):
        p = rows[k]
        for t in range(len(tractions)):
            area = particles.patch[p, tractions[t].column]
            if area == 0.0:
                continue
            F = deformation(frame, particles, p)
            f = patch_force(tractions[t], F, area)
            offset = _support(tractions[t], (shape, frame), window, particles, p, layer, F, buffer)
            offset += field_of(window, particles, p)
            support, at = Support(buffer, 0), start + offset
            like = frame.origin
            U, A = gather_products(shape, G, support, at, window.stride, like, (), ())[:2]
            u = U - half_step(tractions[t].follows, booking.half) * A
            book_force(booking, layer - window.lower[0], t, f)
            power += f[0] * lane(u, 1) + f[1] * lane(u, 2) + f[2] * lane(u, 3)
    return power
