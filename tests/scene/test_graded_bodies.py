"""Bodies of materials that vary in space, against exact solutions and bodies of several."""

from math import log, sqrt

import numpy as np
import pytest
from scenes import BAR, box, field, finish, scene, start, wall

E, RISE, HIGH, WEIGHT = 100.0, 10.0, 20.0, 0.02


def test_settlement_of_a_column_whose_stiffness_grows_with_depth():
    """u(top) = sum of g (H - x)/E(x) dx, E = E0 + k (H - x): g/k (H - E0/k ln(1 + k H/E0)).

    Gravity sets in over ten periods, smoothly, so that it hardly vibrates; what is left is averaged
    over the last period. Strains are of 1e-3, squares of them count for 1e-3 of the settlement.
    """
    period = 4.0 * HIGH / sqrt(E)
    ramp = [[10.0 * period * s, [-WEIGHT * (s * s * (3.0 - 2.0 * s))]]
            for s in np.linspace(0.0, 1.0, 41).tolist()]  # fmt: skip
    young = {"table": [[0.0, E], [HIGH, E + RISE * HIGH]], "over": "depth", "surface": HIGH}
    sim = start(
        scene(
            1, box([0.0], [HIGH]), cells=[22], materials={"soft": BAR | {"young": young}},
            boundaries={"x-min": "fixed"}, gravity={"table": ramp},
            end=11.0 * period, step={"courant": 0.5}, output={"fields": ["displacement"]},
        )
    )  # fmt: skip
    tops = []
    while not sim.finished:
        sim.advance()
        if sim.time > 10.0 * period:
            tops.append(sim.dt * (field(sim, "origin") - field(sim, "x"))[-1, 0])
    exact = WEIGHT / RISE * (HIGH - E / RISE * log(1.0 + RISE * HIGH / E))
    # The last particle stands a quarter of a cell below the top, where strains are next to none.
    assert sum(tops) / period == pytest.approx(exact, rel=5e-3)


def test_waves_at_the_interface_of_two_layers():
    """Of a wave from Z1 to Z2 the stress 2 Z2/(Z1 + Z2) goes on, (Z2 - Z1)/(Z1 + Z2) comes back."""
    first, second, speed = 100.0, 900.0, 0.01
    young = {"layers": [[0.0, first], [60.0, second]], "over": "x"}
    pulse = [[t, speed * np.sin(np.pi * t / 3.0) ** 2] for t in np.linspace(0.0, 3.0, 31).tolist()]
    sim = start(
        scene(
            1, box([0.0], [140.0]), cells=[142], materials={"soft": BAR | {"young": young}},
            boundaries={"x-min": wall(pulse)}, end=12.0, step={"courant": 0.5},
        )
    )  # fmt: skip
    back, on = 0.0, 0.0
    while not sim.finished:
        sim.advance()
        sigma = field(sim, "sigma")[:, 0]
        on = min(on, sigma[160])  # 20 cells behind the interface
        if sim.time > 7.0:  # the wave that was sent has gone by, and a part comes back
            back = min(back, sigma[60])
    z1, z2 = sqrt(first), sqrt(second)
    sent = -z1 * speed
    assert on == pytest.approx(sent * 2.0 * z2 / (z1 + z2), rel=0.01)
    assert back == pytest.approx(sent * (z2 - z1) / (z1 + z2), rel=0.02)


@pytest.mark.wide
def test_layers_are_as_two_bodies_that_stick():
    """Particles and field are the same; only how the kernel comes by the numbers is not."""
    young = {"layers": [[0.0, 100.0], [4.0, 400.0]], "over": "x"}
    parts = {"cells": [10], "end": 0.5, "gravity": [-1.0], "boundaries": {"x-min": "fixed"}}
    one = scene(1, box([0.0], [8.0], [0.5]), materials={"soft": BAR | {"young": young}}, **parts)
    two = {"low": box([0.0], [4.0], [0.5]), "high": box([4.0], [8.0], [0.5], "hard")}
    hard = BAR | {"young": 400.0}
    both = scene(1, two, materials={"soft": BAR, "hard": hard}, **parts)
    ends = [finish(start(case)) for case in (one, both)]
    for name in ("x", "v", "sigma"):
        found, expected = (field(sim, name) for sim in ends)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13 * scale)
