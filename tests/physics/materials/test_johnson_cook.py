"""Johnson and Cook's metal along paths: heat, rate, failure, pressure, energy, bad parameters."""

import re

import numpy as np
import pytest
from one_material import case_of, text_of
from reference_materials import tensor

import pgimp
from pgimp.errors import CaseError

E, NU = 129e9, 0.34
COPPER = {
    "model": "johnson-cook", "young": E, "poisson": NU, "density": 8960.0, "a": 90e6, "b": 292e6,
    "n": 0.31, "c": 0.025, "m": 1.0, "reference-rate": 1.0, "specific-heat": 383.0,
    "temperature": 294.0, "melting": 1356.0,
}  # fmt: skip
GRUNEISEN = {"eos": {"mie-gruneisen": {"c0": 3933.0, "s": 1.489, "gamma": 1.99}}}
SPAN = 1062.0


def isochoric(end, steps):
    e = end * np.arange(1, steps + 1) / steps
    return np.array([np.diag(np.exp([x, -0.5 * x, -0.5 * x])) for x in e])


def equivalent(sigma):
    s = sigma[:, :3] - sigma[:, :3].mean(axis=1)[:, None]
    return np.sqrt(1.5 * ((s**2).sum(axis=1) + 2.0 * (sigma[:, 3:] ** 2).sum(axis=1)))


def heated(alpha, rate):
    """Adiabatic rise of temperature at a constant plastic rate, for m = 1."""
    k = 0.9 * (1 + 0.025 * np.log(rate)) / (8960.0 * 383.0 * SPAN)
    return SPAN * (1.0 - np.exp(-k * (90e6 * alpha + 292e6 * alpha**1.31 / 1.31)))


def test_adiabatic_heating():
    """92.002 K at a strain of 1 and a rate of 1000/s; first order in the step, or better."""
    assert heated(1.0, 1e3) == pytest.approx(92.002, abs=5e-4)
    errors = []
    for steps in (200, 400, 4000):
        found = pgimp.element(COPPER, isochoric(1.02, steps), 1.02 / steps / 1e3)
        rise = np.interp(1.0, found["plastic-strain"], found["temperature"] - 294.0)
        errors.append(abs(rise / 92.002 - 1.0))
    assert errors[0] / errors[1] > 1.9
    assert errors[2] < 1e-4


@pytest.mark.parametrize("rate", [1e-3, 1e3, 1e6])
def test_stress_lies_on_the_yield_surface_of_its_own_rate(rate):
    end, steps = 0.3, 3000
    found = pgimp.element(COPPER, isochoric(end, steps), end / steps / rate)
    alpha = found["plastic-strain"]
    flow = np.diff(alpha, prepend=0.0)
    before = np.concatenate([[294.0], found["temperature"][:-1]])
    fast = np.maximum(flow / (end / steps / rate), 1.0)
    surface = (90e6 + 292e6 * alpha**0.31) * (1.0 + 0.025 * np.log(fast))
    surface *= 1.0 - (before - 294.0) / SPAN
    settled = slice(20, None)
    assert (flow[settled] > 0.0).all()
    np.testing.assert_allclose(equivalent(found["stress"])[settled], surface[settled], rtol=1e-10)


def test_melted_metal_bears_no_shear():
    hot = COPPER | {"temperature": 1355.0, "taylor-quinney": 1.0}
    found = pgimp.element(hot, isochoric(0.5, 500), 1e-6)
    assert found["temperature"].max() < 1357.0
    assert equivalent(found["stress"])[-1] < 1e-3 * equivalent(found["stress"])[:50].max()


@pytest.mark.parametrize("eos", [{}, GRUNEISEN], ids=["elastic", "mie-gruneisen"])
def test_what_has_failed_bears_pressure_alone(eos):
    """Damage grows by flow over the strain at failure; then tension is gone, compression stays."""
    brittle = COPPER | eos | {"damage": {"d1": 0.2}}
    pulled = isochoric(0.4, 400)
    opened = pulled[-1] * np.linspace(1.0, 1.02, 51)[1:, None, None]
    closed = opened[-1] * np.linspace(1.0, 0.94, 101)[1:, None, None]
    found = pgimp.element(brittle, np.concatenate([pulled, opened, closed]), 1e-6)
    alpha, damage = found["plastic-strain"], found["damage"]
    sound = damage < 1.0
    np.testing.assert_allclose(damage[sound], alpha[sound] / 0.2, rtol=1e-12)
    sigma, mean = found["stress"], found["stress"][:, :3].mean(axis=1)
    assert (equivalent(sigma)[~sound] <= 1e-9 * E).all() and not sound[400:].any()
    assert (mean[400:450] <= 1e-3 * E).all() and abs(mean[430]) <= 1e-12 * E * bool(not eos) + 1e8
    J = np.linalg.det(closed[-1])
    assert mean[-1] < 0.9 * E / (3 * (1 - 2 * NU)) * np.log(J) if not eos else mean[-1] < -1e9


