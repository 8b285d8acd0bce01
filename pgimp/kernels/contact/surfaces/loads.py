"""Loads of contact on facets, summed over steps: impulses, slip, and the work of friction.

A pair of a patch and another body has one impulse. Its pressure on the facets k of the patch is

    q_k = max(0, alpha + beta . xi_k),   sum_k A_k q_k = 1,   sum_k A_k q_k xi_k = 0,

with the places xi_k from that of the pair, along the surface: see
`pgimp.kernels.contact.surfaces.patches.pressed`. So force and moment are those of the pair. The
other body has the opposite, on its facets around these places.
"""

from math import sqrt

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.contact.books import losses_of
from pgimp.kernels.contact.data import impulse_of
from pgimp.kernels.contact.impulses.gauss_seidel import load_pair
from pgimp.kernels.contact.impulses.pairs import SIDES
from pgimp.kernels.contact.surfaces.data import turns
from pgimp.kernels.contact.surfaces.patches.levels import end_of_patch, entry_of
from pgimp.kernels.contact.surfaces.patches.pressed import pressing

#: Columns of the loads: impulse; its part along normals, positive in compression; the way that the
#: other body slid while it pressed; energy of friction. Then scratch of a step: the impulse along
#: the normal, and that times the speed of sliding.
IMPULSE, PRESSED, SLIP, HEAT, LOADS = 0, 3, 4, 5, 8
_NOW, _RATE = 6, 7

#: Iterations for the pressure, at most, and the error that ends them; least second moments of
#: areas, over the area and the square of a cell's side.
_NEWTON, _EXACT, _LEAST = 30, 1e-13, 1e-12

#: Least cosine between normals of facets that share a load.
_ALIKE = 0.7


@inner_kernel
def _tangents(n):
    """Two unit vectors across a unit vector; the first lies in the plane of x and y, if it does."""
    axis = 2
    for d in range(2):
        if abs(n[d]) < 0.5 * abs(n[axis]):
            axis = d
    e = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
    a = (n[1] * e[2] - n[2] * e[1], n[2] * e[0] - n[0] * e[2], n[0] * e[1] - n[1] * e[0])
    length = sqrt(a[0] ** 2 + a[1] ** 2 + a[2] ** 2)
    a = (a[0] / length, a[1] / length, a[2] / length)
    b = (n[1] * a[2] - n[2] * a[1], n[2] * a[0] - n[0] * a[2], n[0] * a[1] - n[1] * a[0])
    return a, b


@inner_kernel
def _along(x, place, t):
    """Component of a place, from another one, along a direction."""
    return (x[0] - place[0]) * t[0] + (x[1] - place[1]) * t[1] + (x[2] - place[2]) * t[2]


@inner_kernel
def _find_pressure(surface, group, place, tangents, cell):
    """The numbers alpha and beta of a pressure without tension, and whether they are found.

    By Newton's method on the facets under pressure, all at first. `group` is facets, first and end;
    their weights are the areas that may press. Without a solution the pressure is even.
    """
    (every, first, last), (s, t), whole = group, tangents, 0.0
    for n in range(first, last):
        whole += every[n].weight
    a, b, c = 1.0 / whole, 0.0, 0.0
    for iteration in range(_NEWTON):
        r, rx, ry, m, mx, my, mxx, mxy, myy = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for n in range(first, last):
            area = every[n].weight
            if area == 0.0:
                continue
            x = _along(surface.now[every[n].facet], place, s)
            y = _along(surface.now[every[n].facet], place, t)
            q = a + b * x + c * y
            if q > 0.0:
                r -= area * q
                rx -= area * q * x
                ry -= area * q * y
                m += area
                mx += area * x
                my += area * y
                mxx += area * x * x
                mxy += area * x * y
                myy += area * y * y
        if abs(r) < _EXACT and max(abs(rx), abs(ry)) < _EXACT * cell:
            return a, b, c, True
        mxx += _LEAST * whole * cell * cell
        myy += _LEAST * whole * cell * cell
        p, q, o = mxx * myy - mxy * mxy, my * mxy - mx * myy, mx * mxy - my * mxx
        det = m * p + mx * q + my * o
        if not det > 0.0:
            break
        a += (r * p + rx * q + ry * o) / det
        b += (r * q + rx * (m * myy - my * my) + ry * (mx * my - m * mxy)) / det
        c += (r * o + rx * (mx * my - m * mxy) + ry * (m * mxx - mx * mx)) / det
    return 1.0 / whole, 0.0, 0.0, False


@inner_kernel
def _row(rows, f, key):
    """Row of a facet's loads, of rigid bodies with prescribed motion by the other body, `key`."""
    _, slot, first, _ = rows
    return f if slot[f] < 0 else first[key] + slot[f]


@inner_kernel
def _give(rows, r, part, given):
    """Add a part of what a pair has exchanged to a row of loads."""
    (loads, _, _, touched), (impulse, pressed, speed, heat) = rows, given
    row = loads[r]
    if row[_NOW] == 0.0 and part * abs(pressed) > 0.0:
        touched[0] += 1
        touched[touched[0]] = r
    for d in range(3):
        row[IMPULSE + d] += part * impulse[d]
    row[PRESSED] += part * pressed
    row[HEAT] += part * heat
    row[_NOW] += part * abs(pressed)
    row[_RATE] += part * abs(pressed) * speed


