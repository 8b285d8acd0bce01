"""Cases in cases/ of ground, coarsened or shorter: cavity, cone, tunnel, waves."""

import numpy as np
import pytest
from studies.quiet import shaken

pytestmark = pytest.mark.slow(25)


@pytest.mark.wide
def test_a_cavity_takes_the_pressure_of_clay_that_yields(runs):
    """Cells of half the first radius: the pressure to 1 % in the mean, to 3 % always."""
    history = runs("cavity").history
    a = 1.0 + history["displacement.push-x"]
    pressure = history["constraint.push-x"] / (2.0 * np.pi * a * 0.25)
    wide = a > 1.2
    square = 50.0 * (a[wide] ** 2 - 1.0)  # of the radius out to which the clay yields
    part = pressure[wide] / (1.0 + np.log(square / a[wide] ** 2) - square / 900.0)
    assert a[-1] > 1.5
    assert part.mean() == pytest.approx(1.0, abs=0.01)
    assert np.abs(part - 1.0).max() < 0.03  # waves swing it by 1 %


@pytest.mark.wide
def test_clay_resists_a_cone_as_published(runs):
    """Cells of half a radius, where waves of the shoulder swing the force by a tenth.

    Between ways of 4 and 5.2 radii it is 5 % below its last value, and cells of a quarter have 12 %
    less. So it is within an eighth of 9.73 by Teh and Houlsby; no particle is in the cone.
    """
    history = runs("cone").history
    way = -history["rigid.cone.displacement-y"]
    assert way[-1] > 5.1 and not history["rigid.cone.penetrating-particles"].any()
    factor = history["rigid.cone.force-y"][way > 4.0].mean() / np.pi
    assert factor == pytest.approx((1.67 + 100.0 / 1500.0) * (1.0 + np.log(100.0)), rel=0.125)


def test_a_tunnel_turns_stress_aside_as_kirsch_says(runs):
    """Four cells to the radius: rest before, then the wall's way to 3 % and stresses to 5 %."""
    run = runs("tunnel")
    history, a = run.history, 2.0
    before = history["time"] < 0.01
    assert before.sum() > 2 and history["kinetic-energy"][before].max() < 1e-20
    for name, side in (("crown", -1.0), ("springline", 1.0)):
        probe = run.probes[name]
        x, y = probe["position-x"][0], probe["position-y"][0]
        k, turn = a * a / (x * x + y * y), side * abs(np.cos(2.0 * np.arctan2(y, x)))
        exact = a * np.sqrt(k) * 1.3e6 / 1.0e9 * (0.75 - 0.25 * turn * (2.8 - k))
        way = np.hypot(probe["displacement-x"][-1], probe["displacement-y"][-1])
        assert way == pytest.approx(exact, rel=0.03)
    frame = run.frame(-1)
    place, stress = frame["position"] - frame["displacement"], frame["stress"] / 1.0e6
    r, angle = np.hypot(*place.T), np.arctan2(place[:, 1], place[:, 0])
    c, s, k = np.cos(angle), np.sin(angle), (a / r) ** 2
    hoop = stress[:, 0] * s * s + stress[:, 1] * c * c - 2.0 * stress[:, 3] * s * c
    exact = -0.75 * (1.0 + k) - 0.25 * (1.0 + 3.0 * k * k) * np.cos(2.0 * angle)
    near = (r > 1.5 * a) & (r < 2.0 * a)
    assert np.sqrt(np.mean((hoop - exact)[near] ** 2)) < 0.05
    assert np.ptp(exact[near]) > 0.4  # they differ around the tunnel


def test_a_layer_swings_more_than_its_base(runs):
    """Ten cells high: the amplification of a damped layer to 2 %, and its phase."""
    probe = runs("shaking").probes["surface"]
    time, w, c = probe["time"], 4.0 * np.pi, 0.4 * np.pi
    late = time > 7.0
    swing = np.stack([np.sin(w * time[late]), np.cos(w * time[late])], axis=1)
    size = np.linalg.lstsq(swing, probe["velocity-x"][late] / 0.01, rcond=None)[0]
    k = np.sqrt(w * w - 1j * w * c) / 200.0
    exact = np.cos(k * (20.0 - probe["position-y"][0])) / np.cos(k * 20.0)
    assert abs(exact) > 3.1
    assert np.hypot(*size) == pytest.approx(abs(exact), rel=0.02)
    assert np.arctan2(size[1], size[0]) == pytest.approx(np.angle(exact), abs=0.02)


@pytest.mark.wide
def test_a_shaken_slope_swings_as_elements_do(runs):
    """Ten cells to the high ground: velocities to 1 %, twice what they are off by, and phases.

    The energy that leaves goes with their square, and is summed next to edges: to 7 %.
    """
    run, exact = runs("shaken-slope"), shaken.Elements()
    found = {
        name: (velocity, exact.at(*place))
        for name, (place, velocity) in shaken.watched(run).items()
    }
    assert len(found) == 5
    for pair in found.values():
        assert shaken.error(pair) < 0.01
    assert abs(found["upper"][1][0]) > 2.0 * abs(found["lower"][1][0])  # they differ by place
    history, low, high = run.history, shaken.LOW, shaken.HIGH
    late = history["time"] > 5.0 - 1e-9  # two periods
    for face, x, top in (("x-min", 0.0, low), ("x-max", shaken.LENGTH, high)):
        y = np.linspace(0.0, top, 81)
        square = np.abs([exact.at(x, height) for height in y]) ** 2
        power = 0.5 * shaken.SIZE**2 * shaken.DENSITY * np.trapezoid(square @ shaken.SPEEDS, y)
        left = np.ptp(history[f"radiated.{face}"][late]) / np.ptp(history["time"][late])
        assert left == pytest.approx(power, rel=0.07)


def test_elements_of_level_ground_are_exact_far_from_its_sides():
    """At half its own frequency, ten heights from both: sides are felt by less than 0.3 %."""
    own = 0.5 * shaken.SPEEDS[1] / (4.0 * shaken.HIGH)
    found = shaken.Elements(2.0, own, shaken.HIGH, shaken.HIGH, 20.0 * shaken.HIGH).at(200.0)
    assert found[0] == pytest.approx(shaken.level(shaken.HIGH, own), rel=3e-3)
    assert abs(found[1]) < 1e-3
