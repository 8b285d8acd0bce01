"""cases/own/swirl.yaml: force and stress belong to the displacement, and the order is two."""

import sys
from pathlib import Path

import numpy as np
import pytest

import pgimp
from pgimp.physics.materials import registry
from pgimp.utilities.study.plan import read_plan

pytestmark = pytest.mark.slow(30)

CASES = Path(__file__).resolve().parents[2] / "cases"
MU, LAM, RHO = 1000.0 / 2.6, 300.0 / (1.3 * 0.4), 1000.0
PLACES = [(0.13, 0.71), (0.5, 0.25), (0.92, 0.08)]


@pytest.fixture(scope="module")
def swirl():
    registry.import_file(str(CASES / "swirl.py"))
    return sys.modules["swirl"]


def differences(f, X, h):
    """Gradient of a function of the place, the last index the direction, of fourth order."""
    parts = []
    for e in np.eye(2) * h:
        near, far = (np.array(f(X + k * e)) - f(X - k * e) for k in (1, 2))
        parts.append((8.0 * near - far) / (12.0 * h))
    return np.stack(parts, axis=-1)


@pytest.mark.parametrize("X", PLACES)
@pytest.mark.parametrize("t", [0.07, 0.4])
def test_force_and_stress_are_those_of_the_displacement(swirl, X, t):
    """By differences: P of the neo-Hookean law, its divergence, and the acceleration."""
    A, f = 0.05, 1.0

    def state(X, t=t):
        return [np.array(part) for part in swirl.state(tuple(X), t, A, f, MU, LAM)]

    def gradient(X):
        return np.eye(2) + differences(lambda x: state(x)[0], X, 1e-3)

    def piola(X):
        F = gradient(X)
        return MU * F + (LAM * np.log(np.linalg.det(F)) - MU) * np.linalg.inv(F).T

    X = np.array(X)
    _, v, sigma = state(X)
    F = gradient(X)
    cauchy = piola(X) @ F.T / np.linalg.det(F)
    found = cauchy[0, 0], cauchy[1, 1], LAM * np.log(np.linalg.det(F)) / np.linalg.det(F)
    np.testing.assert_allclose(sigma, [*found, cauchy[0, 1]], atol=1e-7)
    h = 1e-4
    rate = (state(X, t + h)[0] - state(X, t - h)[0]) / (2.0 * h)
    np.testing.assert_allclose(v, rate, atol=1e-6)
    acceleration = (state(X, t + h)[1] - state(X, t - h)[1]) / (2.0 * h)
    divergence = np.einsum("ijj->i", differences(piola, X, 2e-3))
    force = swirl.force(tuple(X), t, A, f, MU, LAM, RHO)
    np.testing.assert_allclose(force, acceleration - divergence / RHO, atol=2e-6)


def test_the_order_is_two(swirl, tmp_path):
    worst = []
    for cells in (8, 16):
        changes = {"grid.cell": [1.0 / cells] * 2, "time.step": 0.05 / cells, "output.every": None}
        run = pgimp.run(CASES / "own/swirl.yaml", output=tmp_path / f"{cells}", quiet=True,
                        overrides=changes)  # fmt: skip
        worst.append([run.history[f"error{name}"].max() for name in ("", ".displacement-l2")])
    order = np.log2(np.divide(*worst))
    assert order[0] > 1.7 and order[1] > 1.85
    assert worst[1][1] < 0.05 * 0.04
    known = run.info["functions"]
    assert [*known] == ["swirl.force.body_force_values", "swirl.state.exact_solution_values"]
    assert all(len(each) == 16 for each in known.values())


def test_the_study_is_planned(swirl):
    assert len(read_plan(CASES / "studies/swirl.yaml").runs) == 3
