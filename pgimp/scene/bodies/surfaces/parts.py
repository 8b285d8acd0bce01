"""Parts of surfaces that particles carry: areas, moments, products of inertia."""

from __future__ import annotations

import numpy as np

from pgimp.scene.bodies.elements import PRODUCTS, Elements, Indices, Reals
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surfaces.boxes import combinations, edge, exists

#: Part of the squared area below which an area vector is that of no direction.
_NONE = 1e-20

#: Boxes from an element to the particle that carries it, at most.
AWAY = 2


def carriers(body: LatticeBody, elements: Elements) -> Indices:
    """Boxes of the particles that carry elements: their own, or the nearest with a particle.

    Those without any within `AWAY` boxes get -2.
    """
    D = len(body.edges)
    box = elements.box.copy()
    if not len(box):
        return box
    ranges = [np.arange(box[:, d].min() - AWAY, box[:, d].max() + AWAY + 1) for d in range(D)]
    first = np.array([r[0] for r in ranges])
    there = exists(body, ranges)
    lacking = np.flatnonzero(~there[tuple((box - first).T)])
    steps = combinations([np.arange(-AWAY, AWAY + 1)] * D)
    centroid = elements.centroid
    for row in lacking:
        near = box[row] + steps
        near = near[there[tuple((near - first).T)]]
        away = np.zeros(len(near))
        for d, e in enumerate(body.edges):
            middle = 0.5 * (edge(e, near[:, d]) + edge(e, near[:, d] + 1))
            away += ((middle - centroid[row, d]) / body.size[d]) ** 2
        box[row] = near[np.argmin(np.round(away, 9))] if len(near) else -2
    return box


def parts_of(body: LatticeBody, elements: Elements, x: Reals, ring: bool) -> tuple[Reals, Reals]:
    """Parts of a surface that particles carry.

    Parameters
    ----------
    elements : Elements
        The elements of the surface within `AWAY` boxes from the particles.
    x : (n, D) float64
        Positions of the body's particles in some planes, in the order of the lattice.
    ring : bool
        Whether boxes stand for rings about the axis x = 0.

    Returns
    -------
    parts : (n, width) float64
        Area, area vector, first moments.
    products : (n, (1 + D) (0, 1 or 4)) float64
        Products of inertia, see `pgimp.kernels.data.particles.Particles.bearing`.
    """
    n, D = x.shape
    found = np.zeros((n, 1 + D + D * D))
    if not n or not len(elements.box):
        return found, np.zeros((n, (1 + D) * PRODUCTS[D - 1]))
    goes = carriers(body, elements)
    whole = _together(body, elements) if ring else elements.area
    shape = tuple(len(e) + 2 for e in body.edges)
    own = np.stack([np.searchsorted(e, x[:, d]) - 1 for d, e in enumerate(body.edges)], axis=1)
    numbers = np.ravel_multi_index(tuple((own + 2).T), shape)
    target = np.ravel_multi_index(tuple((goes + 2).T), shape) if len(goes) else np.zeros(0, int)
    row = np.minimum(np.searchsorted(numbers, target), n - 1)
    mine = numbers[row] == target
    elements, whole, row = elements.chosen(mine), whole[mine], row[mine]
    factor, bend = np.ones(len(row)), np.zeros((len(row), D))
    if ring:
        factor = 2.0 * np.pi * np.maximum(elements.centroid[:, 0], 0.0)
    if ring and body.exact:  # of elements that are not straight
        off = (elements.centroid[:, 0] - elements.centre[:, 0])[:, None]
        bend = 2.0 * np.pi * (elements.moment[:, 0] - off * elements.area)
    square = sum(elements.area[:, d] ** 2 for d in range(D))
    np.add.at(found[:, 0], row, factor * np.sqrt(square))
    for d in range(D):
        np.add.at(found[:, 1 + d], row, factor * elements.area[:, d] + bend[:, d])
        for j in range(D):
            arm = elements.centre[:, j] - x[row, j]
            moment = factor * (elements.moment[:, j, d] + arm * elements.area[:, d])
            if ring:
                moment += 2.0 * np.pi * _spread(whole, j) * elements.area[:, d]
                moment += (elements.centroid[:, j] - x[row, j]) * bend[:, d]
            np.add.at(found[:, 1 + D + D * j + d], row, moment)
    return found, _products(elements, x, row, found, whole if ring else None)


def _products(
    elements: Elements, x: Reals, row: Indices, parts: Reals, rings: Reals | None
) -> Reals:
    """Products of inertia of the parts of a surface in some rows, see `parts_of`.

    For `rings` with the area vectors from `_together`.
    """
    n, D = x.shape
    count = PRODUCTS[D - 1]
    found = np.zeros((n, 1 + D, count))
    vector, loaded = parts[:, 1 : 1 + D], np.flatnonzero(parts[:, 0])
    moment = parts[:, 1 + D :].reshape(n, D, D)
    square = (vector * vector).sum(axis=1)
    some = square > _NONE * parts[:, 0] ** 2
    arm = np.zeros((n, D))
    arm[some] = (moment * vector[:, None]).sum(axis=2)[some] / square[some, None]
    area, centroid = elements.area, (x + arm)[row]
    size = np.sqrt((area * area).sum(axis=1))
    if rings is not None:  # straight strips, which weigh with their radius
        r, (p, q) = np.maximum(elements.centroid[:, 0], 0.0), rings.T
        a, b = (elements.centroid - centroid).T
        product = 2.0 * np.pi * (r * a * b + (q * q * b - p * q * (r + a)) / 12.0)
        second = (area * product[:, None])[:, None]
    else:
        second = elements.about(centroid)
    along = (second * area[:, None]).sum(axis=2) / np.maximum(size, 1e-300)[:, None]
    for k in range(count):
        np.add.at(found[:, 0, k], row, along[:, k])
        for d in range(D):
            np.add.at(found[:, 1 + d, k], row, second[:, k, d])
    found[loaded, 0] /= parts[loaded, 0, None]
    found[:, 1:] -= found[:, :1] * vector[:, :, None]
    if D == 3:  # gradients of weights have the products, too
        about = moment - arm[:, :, None] * vector[:, None]
        found[:, 1:, 3] -= (found[:, 0, :3, None] * about).sum(axis=1)
    return found.reshape(n, -1)


#: Places in a box along each direction that tell elements apart.
_PLACES = 32


def _together(body: LatticeBody, elements: Elements) -> Reals:
    """Area vectors of elements in 2D, (n, 2), with those of all at the same place.

    A surface between two boxes has an element in each, of half of its area.
    """
    ends = [e[0] for e in body.edges]
    place = np.rint((elements.centroid - ends) / np.array(body.size) * _PLACES).astype(np.int64)
    number = np.unique(place, axis=0, return_inverse=True)[1].reshape(-1)
    sums = np.zeros((len(place), 2))
    np.add.at(sums, number, elements.area)
    return np.asarray(sums[number])


def _spread(area: Reals, j: int) -> Reals:
    """Mean of (x - x_c) (x_j - x_jc) over straight elements in 2D, (n,), by their area vectors."""
    return np.asarray((area[:, 1] ** 2 if j == 0 else -area[:, 0] * area[:, 1]) / 12.0)
