"""Means of gauges over their window, and what they are against: a torque, the rate of momentum."""

import numpy as np
import pytest
from region_entries import half_space as half
from scenes import box, scene, start


def test_means_are_over_the_window():
    """Of what the lines have, with a window that begins between two of them; then a resume's.

    By the trapezoidal rule, and of fluxes, which are means since the line before, exactly.
    """
    gauges = {
        "gate": {"flux": half([4.0, 0.0], [1.0, 0.0]), "mean": 0.23},
        "pool": {"level": [4.5], "mean": 0.23},
    }
    body = box([1.0, 1.0], [3.0, 5.0], [2.0, 0.0])
    sim = start(scene(2, body, cells=[16, 8], end=2.0, step=0.05, gauges=gauges))
    times, fluxes, means, heights, levels = [], [], [], [], []
    while not sim.finished:
        line = sim.diagnostics()
        times.append(line["time"])
        fluxes.append(line["gauge.gate.mass-flux"])
        means.append(line["gauge.gate.mean.mass-flux"])
        heights.append(line["gauge.pool.height"])
        levels.append(line["gauge.pool.mean.height"])
        sim.advance()
    assert max(fluxes) == pytest.approx(8.0, rel=1e-9)
    fine = np.linspace(0.0, 1.0, 40001)
    assert max(heights) > 3.0
    passed = np.cumsum(np.multiply(fluxes, np.diff(times, prepend=0.0)))
    for end, mean, level in zip(times, means, levels, strict=True):
        begin = max(0.0, end - 0.23)
        values = np.interp(begin + fine * (end - begin), times, heights)
        assert level == pytest.approx(np.trapezoid(values, fine), abs=1e-6)
        if end > 0.0:
            since = np.interp([begin, end], times, passed)
            assert mean == pytest.approx(np.diff(since)[0] / (end - begin), abs=1e-9)
    sums = sim.diagnostic_sums.means
    rows = sums.rows(sim.scene)
    assert rows.shape == (12, 8)
    other = type(sums)()
    other.restore(sim.scene, rows)
    assert other.rows(sim.scene).tolist() == rows.tolist()


def test_the_torque_of_a_bar():
    """Stresses of torsion, G theta r: the moment is G theta times the polar second moment."""
    body = box([0.0, 2.0, 2.0], [6.0, 6.0, 6.0])
    gauges = {"cut": {"cut": half([2.5, 4.0, 4.0], [1.0, 0.0, 0.0])}}
    sim = start(scene(3, body, gauges=gauges))
    p, rows = sim.particles, sim.live()
    y, z = (p.x[rows, d] - 4.0 for d in (1, 2))
    p.sigma[rows, 3], p.sigma[rows, 5] = -0.5 * z, 0.5 * y
    line = sim.diagnostics()
    # Of particles at 0.25, 0.75, .. from the axis on 4 x 4: close to its 4^4/6.
    polar = 2.0 * (np.arange(-1.75, 2.0, 0.5) ** 2).mean() * 16.0
    assert polar == pytest.approx(4.0**4 / 6.0, rel=0.02)
    assert line["gauge.cut.moment-x"] == pytest.approx(0.5 * polar, rel=1e-12)
    for name in ("force-x", "force-y", "force-z", "moment-y", "moment-z"):
        assert line[f"gauge.cut.{name}"] == pytest.approx(0.0, abs=1e-12)


def test_the_force_is_the_rate_of_momentum():
    """Exactly, of vertices that keep their motion: a block that spins, cut on one side."""
    body = box([1.0, 1.0], [7.0, 5.0]) | {"formulation": "total-lagrangian"}
    body["velocity"] = {"rotation": {"rate": 0.5, "about": [4.0, 3.0]}}
    gauges = {"cut": {"cut": half([5.5, 3.0], [-1.0, 0.0])}}
    sim = start(scene(2, body, gauges=gauges, end=1.0))

    def momentum():
        kept = sim.rank.grid.by_vertex(sim.rank.grid.kept.values)[:, 0]
        x = np.arange(len(kept)) + sim.rank.grid.window.lower[0] - sim.scene.domain.frame.ghost
        right = kept[x >= 6.0]
        return (right[..., :1] * right[..., 5:7]).sum(axis=(0, 1, 2))

    for _ in range(30):
        before, line = momentum(), sim.diagnostics()
        sim.advance()
        force = [line[f"gauge.cut.force-{axis}"] for axis in "xy"]
        np.testing.assert_allclose((momentum() - before) / 0.01, force, rtol=0, atol=1e-11)
    assert force[0] < -0.5
