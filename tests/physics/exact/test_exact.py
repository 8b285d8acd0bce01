"""The exact solutions satisfy what they solve, checked by differences and by other means."""

from functools import cache

import numpy as np
import pytest
from exact_cases import CASES, DENSITY, LENGTH, SPEED, WALL, YOUNG, Exact, slope
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_materials import neo_hookean

UNIT = st.floats(0.0, 1.0)
INNER = st.floats(0.002, 0.998)  # differences do not reach beyond the body
FORCED = ["vortex", "block2d", "block3d"]
FREE = ["dynamic", "free", "held"]


@cache
def exact(name):
    return Exact(CASES[name])


def inside(solution, place):
    """A point of the body from numbers between 0 and 1."""
    if solution.case.exact.model == "linear-1d":
        return np.array([WALL + LENGTH * place[0]])
    if solution.D == 2 and hasattr(solution.region, "root"):
        outer, inner = solution.region.root
        R = inner.radius + (outer.radius - inner.radius) * place[0]
        angle = 2 * np.pi * place[1]
        return np.array(outer.centre) + R * np.array([np.cos(angle), np.sin(angle)])
    low, high = np.array(solution.region.min), np.array(solution.region.max)
    return low + (high - low) * np.array(place[: solution.D])


@pytest.mark.parametrize("name", CASES)
@settings(max_examples=10, deadline=None)
@given(st.tuples(INNER, INNER, INNER), UNIT)
def test_velocity_and_stress_follow_from_the_displacement(name, place, t):
    solution = exact(name)
    X, t = inside(solution, place), 0.01 + 0.6 * t
    _, v, sigma = solution.state(X, t)
    if name == "shock" and np.abs(SPEED * t - [X[0] - WALL, 2 * LENGTH + WALL - X[0]]).min() < 0.05:
        return  # a front passes
    rate = slope(lambda s: solution.state(X, t + s)[0], 1e-4)
    np.testing.assert_allclose(v, rate, atol=1e-7 * SPEED)
    F = solution.gradient(X, t)
    if solution.D == 1:
        expected = np.diag([YOUNG * (F[0, 0] - 1.0), 0.0, 0.0])
    else:
        expected = neo_hookean(solution.material.parameters(), F, None, None)
    np.testing.assert_allclose(sigma, expected, atol=1e-7 * YOUNG)


@pytest.mark.parametrize("name", FORCED + FREE)
@settings(max_examples=8, deadline=None)
@given(st.tuples(INNER, INNER, INNER), UNIT)
def test_momentum_is_balanced(name, place, t):
    """rho0 x_tt = Div P + rho0 b, with P and x_tt by differences."""
    solution = exact(name)
    X, t = inside(solution, place), 0.01 + t
    rho = solution.material.density
    force = solution.force(X, t) if name in FORCED else np.zeros(1)
    if name == "dynamic":
        force = np.array([-6.0 * t])
        wave = np.array([X[0] - WALL + SPEED * t, X[0] - WALL - SPEED * t])
        if np.abs(np.remainder(wave + LENGTH / 2, LENGTH) - LENGTH / 2).min() < 0.05:
            return  # the third derivative jumps along the characteristics from the ends
    acceleration = slope(lambda s: solution.state(X, t + s)[1], 1e-3)
    found = solution.divergence(X, t) / rho + force
    size = 1.0 + np.abs(acceleration).max() + np.abs(force).max()
    np.testing.assert_allclose(found, acceleration, atol=2e-6 * size)


@pytest.mark.parametrize("name", CASES)
def test_it_starts_undeformed(name):
    solution = exact(name)
    for place in ([0.0, 0.1, 0.7], [0.4, 0.8, 0.2], [1.0, 0.5, 1.0]):
        X = inside(solution, place)
        u, v, sigma = solution.state(X, 0.0)
        np.testing.assert_allclose(u, 0.0, atol=1e-14)
        np.testing.assert_allclose(sigma, 0.0, atol=1e-11)
        if name == "dynamic":
            np.testing.assert_allclose(v, 0.0, atol=1e-14)
        if name == "shock" and place[0]:
            assert v == [-0.2 * SPEED]


