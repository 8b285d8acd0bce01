"""Steps that shorten at once and lengthen rarely, so that they do not feed vibrations."""

from math import cos, nan, pi, sqrt

import numpy as np
import pytest
from scenes import box, energy, scene, start

from pgimp.solver.heldrate import FIRST, LONGEST, WORTH, HeldRate
from pgimp.solver.state import State, capture


def held(rates):
    """The rates that are held while `rates` come."""
    rate = HeldRate()
    return [rate.follow(each) for each in rates], rate


@pytest.mark.parametrize("period", [20, 60, 170, 400])
def test_a_vibration_is_followed_a_few_times_only(period):
    """As often as windows double, and then never again."""
    rates = [1.0 + 0.1 * cos(2.0 * pi * n / period) for n in range(100 * period)]
    found, rate = held(rates)
    assert rate.lengthened <= 4
    assert set(found[10 * period :]) == {max(rates)}
    assert all(a >= b for a, b in zip(found, rates, strict=True))


def test_after_an_impact_steps_are_long_again():
    found, _ = held([1.0] * 50 + [3.0] * 500 + [1.0] * 500)
    assert found[50:550] == [3.0] * 500
    assert set(found[550 + 2 * FIRST :]) == {1.0}


def test_what_is_hardly_worth_it_is_not_taken():
    found, rate = held([1.0 + 0.9 * WORTH] + [1.0] * 5 * LONGEST)
    assert set(found) == {1.0 + 0.9 * WORTH} and not rate.lengthened


def test_spikes_do_not_hold_a_run_up():
    """A step a hundred times too short every 300 steps costs a few."""
    found, _ = held([100.0 if n % 300 == 0 else 1.0 for n in range(30_000)])
    assert sum(each > 1.0 for each in found) < 0.02 * len(found)


def test_a_rate_that_is_no_number_is_not_hidden_by_one_that_is_held():
    assert held([1.0, nan])[0][-1] != held([1.0, 1.0])[0][-1]


def test_a_checkpoint_in_the_middle_of_a_window_goes_on_with_it():
    rates = 1.0 + np.random.default_rng(1).random(3000)
    for cut in (1, 63, 64, 65, 700, 1501):
        whole, first = held(rates)[0], held(rates[:cut])[1]
        again = HeldRate()
        again.numbers = first.numbers
        assert [again.follow(each) for each in rates[cut:]] == whole[cut:]


def bar(periods):
    """A free bar of ten cells in the initial configuration, in its second mode, and the period."""
    cells, c = 10, sqrt(100.0 * 0.7 / (1.3 * 0.4))
    body = box([2.0], [2.0 + cells]) | {"configuration": "initial"}
    solid = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}
    case = scene(1, body, cells=[cells + 4], end=periods * cells / c, step={"courant": 0.3},
                 materials={"soft": solid})  # fmt: skip
    case["method"]["affine"] = True
    sim = start(case)
    p, rows, k = sim.particles, sim.live(), 2.0 * pi / cells
    p.v[rows, 0] = 0.03 * c * np.cos(k * (p.x[rows, 0] - 2.0))
    p.L[rows, 0] = -0.03 * c * k * np.sin(k * (p.x[rows, 0] - 2.0))
    return sim, cells / c


def test_a_free_bar_keeps_its_energy():
    """Steps that followed the strain gave it 1.45 times its energy in 50 periods."""
    sim, period = bar(50)
    first, found = energy(sim.diagnostics()), []
    while not sim.finished:
        sim.advance()
        if sim.time > 48 * period:
            found.append(energy(sim.diagnostics()) / first)
    assert np.mean(found) == pytest.approx(1.05, abs=0.03)
    state, *_ = capture(sim.rank, sim.now, sim.rate, sim.count, sim.diagnostic_sums,
                        clock=sim.clock)  # fmt: skip
    assert State.model_validate(state).held_rate == sim.clock.held.numbers
