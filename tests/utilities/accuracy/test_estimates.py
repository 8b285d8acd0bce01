"""Errors from differences of curves: known orders, crossings, means between lines, text."""

import numpy as np
import pytest

from pgimp.case.accuracy.entry import Accuracy
from pgimp.utilities.accuracy.aligned import Curve, aligned, curve_of, has_error
from pgimp.utilities.accuracy.estimate import edges, estimate, order_of, ratio_of
from pgimp.utilities.accuracy.forecast import Cost, seconds_of
from pgimp.utilities.accuracy.found import with_error
from pgimp.utilities.accuracy.quantity import found

TIMES = np.linspace(0.0, 2.0, 201)


def curve(x, p, times=TIMES):
    """An oscillation whose phase and size are off by x^p, x being the cells."""
    off = 0.02 * x**p
    return Curve(times, (1.0 + off) * np.sin(2.0 * np.pi * times * (1.0 + 0.3 * off)), False)


@pytest.mark.parametrize("p", [1.0, 1.5, 2.0])
def test_true_errors_are_within_twice_the_estimate(p):
    exact, fine = np.sin(2.0 * np.pi * TIMES), curve(1.0, p)
    for sizes in ([2.0, 4.0], [1.5, 3.0], [2.0]):
        one = estimate(fine, [(x, curve(x, p, np.linspace(0.0, 2.0, 777))) for x in sizes])
        true = np.abs(fine.values - exact)
        assert (true <= 2.0 * one.errors + 1e-9)[1:].all()
        assert one.errors.mean() < 5.0 * true.mean()
        if len(sizes) > 1:
            assert one.order == pytest.approx(p, abs=0.1)
        else:
            assert one.order is None


def test_a_crossing_of_curves_is_no_small_error():
    """Two sines out of phase agree where they cross, and are off there as elsewhere."""
    one = estimate(curve(1.0, 1.0), [(2.0, Curve(TIMES, np.cos(2.0 * np.pi * TIMES), False))])
    difference = np.abs(one.curve.values - one.others[0])
    assert difference.min() < 0.05 * difference.max()
    assert one.errors.min() > 0.2 * difference.max()


def test_a_quantity_has_the_error_of_its_own_time():
    runs = [(x, curve(x, 2.0)) for x in (2.0, 4.0)]
    fine, exact = curve(1.0, 2.0), {"max": 1.0, 0.75: -1.0, "end": 0.0}
    for at, value in exact.items():
        one = found(Accuracy(of="a", at=at, within=1.0), fine, runs)
        assert abs(abs(one.value) - abs(value)) <= 2.0 * one.error
        assert one.error < 0.2
    mean = found(Accuracy(of="a", at={"mean": [0.0, 0.5]}, within="2 %"), fine, runs)
    assert abs(mean.value - 2.0 / np.pi) <= 2.0 * mean.error < 0.1


def test_the_order_is_kept_within_bounds():
    assert order_of(4.0, (2.0, 4.0)) == pytest.approx(2.0)
    assert order_of(2.0, (2.0, 4.0)) == pytest.approx(1.0)
    assert order_of(100.0, (2.0, 4.0)) == 2.0
    assert order_of(0.3, (2.0, 4.0)) == 0.5
    same = estimate(curve(1.0, 1.0), [(2.0, curve(1.0, 1.0)), (4.0, curve(1.0, 1.0))])
    assert same.errors.max() < 1e-15


@pytest.mark.parametrize("alike, order", [(True, 2.0), (False, 1.0)])
def test_an_order_above_one_counts_as_far_as_differences_agree(alike, order):
    """A difference that is small and goes another way than the coarse one may be so by chance."""
    angle = 2.0 * np.pi * TIMES
    near = Curve(TIMES, 0.1 * np.sin(angle), False)
    far = near._replace(values=near.values + (np.sin if alike else np.cos)(angle))
    one = estimate(Curve(TIMES, np.zeros(len(TIMES)), False), [(2.0, near), (4.0, far)])
    assert one.order == pytest.approx(order, abs=0.01)


def test_directions_that_keep_their_cells_do_not_count():
    assert ratio_of([0.5, 0.2], [0.25, 0.2]) == 2.0
    assert ratio_of([0.5, 0.41], [0.25, 0.2]) == pytest.approx(2.05)


def test_means_between_lines_are_compared_over_the_same_times():
    """A force in lines of its mean: what counts is its impulse, wherever the lines are."""
    fine = Curve(np.array([0.0, 1.0, 2.0]), np.array([0.0, 3.0, 5.0]), True)
    parts = Curve(np.array([0.0, 0.5, 1.5, 2.0]), np.array([0.0, 2.0, 4.0, 6.0]), True)
    np.testing.assert_allclose(aligned(parts, fine), [0.0, 3.0, 5.0])
    plain = aligned(parts._replace(mean=False), fine)
    np.testing.assert_allclose(plain, [0.0, 3.0, 6.0])
    short = Curve(np.array([0.0, 1.0]), np.array([1.0, 1.0]), False)
    assert np.isnan(aligned(short, fine)[-1])


def test_columns_that_are_means_and_columns_without_errors():
    lines = np.zeros(3, dtype=[("time", float), ("reaction.x-min-x", float), ("mass", float)])
    lines["time"], lines["mass"] = [0.0, 1.0, 1.0], [1.0, 2.0, 3.0]
    assert curve_of(lines, "reaction.x-min-x").mean and not curve_of(lines, "mass").mean
    np.testing.assert_array_equal(curve_of(lines, "mass").values, [1.0, 3.0])
    assert not any(map(has_error, ("time", "step", "volume", "rigid.a.penetrating-particles")))
    assert has_error("volume.a") and has_error("contact.a+b.area")


def test_costs_grow_with_particles_beside_what_a_step_costs_itself():
    def cost(particles, steps):
        return Cost(particles, steps, steps * (1e-3 + 1e-6 * particles))

    known = [(2.0, cost(1000.0, 100.0)), (4.0, cost(250.0, 50.0))]
    assert seconds_of(known, 2) == pytest.approx(200.0 * (1e-3 + 1e-6 * 4000.0))
    assert seconds_of(known[:1], 2) == pytest.approx(200.0 * 4.0 * 2e-3)
    assert seconds_of([], 3) is None


@pytest.mark.parametrize(
    "value, error, text",
    [
        (12.3456, 0.2, "12.35 +- 0.20"),
        (12345.6, 430.0, "12300 +- 400"),
        (0.0245, 5e-5, "0.02450 +- 0.00005"),
        (-2.5e9, 4e7, "(-2.50 +- 0.04)e+09"),
        (0.0, 0.0, "0 +- 0"),
        (1.0, np.nan, "1, of unknown error"),
    ],
)
def test_values_have_the_digits_that_their_errors_tell(value, error, text):
    assert with_error(value, error) == text


def test_cells_are_told_by_one_edge_or_all():
    assert edges([0.2, 0.19999999999999998, 0.2]) == "0.2"
    assert edges([0.1, 0.2, 0.1]) == "0.1 x 0.2 x 0.1"
