"""Stress recovered from particles and their neighbours: linear fields, a bore under pressure."""

import numpy as np
import pytest
from scenes import SOFT, finish, scene, start

from pgimp.physics.derived import RECOVERED
from pgimp.solver.lagrangian.recovered_stress import recovered_at, recovered_stresses
from pgimp.solver.state.probes import nearest, sample

pytestmark = pytest.mark.slow(30)

CENTRE, INNER, OUTER, PRESSURE = np.array([7.13, 6.91]), 3.0, 6.0, 0.01


def tube(**parts):
    """A thick tube in plane strain, exact to its surface."""
    balls = [{"ball": {"centre": CENTRE.tolist(), "radius": r}} for r in (OUTER, INNER)]
    body = {"material": "soft", "region": {"difference": balls}, "formulation": "total-lagrangian",
            "surface": "exact"}  # fmt: skip
    return scene(2, body, cells=[14, 14], materials={"soft": SOFT}, **parts)


def around(radius, count=72):
    angle = (np.arange(count) + 0.5) * 2.0 * np.pi / count
    n = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return CENTRE + radius * n, n


def hoop(stress, n):
    """Hoop stress, from xx, yy, zz, xy."""
    xx, yy, xy = stress[:, 0], stress[:, 1], stress[:, 3]
    return xx * n[:, 1] ** 2 + yy * n[:, 0] ** 2 - 2.0 * xy * n[:, 0] * n[:, 1]


def test_linear_stress_is_found_at_surfaces():
    sim = start(tube())
    p, rows = sim.particles, sim.live()
    slopes = np.array([[1.0, -2.0], [0.5, 0.25], [0.0, 1.0], [-1.5, 0.75]])
    p.sigma[rows] = 3.0 + p.origin[rows] @ slopes.T
    for radius in (INNER, OUTER, 4.2):
        x, _ = around(radius)
        found = recovered_stresses(sim.rank, x, np.zeros(len(x), int))
        np.testing.assert_allclose(found, 3.0 + x @ slopes.T, atol=5e-3)
    some = rows[::-3]
    found = recovered_at(sim.rank, rows, some)
    np.testing.assert_allclose(found[:, :4], 3.0 + p.origin[some] @ slopes.T, atol=5e-3)
    assert not found[:, 4:].any()


def test_hoop_stress_at_a_bore():
    """Against Lame's; in cells at the surface the particles' own is off by four times as much."""
    bore = {"ball": {"centre": CENTRE.tolist(), "radius": 4.0}}
    load = {"bore": {"body": "body", "region": bore, "pressure": PRESSURE}}
    sim = start(tube(end=8.0, step={"courant": 0.5}, tractions=load, damping={"mass": 2.5}))
    finish(sim)
    p, rows = sim.particles, sim.live()
    ratio = OUTER**2 / (OUTER**2 - INNER**2)

    def exact(r):
        return PRESSURE * INNER**2 / (OUTER**2 - INNER**2) * (1.0 + (OUTER / r) ** 2)

    r = np.linalg.norm(p.origin[rows] - CENTRE, axis=1)
    beside = (p.V0[rows] < 0.2499) & (r < 4.5)
    n = (p.origin[rows] - CENTRE) / r[:, None]
    own = hoop(p.sigma[rows], n)[beside]
    found = recovered_at(sim.rank, rows, rows)
    error, errors = (
        np.sqrt(np.mean((each - exact(r[beside])) ** 2)) / PRESSURE
        for each in (hoop(found, n)[beside], own)
    )
    assert error < 0.1 < 0.3 * errors

    # A probe at the bore: there, and not at the particle.
    x, n = around(INNER, 8)
    points = [nearest(sim, 0, at, [RECOVERED]) for at in x.tolist()]
    lines = sample(sim, points)
    stress = np.array([[line[f"{RECOVERED}-{c}"] for c in ("xx", "yy", "zz", "xy")]
                       for line in lines])  # fmt: skip
    np.testing.assert_allclose(hoop(stress, n), (2.0 * ratio - 1.0) * PRESSURE, rtol=0.12)
