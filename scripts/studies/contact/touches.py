"""Bodies that touch in a point or along a face, and their surfaces: what `detection` looks at."""

from math import cos, radians, sin
from typing import NamedTuple

import numpy as np
from studies.contact import gap
from studies.scenes import ball, box

#: Points of a surface's quadrature on the length of a cell, by dimension.
FINE = {2: 400, 3: 24}


class Surface(NamedTuple):
    """Points of a quadrature, their outward normals and areas."""

    points: np.ndarray
    normals: np.ndarray
    areas: np.ndarray


class Touch(NamedTuple):
    """Two bodies that touch in the `middle`: their regions, and their surfaces near there.

    The normal is that from the first to the second; `distance` gives the gap along it at distances
    (n, D) from the middle.
    """

    regions: tuple
    surfaces: tuple
    middle: np.ndarray
    normal: np.ndarray
    distance: object


def _across(normal):
    """Directions across a normal, (D - 1, D)."""
    return np.linalg.svd(normal[None])[2][1:]


def _lattice(dimensions, half):
    """Places in the middle of equal parts of [-half, half], (n, D - 1), and the size of one."""
    count = round(2 * half * FINE[dimensions])
    s = (np.arange(count) + 0.5) / count * 2.0 * half - half
    places = np.stack(np.meshgrid(*[s] * (dimensions - 1), indexing="ij"), axis=-1)
    return places.reshape(-1, dimensions - 1), (2.0 * half / count) ** (dimensions - 1)


def _middle(dimensions, shift):
    return np.full(dimensions, 0.5 * gap.CELLS[dimensions]) + shift


def flat(dimensions, way, shift):
    """Flat faces across the direction `way`."""
    way = np.asarray(way) / np.linalg.norm(way)
    middle, tangents = _middle(dimensions, shift), _across(way)
    places, area = _lattice(dimensions, 5.0)
    points = middle + places @ tangents

    def block(side):
        planes = [(middle, -side * way), (middle + side * 4.0 * way, side * way)]
        planes += [(middle + s * 4.0 * t, s * t) for t in tangents for s in (-1.0, 1.0)]
        return {"intersection": [
            {"half-space": {"point": p.tolist(), "normal": n.tolist()}} for p, n in planes
        ]}  # fmt: skip

    keep = (np.abs(places) < 4.0).all(axis=1)
    surfaces = tuple(
        Surface(points[keep], np.tile(side * way, (keep.sum(), 1)), np.full(keep.sum(), area))
        for side in (1.0, -1.0)
    )
    return Touch((block(-1.0), block(1.0)), surfaces, middle, way, lambda x: np.zeros(len(x)))


def balls(dimensions, radius, way, shift):
    """Disks or balls of a radius that touch along `way`."""
    way = np.asarray(way) / np.linalg.norm(way)
    middle, tangents = _middle(dimensions, shift), _across(way)
    places, area = _lattice(dimensions, min(4.0, 0.9 * radius))
    square = (places**2).sum(axis=1)
    places, square = places[square < (0.9 * radius) ** 2], square[square < (0.9 * radius) ** 2]
    deep = radius - np.sqrt(radius**2 - square)
    regions, surfaces = [], []
    for side in (-1.0, 1.0):
        centre = middle + side * radius * way
        points = middle + places @ tangents + side * deep[:, None] * way
        normals = (points - centre) / radius
        regions.append({"intersection": [ball(centre, radius), box(middle - 7.0, middle + 7.0)]})
        surfaces.append(Surface(points, normals, area / np.abs(normals @ way)))

    def distance(x):
        s = np.minimum(((x - (x @ way)[:, None] * way) ** 2).sum(axis=1), radius**2)
        return 2.0 * (radius - np.sqrt(radius**2 - s))

    return Touch(tuple(regions), tuple(surfaces), middle, way, distance)


def corner(angle, shift):
    """The corner of a square, turned by `angle`, that stands on a plane."""
    c, s = cos(radians(angle)), sin(radians(angle))
    middle, half = _middle(2, shift), 4.0
    edges = np.array([[c, s], [-s, c]])
    square = gap.turned(middle + half * edges.sum(axis=0), [half, half], angle)
    plane, floor = _upper(middle)
    u = (np.arange(round(6.0 * FINE[2])) + 0.5) / FINE[2]
    area = np.full(len(u), 1.0 / FINE[2])
    legs = [
        Surface(middle + u[:, None] * edges[d], np.tile(-edges[1 - d], (len(u), 1)), area)
        for d in range(2)
    ]
    tip = Surface(*(np.concatenate(parts) for parts in zip(*legs, strict=True)))

    def distance(x):
        return np.where(x[:, 0] > 0.0, x[:, 0] * s / max(c, 1e-9), -x[:, 0] * c / max(s, 1e-9))

    return Touch((plane, square), (floor, tip), middle, np.array([0.0, 1.0]), distance)


def _upper(middle):
    """A body whose upper face is at a place, and that face."""
    places, area = _lattice(2, 6.0)
    normals, areas = np.tile([0.0, 1.0], (len(places), 1)), np.full(len(places), area)
    region = box(middle - np.array([10.0, 8.0]), middle + np.array([10.0, 0.0]))
    return region, Surface(middle + places * [1.0, 0.0], normals, areas)


def edge(shift):
    """The lower edge of a block that lies on a plane."""
    middle = _middle(2, shift)
    plane, floor = _upper(middle)
    u = (np.arange(round(6.0 * FINE[2])) + 0.5) / FINE[2]
    area = np.full(2 * len(u), 1.0 / FINE[2])
    points = middle + np.concatenate([u[:, None] * [1.0, 0.0], u[:, None] * [0.0, 1.0]])
    faces = Surface(points, np.repeat([[0.0, -1.0], [-1.0, 0.0]], len(u), axis=0), area)
    return Touch((plane, box(middle, middle + 8.0)), (floor, faces), middle,
                 np.array([0.0, 1.0]), lambda x: np.zeros(len(x)))  # fmt: skip
