"""Prescribed motion of a part of a body (``constraints``): grips that hold particles and vertices.

Particles that a constraint holds move exactly as it says. Each marks the vertices that it reaches;
these are held too, so that the material moves with the particles where it touches them, and does
not tear from them sooner than need be. A grip therefore acts up to a vertex near the region's edge:
exactly there where the edge is a plane of vertices, else up to a cell further, and it jumps from
vertex to vertex as it moves. What one rank marks in the planes it shares with another is united by
``or``, so that no order can matter.
"""

from typing import NamedTuple

from pgimp.kernels.batch import LANES, ROOM, entry, extent, first_place, four, supports
from pgimp.kernels.jit import kernel, specialise
from pgimp.kernels.simd import lane, stack, with_lane
from pgimp.kernels.transfer import RECORD

#: Least weight along a direction of a vertex that a held particle reaches; less is rounding.
FIRM = 1e-9


class Grip(NamedTuple):
    """A constraint during one step: components held, velocity at its end, change over it by dt."""

    held: tuple[bool, bool, bool]
    velocity: tuple[float, float, float]
    rate: tuple[float, float, float]


def _mark(shape, mask, bit, place, room, j, d, stride, like):
    """Set a bit at the vertices that a particle reaches; as many directions as `like` has."""


@specialise(_mark)
def _mark_along(shape, mask, bit, place, room, j, d, stride, like):
    if len(like) == 0:

        def vertex(shape, mask, bit, place, room, j, d, stride, like):
            mask[place // RECORD] |= bit

        return vertex

    def line(shape, mask, bit, place, room, j, d, stride, like):
        for i in range(extent(shape, room, d, j)):
            if entry(room, d, 0, i, j) >= FIRM:
                at = place + i * stride[0]
                _mark(shape, mask, bit, at, room, j, d + 1, stride[1:], like[1:])

    return line


@kernel
def mark(shape, frame, window, particles, order, start, mask):
    """Mark the vertices that the constraints' particles hold.

    Parameters
    ----------
    shape, frame, window, particles, order, start
        As in `particles_to_grid`.
    mask : (planes * plane / 8,) int64
        Set here: bit k of a vertex says that constraint k holds it.
    """
    mask[:] = 0
    room = stack(ROOM)
    for layer in range(len(start) - 1):
        number = layer + window.lower[0]
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four(order, k, start[layer + 1])
            held = False
            for p in rows:
                held = held or particles.grip[p, 0] > 0
            if not held:
                continue
            supports(shape, frame, window, particles, rows, number, room, ())
            for j in range(min(LANES, start[layer + 1] - k)):
                grip = particles.grip[order[k + j], 0]
                if grip > 0:
                    place = first_place(room, j) + layer * window.stride[0]
                    bit = 1 << (grip - 1)
                    _mark(shape, mask, bit, place, room, j, 0, window.stride, frame.origin)


@kernel
def hold_marked(window, G, active, mask, grips, dt, owned, impulse, work):
    """Set velocity and acceleration of the marked vertices, after the momentum update.

    Parameters
    ----------
    window, G, active, dt, owned, work
        As in `update_momentum`.
    mask
        See `mark`. Where constraints share a vertex, the later one rules.
    grips : tuple of Grip
        The constraints.
    impulse : (planes, grips, 3) float64
        Grows by the momentum that each constraint gives to the vertices.
    """
    plane = window.stride[0]
    for i in range(len(active)):
        if active[i] == 0:
            continue
        for r in range(i * plane, (i + 1) * plane, 8):
            bits = mask[r // 8]
            if bits == 0 or not G[r] > 0.0:
                continue
            momentum = G[r] * dt if i < owned else 0.0
            for k in range(len(grips)):
                if bits >> k & 1 == 0:
                    continue
                for d in range(3):
                    if grips[k].held[d]:
                        change = momentum * (grips[k].rate[d] - G[r + 5 + d])
                        G[r + 1 + d] = grips[k].velocity[d]
                        G[r + 5 + d] = grips[k].rate[d]
                        impulse[i, k, d] += change
                        work[i] += change * grips[k].velocity[d]


def gripped(grips, particles, rows, count, u, v, impulse, work, plane):
    """Ways per time and velocities of a batch of particles as their constraints want them.

    Parameters
    ----------
    rows, count
        The batch's rows, and the number of them that count.
    u, v : tuple of Vec4
        For each direction, those of four particles.
    """


def _held(grips, particles, rows, count, d, u, v, impulse, work, plane):
    """Treat the directions from `d` on, one vector each of `u` and `v`."""


@specialise(_held)
def _held_along(grips, particles, rows, count, d, u, v, impulse, work, plane):
    if len(u) == 0:
        return lambda grips, particles, rows, count, d, u, v, impulse, work, plane: (u, v)

    def held(grips, particles, rows, count, d, u, v, impulse, work, plane):
        way, velocity = u[0], v[0]
        for j in range(LANES):
            p = rows[j]
            k = particles.grip[p, 0] - 1
            if k >= 0 and grips[k].held[d]:
                prescribed = grips[k].velocity[d]
                if j < count:
                    given = particles.m[p] * (prescribed - lane(velocity, j))
                    impulse[plane, k, d] += given
                    work[plane] += given * prescribed
                way, velocity = with_lane(way, j, prescribed), with_lane(velocity, j, prescribed)
        U, V = _held(grips, particles, rows, count, d + 1, u[1:], v[1:], impulse, work, plane)
        return (way, *U), (velocity, *V)

    return held


@specialise(gripped)
def _gripped(grips, particles, rows, count, u, v, impulse, work, plane):
    if len(grips) == 0:
        return lambda grips, particles, rows, count, u, v, impulse, work, plane: (u, v)
    return lambda grips, particles, rows, count, u, v, impulse, work, plane: _held(
        grips, particles, rows, count, 0, u, v, impulse, work, plane
    )
