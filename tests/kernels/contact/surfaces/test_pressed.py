"""Pressure on the facets of a patch, and the part that presses, against what defines them."""

import numpy as np
import pytest

from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.surfaces.data import Surface, no_facets
from pgimp.kernels.contact.surfaces.loads import _find_pressure
from pgimp.kernels.contact.surfaces.patches.levels import GATHERED, NUMBERED, WEIGHT, gather
from pgimp.kernels.contact.surfaces.patches.pressed import pressed_area, pressing


@kernel
def _press(surface, every, weights, own, numbers, place, found):
    count, _, _ = gather(surface, (every, 0, len(every)), 0, own, numbers)
    for n in range(count):
        own[WEIGHT, n] = weights[n]
    found[4] = pressed_area(surface, own, numbers, count, 0.0, 1.0)
    for n in range(len(every)):
        every[n].weight = pressing(surface, every[n], 0, 0.0, 1.0)
    group = (every, 0, len(every))
    tangents = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    a, b, c, good = _find_pressure(surface, group, place, tangents, 1.0)
    found[0], found[1], found[2], found[3] = a, b, c, 1.0 if good else 0.0


def press(surface, every, place, found):
    """Set the pressure on the facets of a patch, and the area that presses."""
    room = len(every) + 3
    own, numbers = np.empty((GATHERED, room)), np.empty((NUMBERED, room), np.int64)
    _press(surface, every, every["weight"].copy(), own, numbers, place, found)


def patch(columns, rows):
    """Facets of a unit square on the plane z = 0 in columns along x and rows along y."""
    x, y = ((np.arange(n) + 0.5) / n for n in (columns, rows))
    x = np.column_stack([*(each.ravel() for each in np.meshgrid(x, y)), np.zeros(columns * rows)])
    n = len(x)
    normal, half = np.tile([0.0, 0.0, 1.0], (n, 1)), np.zeros((n, 3))
    half[:, :2] = 0.5 / columns, 0.5 / rows
    surface = Surface(
        x, normal, x.copy(), half, *np.full((2, n), 1.0 / n), np.zeros(n, np.int64),
        np.ones(n), np.zeros(n, np.int64), np.full(n, -1), np.zeros((n, 3)), np.zeros((n, 2, 3)),
        np.zeros(n, np.uint8), np.zeros(n + 1, np.int64), np.zeros(0, np.int64), x.copy(),
        normal.copy(), np.zeros((n, 2, 3)), np.zeros((n, 8)), (),
    )  # fmt: skip
    every = no_facets(n)
    every["facet"], every["normal"], every["side"] = np.arange(n), [0.0, 0.0, -1.0], 0
    every["gap"], every["facing"] = 0.001, 1.0
    return surface, every


@pytest.mark.parametrize("shape", [(8, 1), (8, 8), (4, 5)])
@pytest.mark.parametrize("place", [(0.5, 0.5), (0.4, 0.55), (0.2, 0.5), (0.15, 0.8), (0.97, 0.5)])
def test_force_and_moment_without_tension(shape, place):
    surface, every = patch(*shape)
    low = 0.5 / np.array(shape)
    place = np.array([*np.clip(place, low, 1.0 - low), 0.0])
    if shape[1] == 1:
        place[1] = 0.5
    every["weight"] = 0.0
    found = np.empty(5)
    # Weights of four facets that have the place.
    near = np.argsort(((surface.x - place) ** 2).sum(axis=1))[:1]
    every["weight"][near] = 1.0
    press(surface, every, place, found)
    assert found[3] == 1.0
    xi = surface.x - place
    force = surface.area * np.maximum(0.0, found[0] + found[1] * xi[:, 0] + found[2] * xi[:, 1])
    assert force.sum() == pytest.approx(1.0, abs=1e-11)
    assert np.abs(force @ xi).max() < 1e-11


@pytest.mark.parametrize(("at", "part"), [(0.5, 1.0), (0.34, 1.0), (0.2, 0.6), (0.9, 0.3)])
def test_a_force_beyond_the_middle_third_presses_on_three_times_its_distance(at, part):
    """As under a footing; weights of facets 1000 along x, of which two have the place."""
    surface, every = patch(1000, 1)
    every["weight"] = np.abs(surface.x[:, 0] - at) < 0.0011
    every["weight"] /= every["weight"].sum()
    found = np.empty(5)
    press(surface, every, np.array([at, 0.5, 0.0]), found)
    assert found[4] == pytest.approx(part, abs=2e-3)