@inner_kernel
def _near(D, surface, s, f, width):
    """Part of a load at facet `s` that facet `f` of the other body has, before all are scaled."""
    square = 0.0
    for d in range(3):
        way = surface.now[s, d] - surface.now[f, d]
        square += (way - turns(surface, way, d)) ** 2
    return surface.area[f] * max(0.0, 1.0 - sqrt(square) / width)


@inner_kernel
def _width(D, surface, f):
    """Width of a facet."""
    return 2.0 * surface.radius[f] if D == 2 else sqrt(surface.area[f])


@inner_kernel
def _give_other(D, surface, s, f, rows, part, given):
    """Give a part of a load at facet `s` to the facets around facet `f` of the other body."""
    whole, key = 0.0, surface.body[s]
    width = max(_width(D, surface, s), _width(D, surface, f))
    if D > 1:
        whole = _near(D, surface, s, f, width)
        for k in range(surface.start[f], surface.start[f + 1]):
            if _same(surface, f, surface.beside[k]):
                whole += _near(D, surface, s, surface.beside[k], width)
    if not whole > 0.0:
        _give(rows, _row(rows, f, key), part, given)
        return
    own = _near(D, surface, s, f, width) / whole
    _give(rows, _row(rows, f, key), part * own, given)
    for k in range(surface.start[f], surface.start[f + 1]):
        m = surface.beside[k]
        if _same(surface, f, m):
            share = part * _near(D, surface, s, m, width) / whole
            if share > 0.0:
                _give(rows, _row(rows, m, key), share, given)


@inner_kernel
def _same(surface, f, m):
    """Whether two facets have nearly the same normal."""
    cosine = 0.0
    for d in range(3):
        cosine += surface.normal[f, d] * surface.normal[m, d]
    return cosine > _ALIKE


@kernel
def add_loads(contact, contact_pairs, coupling, solved, frame, surface, every, step):
    """Add what pairs have exchanged in a step to the loads of their facets.

    Parameters
    ----------
    contact, contact_pairs, coupling, solved
        See `pgimp.kernels.contact.surfaces.groups.solve_groups`, with the impulses.
    surface : Surface
        The facets, where they are.
    every : (n,) NEAR_FACET
        Facets with gaps and sides, in the order of the pairs; weights are set here.
    step : (float, (rows, LOADS) float64, (facets,) int64, (bodies,) int64, (rows + 1,) int64)
        Length of the step; the loads; numbers of the facets of rigid bodies with prescribed motion,
        -1 of others; the first row of these for each other body; scratch.
    """
    D, (dt, loads, slot, begin, touched), first, last = len(frame.cell), step, 0, 0
    rows, cell = (loads, slot, begin, touched), frame.cell[0]
    touched[0] = 0
    for d in range(D):
        cell = min(cell, frame.cell[d])
    for k in range(len(contact_pairs.ends)):
        end, row = contact_pairs.ends[k], contact_pairs.states[k]
        while last <= first or (
            surface.patch[every[first].facet] != end.vertex[0] or every[first].body != end.vertex[1]
        ):
            first = last
            last = end_of_patch(surface, every, first)
        side, least = end.vertex[2] - SIDES, 1e300
        J = (impulse_of(row, 0), impulse_of(row, 1), impulse_of(row, 2))
        if J[0] == 0.0 and J[1] == 0.0 and J[2] == 0.0:
            continue
        for n in range(first, last):
            if every[n].side == side:
                least = min(least, every[n].gap)
        load_pair(contact, contact_pairs, k, coupling, solved)
        u, v = contact.fields[0].velocity, contact.fields[1].velocity
        heat, _ = losses_of(row, u, v)
        pressed, across, square = 0.0, 0.0, 0.0
        for d in range(3):
            pressed += J[d] * row.normal[d]
            across += (v[d] - u[d]) * row.normal[d]
        for d in range(3):
            square += (v[d] - u[d] - across * row.normal[d]) ** 2
        _, swapped = entry_of(contact.pairs, surface.body[every[first].facet], every[first].body)
        sign, place = 1.0 if swapped else -1.0, contact_pairs.rigid[k, 2]
        tangents = _tangents(row.normal)
        for n in range(first, last):
            every[n].weight = pressing(surface, every[n], side, least, cell)
        group = (every, first, last)
        a, b, c, _ = _find_pressure(surface, group, place, tangents, cell)
        own = (sign * J[0], sign * J[1], sign * J[2])
        other = (-own[0], -own[1], -own[2])
        for n in range(first, last):
            s = every[n].facet
            q = a + b * _along(surface.now[s], place, tangents[0])
            q += c * _along(surface.now[s], place, tangents[1])
            part = every[n].weight * max(0.0, q)
            if part > 0.0:
                given = (own, pressed, sqrt(square), heat)
                _give(rows, _row(rows, s, every[n].body), part, given)
                if 0 <= every[n].other < len(surface.patch):
                    given = (other, pressed, sqrt(square), heat)
                    _give_other(D, surface, s, every[n].other, rows, part, given)
    for n in range(touched[0]):
        load = loads[touched[1 + n]]
        load[SLIP] += dt * load[_RATE] / load[_NOW]
        load[_NOW] = load[_RATE] = 0.0
