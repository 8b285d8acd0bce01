"""Prescribed motion of a part of a body (``constraints``): grips that hold particles and vertices.

Particles that a constraint holds move exactly as it says. Each marks the vertices that it reaches;
these are held too, so that the material moves with the particles where it touches them, and does
not tear from them sooner than need be. A grip therefore acts up to a vertex near the region's edge:
exactly there where the edge is a plane of vertices, else up to a cell further, and it jumps from
vertex to vertex as it moves. What one rank marks in the planes it shares with another is united by
``or``, so that no order can matter.
"""

from typing import NamedTuple

from pgimp.kernels.jit import kernel, specialise
from pgimp.kernels.transfer import support

#: Least weight along a direction of a vertex that a held particle reaches; less is rounding.
FIRM = 1e-9


class Grip(NamedTuple):
    """A constraint during one step: components held, velocity at its end, change over it by dt."""

    held: tuple[bool, bool, bool]
    velocity: tuple[float, float, float]
    rate: tuple[float, float, float]


def _mark(mask, bit, place, W):
    """Set a bit at the vertices that a particle reaches; `place` counts vertices."""


@specialise(_mark)
def _mark_along(mask, bit, place, W):
    if len(W) == 0:

        def vertex(mask, bit, place, W):
            mask[place] |= bit

        return vertex

    def line(mask, bit, place, W):
        for i in range(len(W[0][0])):
            if W[0][0][i] >= FIRM:
                _mark(mask, bit, place + i * (W[0][2] // 8), W[1:])

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
    for layer in range(len(start) - 1):
        for k in range(start[layer], start[layer + 1]):
            p = order[k]
            grip = particles.grip[p, 0]
            if grip > 0:
                place, W = support(shape, frame, window, particles, p, layer + window.lower[0])
                place += layer * window.stride[0]
                _mark(mask, 1 << (grip - 1), place // 8, W)


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


def _choose(held, given, free):
    """Entries of `given` where `held` says so, else of `free`; as many as `free` has."""


@specialise(_choose)
def _choose_each(held, given, free):
    if len(free) == 1:
        return lambda held, given, free: (given[0] if held[0] else free[0],)
    return lambda held, given, free: (
        given[0] if held[0] else free[0], *_choose(held[1:], given[1:], free[1:]),
    )  # fmt: skip


def gripped(grips, particles, p, u, v, impulse, work, plane):
    """Way per time and velocity of particle `p` as its constraint wants them."""


@specialise(gripped)
def _gripped(grips, particles, p, u, v, impulse, work, plane):
    if len(grips) == 0:
        return lambda grips, particles, p, u, v, impulse, work, plane: (u, v)

    def held(grips, particles, p, u, v, impulse, work, plane):
        k = particles.grip[p, 0] - 1
        if k < 0:
            return u, v
        for d in range(len(v)):
            if grips[k].held[d]:
                given = particles.m[p] * (grips[k].velocity[d] - v[d])
                impulse[plane, k, d] += given
                work[plane] += given * grips[k].velocity[d]
        return (
            _choose(grips[k].held, grips[k].velocity, u),
            _choose(grips[k].held, grips[k].velocity, v),
        )

    return held
