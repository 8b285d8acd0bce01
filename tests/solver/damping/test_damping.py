"""Damping: rates, frequencies and energies; static solutions by kinetic damping."""

import numpy as np
import pytest
from scenes import box, finish, scene, start

pytestmark = pytest.mark.slow(65)

CONFIGURATIONS = ("current", "initial")
RATE = 1.0


def bar(configuration, cells=40, **parts):
    """A bar of length 1 and wave speed 1, fixed at one end, that gravity pulls from time 0 on."""
    body = box([0.0], [1.0]) | {"formulation": configuration}
    return scene(
        1,
        body,
        cells=[cells + 4],
        cell=1.0 / cells,
        materials={"soft": {"model": "linear-1d", "young": 1.0, "density": 1.0}},
        boundaries={"x-min": "fixed"},
        gravity=[1e-4],
        **parts,
    )


def first_mode(sim, times):
    """Amplitude of the bar's first mode after each step until the end, over its static one."""
    p, found = sim.particles, []
    X = p.x[sim.live(), 0].copy()
    while not sim.finished:
        sim.advance()
        shift = sim.particles.x[sim.live(), 0] - X
        times.append(sim.time)
        found.append(float((p.m[sim.live()] * np.sin(np.pi / 2 * X) * shift).sum()))
    return np.array(found) / (1e-4 * (2 / np.pi) ** 3)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_a_bar_vibrates_more_slowly_and_less_with_mass_damping(configuration):
    """Extremes of q'' + c q' + w^2 q = w^2 are at k pi/sqrt(w^2 - c^2/4), where q - 1 has fallen
    as exp(-c t/2)."""
    times = []
    case = bar(configuration, end=7.0, step={"courant": 0.1}, damping={"mass": RATE})
    q, t = first_mode(start(case), times), np.array(times)
    omega = np.sqrt((np.pi / 2) ** 2 - RATE**2 / 4)
    extremes = np.flatnonzero(np.diff(np.sign(np.diff(q)))) + 1
    assert len(extremes) == 3
    for k, i in enumerate(extremes, 1):
        a, b, c = np.polyfit(t[i - 1 : i + 2] - t[i], q[i - 1 : i + 2], 2)
        when, value = t[i] - 0.5 * b / a, c - 0.25 * b * b / a
        assert when == pytest.approx(k * np.pi / omega, rel=2e-3)
        left = -((-1) ** k) * np.exp(-0.5 * RATE * k * np.pi / omega)
        assert value - 1.0 == pytest.approx(left, abs=2e-3)


def flight(configuration, damping, **parts):
    """A block in free flight, without strain."""
    body = box([1.0, 2.0], [3.0, 4.0], [2.0, 1.0]) | {"formulation": configuration}
    return scene(2, body, cells=[12, 8], end=1.0, damping=damping, **parts)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_free_motion_falls_as_the_exponential(configuration):
    sim = finish(start(flight(configuration, {"mass": 0.7})))
    line = sim.diagnostics()
    assert line["momentum-x"] == pytest.approx(8.0 * np.exp(-0.7), rel=1e-12)
    assert line["damped-momentum-x"] == pytest.approx(8.0 * -np.expm1(-0.7), rel=1e-12)
    first = 0.5 * 4.0 * 5.0
    assert line["kinetic-energy"] == pytest.approx(first * np.exp(-1.4), rel=1e-12)
    assert line["damped-energy"] == pytest.approx(first * -np.expm1(-1.4), rel=1e-12)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_a_fall_approaches_its_terminal_velocity(configuration):
    """g/c, but for c dt/2 of it."""
    case = flight(configuration, {"mass": 2.0}, gravity=[0.0, -3.0], step=0.05)
    line = finish(start(case)).diagnostics()
    left, last = np.exp(-2.0), 3.0 * 0.05 / -np.expm1(-0.1)
    assert last == pytest.approx(1.5 * (1.0 + 0.05), rel=1e-3)
    assert line["momentum-y"] == pytest.approx(4.0 * (left - last * (1.0 - left)), rel=1e-12)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_local_damping_takes_a_part_of_the_unbalanced_force(configuration):
    """In free fall from rest, from the second step on; rise is braked by more."""
    case = flight(configuration, {"local": 0.25}, gravity=[0.0, -1.0])
    case["bodies"]["body"]["velocity"] = [2.0, -1.0]
    sim = finish(start(case))
    line = sim.diagnostics()
    assert line["momentum-x"] == pytest.approx(8.0, rel=1e-12)  # balanced along x
    assert line["momentum-y"] == pytest.approx(4.0 * (-1.0 - 0.75), rel=1e-12)
    assert line["damped-energy"] == pytest.approx(0.25 * 4.0 * (1.0 + 0.375), rel=1e-12)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
@pytest.mark.parametrize(
    "damping", [{"mass": 1.0}, {"local": 0.2}, {"kinetic": True}, {"mass": 0.5, "kinetic": True}]
)
def test_the_books_have_what_damping_takes(configuration, damping):
    """What is left of the dissipated energy is as small as without damping."""
    sim = start(bar(configuration, end=6.0, step={"courant": 0.1}, damping=damping))
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        left = line["dissipated-energy"] - line["damped-energy"]
        assert abs(left) < 2e-3 * 1e-8 / 3.0
    assert line["damped-energy"] > 0.1 * 1e-8 / 3.0