def test_failure_depends_on_triaxiality_and_heat():
    law = {"d1": 0.54, "d2": 4.89, "d3": -3.03, "d4": 0.014, "d5": 1.12}
    found = pgimp.element(COPPER | {"damage": law}, isochoric(1.0, 4000), 1e-6)
    alpha = found["plastic-strain"]
    flow = np.diff(alpha, prepend=0.0)
    before = np.concatenate([[294.0], found["temperature"][:-1]])
    mean = found["stress"][:, :3].mean(axis=1)  # 0 up to rounding at constant volume
    assert np.abs(mean).max() < 1e-9 * E
    strain = (0.54 + 4.89) * (1 + 0.014 * np.log(np.maximum(flow / 1e-6, 1)))
    strain *= 1 + 1.12 * (before - 294.0) / SPAN
    np.testing.assert_allclose(found["damage"], np.cumsum(flow / strain), rtol=1e-9)


def squashed(t):
    return [-0.15 * t, 0.03 * np.sin(3 * t), 0.02 * t]


def blown_up(t):
    """Sheared until it fails, then opened by half of its volume, and closed beyond that."""
    volume = np.interp(t, [0.3, 0.7, 1.0], [0.0, 0.4, -0.05]) / 3.0
    e = min(0.1 * t, 0.03)
    return [volume + e, volume - e, volume]


@pytest.mark.parametrize(
    ("path", "fails"), [(squashed, {}), (blown_up, {"damage": {"d1": 0.02}})], ids=["", "failed"]
)
def test_energy_of_shocked_metal_is_the_work(path, fails):
    """Internal energy and that of shape and flow are the work of the stress, to second order.

    Failure sets energy free within a step: that is to first order.
    """
    metal = COPPER | GRUNEISEN | {"taylor-quinney": 0.6} | fails
    errors = []
    for steps in (400, 800):
        t = np.arange(1, steps + 1) / steps
        F = np.array([np.diag(np.exp(path(x))) for x in t])
        found = pgimp.element(metal, F, 1e-8)
        assert not fails or found["damage"][-1] == 1.0
        P = [
            np.linalg.det(f) * tensor(s) @ np.linalg.inv(f).T
            for f, s in zip(F, found["stress"], strict=True)
        ]
        P, F = np.array([np.zeros((3, 3)), *P]), np.array([np.eye(3), *F])
        work = 0.5 * np.sum((P[1:] + P[:-1]) * np.diff(F, axis=0))
        J, shear = np.linalg.det(F[-1]), E / (2 * (1 + NU))
        q = J * equivalent(found["stress"][-1:])[0]
        lost = found["plastic-work"][-1]
        inner = 8960.0 * found["internal-energy"][-1] - 0.6 * lost
        errors.append(abs((inner + q * q / (6.0 * shear) + lost) / work - 1.0))
    assert errors[0] < 1e-3 and errors[0] / errors[1] > 1.8


WRONG = {
    "melting: 200.0": "expected more than the temperature at the start, 294",
    "a: 0.0": "must be above 0",
    "n: 0.0": "must be above 0",
    "taylor-quinney: 1.5": "at most 1",
    "damage: {d1: -0.1}": "d1 + d2, the strain at failure",
    "eos: {mie-gruneisen: {c0: 3933.0, s: 1.5}}": "gamma: missing",
    "eos: {gruneisen: {c0: 3933.0}}": "unknown key",
}


def test_compression_that_heats_needs_an_absolute_temperature():
    case = pgimp.load(case_of(COPPER | {"temperature": -20.0}))
    assert case.materials["law"].temperature == -20.0
    with pytest.raises(CaseError, match=r"temperature: -20 is no absolute temperature: with an eq"):
        pgimp.load(case_of(COPPER | GRUNEISEN | {"temperature": -20.0}))


@pytest.mark.parametrize("line", WRONG)
def test_bad_parameters_are_refused_by_line(line, tmp_path):
    (tmp_path / "case.yaml").write_text(text_of(COPPER, line))
    with pytest.raises(CaseError, match=re.escape(WRONG[line])) as refused:
        pgimp.load(tmp_path / "case.yaml")
    assert re.search(r"case\.yaml:\d+: materials\.m\.", str(refused.value))
