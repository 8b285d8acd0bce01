"""What docs/methods.md advises about artificial viscosity, on the coarsest grid of its table."""

import pytest
from studies.initial.impacts import front, rebound
from studies.initial.restitution import bars


def test_a_little_viscosity_halves_the_error_of_a_wave_in_the_initial_configuration():
    """Measured: errors of 0.061 and 0.037, overshoots of 25 and 4 %."""
    without, little = (front("initial", (linear, 0.0), 50) for linear in (0.0, 0.1))
    assert little["error"] < 0.7 * without["error"] < 0.05
    assert without["overshoot"] > 0.2
    assert little["overshoot"] < 0.05


def test_bars_part_as_those_of_the_model():
    """The model has no gaps, normals or sweeps. Measured: 4e-5 and 0.002 apart."""
    found = rebound("initial", (0.0, 0.0), 20)
    parted, lost = bars("restitution", 0.0, 20)
    assert found["restitution"] == pytest.approx(parted, abs=5e-4)
    assert found["lost"] == pytest.approx(lost, rel=0.02)


def test_a_stiffness_keeps_what_an_impulse_loses():
    parted, lost = bars("restitution", 0.0, 50)
    assert lost == pytest.approx(0.5 / 50, rel=0.1)  # half a cell of each bar stops
    reversed_parted, kept = bars("restitution", 1.0, 50)
    assert abs(kept) < 0.1 * lost
    assert reversed_parted < parted + 0.01  # the energy has become vibration
    parted, kept = bars("stiffness", 0.25, 50)
    assert abs(kept) < 0.05 * lost
    assert parted > 0.997
