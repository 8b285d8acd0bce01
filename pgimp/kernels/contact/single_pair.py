"""Contact at vertices where all is simple, as at most: without the states that a sweep needs."""

from math import sqrt

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.sliding import sliding_part
from pgimp.kernels.data.ledger import (
    CONTACT_AREA,
    HEAT,
    IMPULSE,
    LOSS,
    NORMAL_IMPULSE,
    TANGENTIAL_IMPULSE,
)
from pgimp.kernels.data.record import ACCELERATION, MASS, MOMENTUM, VELOCITY
from pgimp.kernels.grid.constraints import is_marked


@inner_kernel
def exchange_alone(contact, forcing, field, plane, n, part, last, ledger):
    """Apply the law at listed vertex `n` of `plane` if that is simple; returns whether it is.

    It is where no surfaces reach each other in the step. Else it is for one pair of bodies, held
    neither by walls nor by constraints. The impulse is that of `pgimp.kernels.contact.law`, and
    `part` of it is booked.
    """
    listed, G = contact.listed, field.G
    vertex = listed.vertices[n]
    if vertex.simple == 0:
        return False
    for pair in range(vertex.first_pair, vertex.first_pair + vertex.pairs):
        row = listed.pairs[pair]
        r, s, N = row.offsets[0], row.offsets[1], row.normal
        if is_marked(forcing.marked, r) or is_marked(forcing.marked, s):
            return False
        by_r, by_s = 1.0 / G[r + MASS], 1.0 / G[s + MASS]
        u, v = (1.0, 1.0) if last else (by_r, by_s)
        w = tuple(v * G[s + VELOCITY + d] - u * G[r + VELOCITY + d] for d in range(3))
        normal = w[0] * N[0] + w[1] * N[1] + w[2] * N[2]
        if normal + row.gap_rate >= 0.0:
            continue
        if vertex.pairs > 1:
            return False
        mobility, answer = by_r + by_s, 1.0 / (by_r + by_s)
        push = -(normal + row.gap_rate) / (N[0] ** 2 + N[1] ** 2 + N[2] ** 2) * answer
        stick = tuple((normal * N[d] - w[d]) * answer for d in range(3))
        length = sqrt(stick[0] ** 2 + stick[1] ** 2 + stick[2] ** 2)
        stress, slip = row.area * forcing.dt, length * mobility
        slides = sliding_part(contact.pairs, row.law - 1, 0.0, push, stress, length, slip)
        J = tuple(push * N[d] + slides * stick[d] for d in range(3))
        _give(G, r, s, J, by_r, by_s, forcing.dt, last)
        if part > 0.0 and plane < field.owned:
            booked, heat, after = ledger.contact[plane, row.law - 1], 0.0, 0.0
            for d in range(3):
                left = w[d] + mobility * J[d]
                heat -= slides * stick[d] * left
                after += left * N[d]
                booked[IMPULSE + d] -= part * J[d]
            booked[NORMAL_IMPULSE] += part * push
            booked[TANGENTIAL_IMPULSE] += part * slides * length
            booked[HEAT] += part * heat
            booked[LOSS] -= part * push * after
            if last:
                booked[CONTACT_AREA] += row.area
    return True


@inner_kernel
def _give(G, r, s, J, by_r, by_s, dt, last):
    """Give the impulse J to the record at `s`, and take it from the record at `r`."""
    rate = 1.0 / dt
    for d in range(3):
        if last:
            a, b = J[d] * by_r, J[d] * by_s
            G[r + VELOCITY + d] -= a
            G[r + ACCELERATION + d] -= a * rate
            G[s + VELOCITY + d] += b
            G[s + ACCELERATION + d] += b * rate
        else:
            G[r + MOMENTUM + d] -= J[d]
            G[s + MOMENTUM + d] += J[d]
