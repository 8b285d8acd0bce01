"""Gaps of facets and levels of patches against loops in NumPy."""

from math import inf

import numpy as np
import pytest

from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.surfaces.data import Surface, no_facets
from pgimp.kernels.contact.surfaces.nearest import next_facet
from pgimp.kernels.contact.surfaces.patches.levels import GATHERED, NUMBERED, gather, level
from pgimp.kernels.contact.surfaces.patches.pressed import facing_part

WIDTH = 0.01


def surface_of(x, normal, area, body, beside=None):
    """A surface of such facets, where they are initially."""
    n = len(x)
    start = np.zeros(n + 1, np.int64)
    beside = [np.zeros(0, np.int64)] * n if beside is None else beside
    start[1:] = np.cumsum([len(each) for each in beside])
    index = np.arange(n)
    return Surface(
        x, normal, x.copy(), np.full((n, 3), 0.5), area, 0.5 * area, index,
        np.full(n, area.sum()), body, np.full(n, -1),
        np.zeros((n, 3)), np.zeros((n, 2, 3)), np.zeros(n, np.uint8), start,
        np.concatenate(beside).astype(np.int64), x.copy(), normal.copy(), np.zeros((n, 2, 3)),
        np.zeros((n, 4)), (),
    )  # fmt: skip


@kernel
def _levels(surface, every, own, numbers, width, found):
    for n in range(len(every)):
        same = 0.0
        for d in range(3):
            same += surface.turned[every[n].facet, d] * every[n].normal[d]
        every[n].facing = facing_part(same) if every[n].gap < inf else 0.0
        found[1 + n] = every[n].facing
    count, whole, deepest = gather(surface, (every, 0, len(every)), 0, own, numbers)
    found[0] = level(own, count, whole, every[deepest].gap, width)


@kernel
def _next(D, surface, s, cell, f, found):
    found[0] = next_facet(D, surface, s, cell, f)


def levels(surface, every, found):
    """Set the level of all facets, and the parts of them that face the other body."""
    room = len(every) + 3
    own, numbers = np.empty((GATHERED, room)), np.empty((NUMBERED, room), np.int64)
    _levels(surface, every, own, numbers, WIDTH, found)


def unit(v):
    return v / np.sqrt((v * v).sum(axis=-1, keepdims=True))


@pytest.mark.parametrize("spread", [0.0, 0.003, 0.1])
def test_levels_solve_their_equation(spread):
    """Of facets that face the other body; against bisection."""
    rng = np.random.default_rng(3)
    n = 9
    normal = unit(np.array([0.0, -1.0, 0.0]) + 0.4 * rng.normal(size=(n, 3)))
    surface = surface_of(rng.random((n, 3)), normal, rng.uniform(0.02, 0.2, n), np.zeros(n, int))
    every = no_facets(n)
    every["facet"], every["normal"] = np.arange(n), [0.0, 1.0, 0.0]
    every["gap"] = 0.05 + spread * rng.random(n)
    every["gap"][4] = np.inf
    every["side"] = np.where(np.isfinite(every["gap"]), 0, -1)
    found = np.empty(1 + n)
    levels(surface, every, found)
    cosine = np.maximum(0.0, -normal[:, 1])
    there = np.isfinite(every["gap"])
    weight = np.where(there, cosine**8, 0.0)
    np.testing.assert_allclose(found[1:], weight, rtol=1e-12)
    whole = max(surface.area @ weight, 0.03 * surface.area.sum())
    gap, area = every["gap"][there], surface.area[there]
    low, high = gap.min(), gap.min() + 1.0
    for _ in range(60):
        s = 0.5 * (low + high)
        value = area @ np.maximum(0.0, s - gap) ** 2 - whole * WIDTH**2
        low, high = (s, high) if value < 0.0 else (low, s)
    assert found[0] == pytest.approx(low, rel=1e-9)


def test_parallel_faces_have_their_gap():
    """Whatever part of a patch lies before the other body: the level is the gap, and the width."""
    rng = np.random.default_rng(5)
    n = 8
    normal = np.tile([0.0, -1.0, 0.0], (n, 1))
    surface = surface_of(rng.random((n, 3)), normal, rng.uniform(0.02, 0.2, n), np.zeros(n, int))
    every = no_facets(n)
    every["facet"], every["normal"], every["gap"] = np.arange(n), [0.0, 1.0, 0.0], 0.07
    found = np.empty(1 + n)
    for beyond in (0, 3, 5):
        every["gap"][:beyond] = np.inf
        every["side"] = np.where(np.isfinite(every["gap"]), 0, -1)
        levels(surface, every, found)
        assert found[0] == pytest.approx(0.07 + WIDTH, rel=1e-12)


def test_the_next_facet_of_a_disk_is_the_nearest():
    """Along neighbours, from anywhere, against all of them."""
    rng = np.random.default_rng(7)
    n, radius = 40, 3.0
    angle = 2.0 * np.pi * np.arange(n) / n
    normal = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    x = np.concatenate([radius * normal, np.zeros((1, 3))])
    beside = [np.array([(k - 1) % n, (k + 1) % n]) for k in range(n)] + [np.zeros(0, np.int64)]
    area = np.full(n + 1, 2.0 * np.pi * radius / n)
    body = np.append(np.zeros(n, int), 1)
    found = np.zeros(1, np.int64)
    for _ in range(20):
        way = 2.0 * np.pi * rng.random()
        out = np.array([np.cos(way), np.sin(way), 0.0])
        x[n] = rng.uniform(2.9, 3.3) * out
        surface = surface_of(x, np.concatenate([normal, -out[None]]), area, body, beside)
        off = np.sqrt(((x[:n] - x[n]) ** 2).sum(axis=1))
        nearest = int(off.argmin())
        for begin in (nearest, (nearest + 2) % n, (nearest - 3) % n):
            _next(2, surface, n, 1.0, begin, found)
            assert off[found[0]] < off.min() + 1e-2