def test_kinetic_damping_takes_the_energy_of_a_peak_to_rounding():
    """And half of the kick from rest: as much momentum as is left."""
    sim = start(bar("current", end=6.0, damping={"kinetic": True}))
    before, peaks = sim.diagnostics(), 0
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        taken = line["damped-energy"] - before["damped-energy"]
        if taken > 1e-14:  # of 1e-8; then rounding
            peaks += 1
            half = taken - before["kinetic-energy"]
            assert 1.9 * line["kinetic-energy"] < half < 4.0 * line["kinetic-energy"]
            lost = line["damped-momentum-x"] - before["damped-momentum-x"]
            kept = before["momentum-x"] + line["momentum-x"]
            assert lost == pytest.approx(kept, abs=1e-18)  # of sums of 1e-4
        before = line
    assert 2 <= peaks <= 40


def test_what_pulls_a_body_works_against_mass_damping():
    """A block that is held at one end and pulled steadily needs c m v, but for c dt/2 of it."""
    held = {"body": "body", "region": {"box": {"min": [1.0, 1.0], "max": [2.0, 3.0]}}}
    body = box([1.0, 1.0], [4.0, 3.0], [0.2, 0.0])
    case = scene(2, body, cells=[16, 6], end=30.0, step={"courant": 0.3}, damping={"mass": 0.5},
                 constraints={"grip": held | {"velocity": [0.2, None]}})  # fmt: skip
    case["history"] = {"every": 10.0}
    sim = start(case)
    while sim.time < 20.0:
        sim.advance()
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    assert last["constraint.grip-x"] == pytest.approx(6.0 * 0.5 * 0.2, rel=1e-2)
    spent = (last["damped-energy"] - first["damped-energy"]) / (last["time"] - first["time"])
    assert spent == pytest.approx(6.0 * 0.5 * 0.2**2, rel=1e-2)


def test_a_block_comes_to_rest_under_its_weight():
    body = box([1.0, 0.0], [4.0, 3.0])
    case = scene(2, body, cells=[6, 5], end=8.0, step={"courant": 0.3}, gravity=[0.0, -1.0],
                 boundaries={"y-min": "fixed"}, damping={"kinetic": True})  # fmt: skip
    sim = start(case)
    while sim.time < 6.0:
        sim.advance()
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert line["reaction.y-min-y"] == pytest.approx(9.0, rel=1e-4)
    assert line["kinetic-energy"] < 1e-9 * line["strain-energy"]


def stiffness(cells, h, per_cell, young, poisson):
    """Stiffness and lumped mass of a block of bilinear elements, summed over its points."""
    n, m = cells
    number = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = young / (2 * (1 + poisson))
    C = np.array([[lame + 2 * shear, lame, 0], [lame, lame + 2 * shear, 0], [0, 0, shear]])
    K = np.zeros((2 * number.size,) * 2)
    M = np.zeros(number.size)
    volume = (h / per_cell) ** 2
    points = (np.arange(per_cell) + 0.5) / per_cell
    for i in range(n):
        for j in range(m):
            corners = [number[i + a, j + b] for a in (0, 1) for b in (0, 1)]
            rows = [2 * c + d for c in corners for d in (0, 1)]
            for x in points:
                for y in points:
                    N = np.outer([1 - x, x], [1 - y, y]).ravel()
                    dx = np.outer([-1, 1], [1 - y, y]).ravel() / h
                    dy = np.outer([1 - x, x], [-1, 1]).ravel() / h
                    B = np.zeros((3, 8))
                    B[0, ::2], B[1, 1::2], B[2, ::2], B[2, 1::2] = dx, dy, dy, dx
                    K[np.ix_(rows, rows)] += volume * B.T @ C @ B
                    M[corners] += volume * N
    return K, M, number


def test_kinetic_damping_finds_the_static_cantilever_within_two_periods():
    """Of the finite elements that are the initial configuration of points, to 0.1 %."""
    cells, h, g = (20, 2), 0.5, 1e-4
    K, M, number = stiffness(cells, h, 2, 100.0, 0.3)
    free = np.setdiff1d(np.arange(len(K)), [2 * v + d for v in number[0] for d in (0, 1)])
    root = np.sqrt(np.repeat(M, 2)[free])
    k = K[np.ix_(free, free)]
    period = 2 * np.pi / np.sqrt(np.linalg.eigvalsh(k / np.outer(root, root))[0])
    u = np.zeros(len(K))
    u[free] = np.linalg.solve(k, (np.repeat(M, 2) * np.tile([0.0, -g], len(M)))[free])
    corner = np.array([[x * y for x in (0.25, 0.75)] for y in (0.25, 0.75)])
    tip = (u[2 * number[-2:, -2:] + 1] * corner.T).sum()

    body = box([0.0, 1.0], [10.0, 2.0]) | {"formulation": "total-lagrangian"}
    case = scene(2, body, cells=[20, 6], cell=h, shape="mpm", end=2.0 * period,
                 step={"courant": 0.5}, gravity=[0.0, -g], boundaries={"x-min": "fixed"},
                 damping={"kinetic": True})  # fmt: skip
    sim = start(case)
    rows = sim.live()
    last = rows[np.argmax(sim.particles.x[rows].sum(axis=1))]
    before = sim.particles.x[last, 1]
    finish(sim)
    assert sim.particles.x[last, 1] - before == pytest.approx(tip, rel=1e-3)
