"""What half-spaces leave of boxes, against volumes of polygons and polytopes by other means."""

import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from cut_bodies import ball, body, box, cylinder, half_space, particles, region
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenes import scene

from pgimp.geometry.measure import measure


def polygon_area(planes):
    """Area of what planes n.x <= b leave of the square (0, 1)^2: the square is clipped by each."""
    corners = [np.array(p, float) for p in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for n, b in planes:
        kept = []
        for p, q in zip(corners, corners[1:] + corners[:1], strict=True):
            u, v = n @ p - b, n @ q - b
            if u <= 0:
                kept.append(p)
            if (u < 0 < v) or (v < 0 < u):
                kept.append(p + u / (u - v) * (q - p))
        corners = kept
    if len(corners) < 3:
        return 0.0
    x, y = np.array(corners).T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def polytope_volume(planes):
    """Volume of what planes leave of the cube: areas of slices between the heights of corners.

    In between they are quadratic in the height, which Simpson's rule integrates exactly.
    """
    cube = [(s * e, max(s, 0.0)) for e in np.eye(3) for s in (-1.0, 1.0)]
    heights = {0.0, 1.0}
    for three in combinations([*planes, *cube], 3):
        N, b = np.array([n for n, _ in three]), np.array([b for _, b in three])
        if abs(np.linalg.det(N)) > 1e-12:
            heights.add(float(np.clip(np.linalg.solve(N, b)[2], 0.0, 1.0)))

    def area(z):
        return polygon_area([(n[:2], b - n[2] * z) for n, b in planes])

    total = 0.0
    for low, high in pairwise(sorted(heights)):
        # Slices at the very ends may be cut by what begins there.
        a, c = (low + t * (high - low) for t in (0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)))
        total += 0.5 * (high - low) * (area(a) + area(c))
    return total


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 3), st.integers(1, 4))
def test_what_half_spaces_leave_of_a_box_is_exact(seed, dimension, number):
    """However many planes meet in a particle's box, at edges and corners of the body."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(number, dimension))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    feet = rng.uniform(0.1, 0.9, (number, dimension))
    unit = box([0.0] * dimension, [1.0] * dimension)
    cuts = [half_space(p, n) for p, n in zip(feet, normals, strict=True)]
    planes = [(n, n @ p) for n, p in zip(normals, feet, strict=True)]
    expected = (polygon_area if dimension == 2 else polytope_volume)(planes)
    low = np.zeros((1, dimension))
    for entry in ({"intersection": [unit, *cuts]}, {"intersection": [*cuts, unit]}):
        volume, _ = measure(region(entry), low, low + 1.0)
        assert volume[0] == pytest.approx(expected, abs=1e-12)
    rest, _ = measure(region({"difference": [unit, {"intersection": [unit, *cuts]}]}), low, low + 1)
    assert rest[0] == pytest.approx(1.0 - expected, abs=1e-12)
    case = scene(dimension, body({"intersection": [unit, *cuts]}), cells=[3] * dimension, cell=0.47)
    if expected > 1e-6:
        p, _ = particles(case)
        assert p.V.sum() == pytest.approx(expected, abs=1e-11)


def quarter(kind, D, shift=0.0):
    """A quarter or an eighth of a ball of radius 1: the part where no coordinate is below `shift`.

    Cut by half-spaces, by a box, and by what other boxes leave.
    """
    whole = ball([shift] * D, 1.0)
    axes = np.eye(D)
    if kind == "half-spaces":
        return {"intersection": [whole, *(half_space([shift] * D, -axis) for axis in axes)]}
    if kind == "box":
        return {"intersection": [whole, box([shift] * D, [3.0] * D)]}
    beyond = [box([-3.0] * D, 3.0 - (3.0 - shift) * axis) for axis in axes]
    return {"difference": [whole, *beyond]}


@pytest.mark.parametrize("surface", ["cut-particles", "whole-particles"])
@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", ["half-spaces", "box", "boxes"])
def test_a_quarter_of_a_ball_on_slip_planes_is_as_exact_as_the_ball(kind, D, surface):
    """The domain ends at the planes; particles and volume are those of the ball in that corner."""
    n = 8
    whole = scene(D, body(ball([0.0] * D, 1.0), surface), cells=[2 * n + 4] * D, cell=2 / n)
    whole["grid"]["origin"] = [-2 - 4 / n] * D
    part = scene(D, body(quarter(kind, D), surface), cells=[n + 2] * D, cell=2 / n)
    part["boundaries"] = {f"{axis}-min": "slip" for axis in "xyz"[:D]}
    p, _ = particles(part)
    exact = (math.pi if D == 2 else 4 / 3 * math.pi) / 2**D
    error = p.V.sum() / exact - 1.0
    assert abs(error) < (4e-6 if surface == "cut-particles" else 0.05)
    q, _ = particles(whole)
    np.testing.assert_allclose(p.V.sum() * 2**D, q.V.sum(), rtol=1e-13)
    corner = (q.x > 0).all(axis=1)
    np.testing.assert_allclose(p.x, q.x[corner], atol=1e-13)
    np.testing.assert_allclose(p.V, q.V[corner], rtol=1e-11)


@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", ["half-spaces", "box", "boxes"])
def test_a_quarter_that_ends_between_the_particles_is_as_exact(kind, D):
    """Nothing about the planes of the grid is needed, as long as the cuts lie across axes."""
    case = scene(D, body(quarter(kind, D, 0.0321)), cells=[16] * D, cell=0.2)
    case["grid"]["origin"] = [-0.4] * D
    p, _ = particles(case)
    exact = (math.pi if D == 2 else 4 / 3 * math.pi) / 2**D
    assert p.V.sum() == pytest.approx(exact, rel=2e-5)


def test_a_ball_that_a_tilted_plane_cuts_converges():
    """By second order at least, as for the rim of a tilted cylinder."""
    normal = np.array([0.48, 0.6, 0.64])
    half = {"intersection": [ball([0.0] * 3, 1.0), half_space([0.0] * 3, normal)]}
    rng = np.random.default_rng(1)
    errors = []
    for n in (8, 24):
        of = []
        for offset in rng.random((4, 3)):
            case = scene(3, body(half), cells=[3 * n // 2] * 3, cell=2 / n)
            case["grid"]["origin"] = (-1.5 + 2 / n * (offset - 0.5)).tolist()
            of.append(particles(case)[0].V.sum() / (2 / 3 * math.pi) - 1.0)
        errors.append(np.sqrt(np.mean(np.square(of))))
    assert errors[0] < 3e-4
    assert np.log(errors[0] / errors[1]) / np.log(3.0) > 1.4


@settings(max_examples=80, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3), st.floats(-0.7, 0.7))
def test_flat_cuts_at_any_angle_are_exact(normal, shift):
    """The end of a wide cylinder, against the volume cut off a cube by a plane (closed form)."""
    normal = np.array(normal)
    assume(np.linalg.norm(normal) > 0.1)
    normal /= np.linalg.norm(normal)
    assume(np.abs(normal).min() > 1e-2)  # the closed form below divides by the product
    foot = 0.5 + shift * normal
    entry = region(cylinder((foot - 50.0 * normal).tolist(), foot.tolist(), 40.0))
    volume, _ = measure(entry, np.zeros((1, 3)), np.ones((1, 3)))
    # Reflections that make the normal positive; then the sum over the corners of max(., 0)^3.
    level = normal @ foot - np.minimum(normal, 0.0).sum()
    n = np.abs(normal)
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        total += (-1) ** sum(corner) * max(level - n @ np.array(corner), 0.0) ** 3
    assert volume[0] == pytest.approx(total / (6 * n.prod()), abs=1e-9)