@pytest.mark.parametrize("t", [0.13, 0.4, 0.69])
def test_bars_keep_to_their_ends(t):
    for name in ("compaction", "dynamic", "shock", "free", "held"):
        solution = exact(name)
        assert solution.state([WALL], t)[0] == pytest.approx([0.0], abs=1e-14)
        u, _, sigma = solution.state([WALL + LENGTH], t)
        if name == "held":
            assert u == pytest.approx([0.0], abs=1e-14)
        else:
            assert sigma[0, 0] == pytest.approx(0.0, abs=1e-11)


@settings(max_examples=20, deadline=None)
@given(UNIT, UNIT, st.booleans())
def test_the_ring_rests_at_its_radii_and_is_free_there(angle, t, outside):
    solution = exact("vortex")
    X = inside(solution, [float(outside), angle])
    u, v, sigma = solution.state(X, t)
    for found in (u, v, sigma):
        np.testing.assert_allclose(found, 0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["block2d", "block3d"])
@settings(max_examples=10, deadline=None)
@given(st.tuples(UNIT, UNIT, UNIT), UNIT, st.integers(0, 2), st.booleans())
def test_the_faces_of_the_block_are_free(name, place, t, axis, high):
    solution = exact(name)
    axis %= solution.D
    place = [float(high) if i == axis else p for i, p in enumerate(place)]
    P = solution.piola(inside(solution, place), t)
    np.testing.assert_allclose(P[:, axis], 0.0, atol=1e-6)


@pytest.mark.parametrize("name", FORCED)
def test_the_motion_is_large(name):
    """Stretches from below 0.8 to above 1.3: block of up to 1.4 and 0.75, ring of shear 0.92."""
    solution = exact(name)
    stretches = []
    for t in (0.25, 0.5, 0.75):
        for place in np.random.default_rng(1).uniform(0, 1, (40, 3)):
            F = solution.gradient(inside(solution, place), t)
            stretches.append(np.linalg.svd(F)[1])
    least, most = np.min(stretches), np.max(stretches)
    assert least < 0.8 and most > 1.3


def test_dynamic_compaction_against_the_sum_of_its_modes():
    """w = sum of -r_n sin(k_n Z) sin(c k_n t)/(c k_n), r_n = 2/(L k_n^3) b'/c^2."""
    solution = exact("dynamic")
    k = (np.arange(1, 400) - 0.5) * np.pi / LENGTH
    f = -6.0 / SPEED**2
    for t in (0.07, 0.35, 0.5, 0.9):
        for z in (0.3, 2.0, 4.9):
            w = -(2 / LENGTH / k**3 * np.sin(k * z) * np.sin(SPEED * k * t) / (SPEED * k)).sum()
            expected = f * (t * (LENGTH * z - z * z / 2) + w)
            u, _, _ = solution.state([WALL + z], t)
            assert u == pytest.approx([expected], abs=1e-9 * abs(f))


def test_compaction_is_static_whenever_waves_have_come_back():
    """At multiples of 2 L/c, the paper's instants, both solutions agree at any place."""
    static, dynamic = exact("compaction"), exact("dynamic")
    t = 2 * LENGTH / SPEED
    for z in (0.4, 2.0, 4.7):
        X = np.array([WALL + z])
        x = X + static.state(X, t)[0] + 1e-4  # not quite where it should be
        u, _, s = static.state(X, t, x)
        w, _, r = dynamic.state(X, t, x)
        assert w == pytest.approx(u, rel=1e-12)
        assert r[0, 0] == pytest.approx(s[0, 0], rel=1e-7)


@pytest.mark.parametrize("t", [0.5, 1.2, 3.0])
def test_compaction_is_in_equilibrium(t):
    """Along a table that rises, turns and is held."""
    b = np.interp(t, [0.0, 1.0, 1.5], [0.0, -6.0, 4.0])
    for z in (0.4, 2.0, 4.7):
        found = exact("compaction").divergence(np.array([WALL + z]), t)
        assert found == pytest.approx([-DENSITY * b], rel=1e-6)
