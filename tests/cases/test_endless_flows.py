"""Cases in cases/ of flows without ends, coarsened or shorter, against exact profiles."""

from pathlib import Path

import numpy as np
import pytest

import pgimp
from pgimp.physics.materials import registry

pytestmark = pytest.mark.slow(45)

CASES = Path(__file__).resolve().parents[2] / "cases"


def test_oil_begins_to_flow_between_plates(runs):
    """The parabola as it forms, at two instants, to half a per cent of its final height."""
    run = runs("poiseuille")
    nu, high, g = 24.76136e-3, 0.1, 9.81
    for frame in list(run)[-2:]:
        y, v = frame["position"][:, 1], frame["velocity"]
        exact = g * y * (high - y) / (2.0 * nu)
        for n in range(1, 40, 2):
            rate, size = nu * (n * np.pi / high) ** 2, 4.0 * g * high**2 / (nu * (n * np.pi) ** 3)
            exact -= size * np.sin(n * np.pi * y / high) * np.exp(-rate * frame.time)
        assert np.abs(v[:, 0] - exact).max() < 0.005 * 0.495227
        assert np.abs(v[:, 1]).max() < 1e-12
    assert run.frame(-1)["velocity"][:, 0].max() > 0.4


@pytest.mark.wide
def test_grains_find_bagnolds_profile(runs):
    """After half of the time: velocity to 3 % of the greatest, pressure to 0.5 %."""
    frame = runs("bagnold").frame(-1)
    slope, high = np.radians(24.0), 0.04
    weight, t = 9.81 * np.cos(slope), np.tan(slope)
    number = 0.279 * (t - 0.38) / (0.64 - t)
    top = 2.0 / 3.0 * number / 0.002 * np.sqrt(0.6 * weight) * high**1.5
    assert top == pytest.approx(0.5778, abs=1e-4)  # as the case says
    y, v = frame["position"][:, 1], frame["velocity"][:, 0]
    exact = top * (1.0 - (1.0 - y / high) ** 1.5)
    assert np.sqrt(np.mean((v - exact) ** 2)) < 0.03 * top
    most = 1500.0 * weight * high
    assert np.abs(frame["pressure"] - 1500.0 * weight * (high - y)).max() < 0.01 * most
    assert np.median(frame["stress"][:, 3] / frame["pressure"]) == pytest.approx(t, rel=0.01)


def test_vortices_decay(tmp_path):
    """The kinetic energy to 2 %, half as much again as its error, and the pattern."""
    registry.import_file(str(CASES / "vortices.py"))
    run = pgimp.run(CASES / "own/taylor-green.yaml", output=tmp_path / "run", quiet=True)
    history, nu, k = run.history, 0.02, 2.0 * np.pi
    exact = 0.25 * np.exp(-4.0 * nu * k * k * history["time"])
    assert history["kinetic-energy"] == pytest.approx(exact, rel=0.02)
    frame = run.frame(-1)
    x, v = frame["position"], frame["velocity"][:, :2]
    pattern = np.stack([np.sin(k * x[:, 0]) * np.cos(k * x[:, 1]),
                        -np.cos(k * x[:, 0]) * np.sin(k * x[:, 1])], axis=1)  # fmt: skip
    decay = np.exp(-2.0 * nu * k * k * frame.time)
    assert np.sum(v * pattern) / np.sum(pattern**2) == pytest.approx(decay, rel=0.03)
    assert np.sqrt(np.mean(np.sum((v - decay * pattern) ** 2, axis=1))) < 0.03
