"""Time: whole numbers of fixed steps, and steps from the Courant number between stops."""

from fractions import Fraction
from math import inf, nan

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenes import box, finish, scene, start

from pgimp.errors import RunError
from pgimp.solver.time.clock import START, CourantClock, FixedClock, Step


def ticks(clock, rate=lambda time: 1.0):
    """Steps of a clock: (time before, dt, time after, rate)."""
    steps = []
    done = START
    while not clock.finished(done):
        before, speed = clock.time(done), rate(clock.time(done))
        done = clock.next(done, speed)
        assert (done.number, done.start) == (len(steps) + 1, before)
        assert clock.time(done) == pytest.approx(done.end, rel=1e-15)
        steps.append((before, done.dt, clock.time(done), speed))
        assert clock.after(done.number, clock.time(done), done.dt).end == done.end
    return steps


def test_the_paper_takes_20000_steps_to_2():
    """A running sum of 1e-4 passes 2.0 after 20,001."""
    steps = ticks(FixedClock(1e-4, 2.0))
    assert len(steps) == 20_000
    assert [after for _, _, after, _ in steps] == [(n + 1) * 1e-4 for n in range(19_999)] + [2.0]
    assert {dt for _, dt, _, _ in steps} == {1e-4}


@settings(deadline=None)
@given(mantissa=st.integers(1, 9999), exponent=st.integers(-9, 3), count=st.integers(1, 2000))
def test_fixed_steps_are_multiples_and_end_where_the_case_says(mantissa, exponent, count):
    step = float(f"{mantissa}e{exponent}")
    end = float(Fraction(f"{mantissa}e{exponent}") * count)  # as one would write it
    steps = ticks(FixedClock(step, end))
    assert len(steps) == count
    assert all(after == (n + 1) * step for n, (_, _, after, _) in enumerate(steps[:-1]))
    assert steps[-1][2] == end
    assert end == pytest.approx(count * step, rel=1e-15)


@settings(deadline=None)
@given(
    end=st.floats(1e-6, 1e6),
    stops=st.lists(st.floats(0.0, 1.0), max_size=4),
    courant=st.floats(0.01, 1.0),
    steps=st.floats(0.1, 300.0),
)
def test_controlled_steps_meet_the_stops_and_divide_the_way_to_them_evenly(
    end, stops, courant, steps
):
    limit = end / steps
    stops = sorted({stop * end for stop in stops} - {0.0} | {end})
    legs = list(zip([0.0, *stops], stops, strict=False))
    assume(min(b - a for a, b in legs) > 1e-9 * end)  # nearer ones cannot be told from rounding
    done = ticks(CourantClock(courant, end, tuple(stops)), lambda time: courant / limit)
    met = [after for _, _, after, _ in done if after in stops]
    assert met == stops
    for last, stop in legs:
        within = [dt for before, dt, _, _ in done if last <= before < stop]
        needed = (stop - last) / limit
        # No more steps than needed (at a whole number rounding may cost one), all alike.
        assert needed * (1 - 1e-9) <= len(within) < needed + 1 + 1e-9
        assert max(within) <= limit * (1 + 1e-9)
        assert max(within) - min(within) <= 1e-9 * max(within) + 4e-15 * end


@settings(deadline=None)
@given(
    speeds=st.lists(st.floats(1.0, 20.0), min_size=1, max_size=30),
    stops=st.lists(st.floats(0.01, 0.99), max_size=3),
)
def test_controlled_steps_follow_the_speed_without_tiny_steps(speeds, stops):
    sequence = iter(speeds * 1000)
    done = ticks(CourantClock(0.5, 1.0, tuple(stops)), lambda time: next(sequence) * 10.0)
    assert done[-1][2] == 1.0
    assert {after for _, _, after, _ in done} >= set(stops)
    for before, dt, after, speed in done:
        limit = 0.5 / speed
        left = min(stop for stop in [*stops, 1.0] if stop > before) - before
        assert after > before and dt <= limit * (1 + 1e-9)
        assert after - before == pytest.approx(dt, rel=1e-9, abs=1e-15)
        # Short only where a stop is near, and then in one step: never more than halved.
        assert dt >= 0.5 * min(limit, left) * (1 - 1e-9)


def test_a_controlled_run_meets_its_stops_at_the_courant_number_asked_for():
    case = scene(
        1,
        box([2.0], [5.0], [0.5]),
        end=1.0,
        step={"courant": 0.3},
        output={"at": [0.123, 0.5], "every": 0.07},
    )
    sim = start(case)
    limit = 0.3 / (10.0 + 0.5)  # (c + |v|)/L of a bar that flies unstrained
    times, steps = [], []
    while not sim.finished:
        sim.advance()
        times.append(sim.time)
        steps.append(sim.dt)
    assert {0.123, 0.5, 1.0} <= set(times)
    assert not {0.07, 0.14} & set(times), "output.every never changes a step"
    assert len(times) == 5 + 14 + 18  # whole numbers of steps to each: 0.123/limit = 4.3, ...
    assert max(steps) <= limit * (1 + 1e-12)


def test_a_fixed_run_ends_where_the_case_says():
    sim = finish(start(scene(1, box([2.0], [5.0]), end=0.7, step=0.1)))
    assert (sim.step, sim.time) == (7, 0.7)  # seven times 0.1 is 0.7000000000000001


@pytest.mark.parametrize("rate", [1e17, inf, nan])
def test_a_run_that_would_never_end_is_stopped(rate):
    with pytest.raises(RunError, match="blown up"):
        CourantClock(0.3, 1.0, ()).next(START, rate)


def test_a_run_whose_step_collapses_is_stopped():
    clock = CourantClock(0.3, 1.0, (), rest_rate=2.0)
    clock.next(START, 1.9e5)  # as fast as never, with 6e5 steps to the end
    with pytest.raises(RunError, match="at rest"):
        clock.next(START, 2.1e5)
    CourantClock(0.3, 1.0, (), rest_rate=0.0).next(START, 2.1e5)  # no waves at rest
    late = Step(70_000, 0.999, 1e-6, 0.999)
    clock.next(late, 2.1e5)  # the rest takes no week


def test_a_simulation_knows_its_waves_at_rest():
    sim = start(scene(1, box([2.0], [5.0], [0.5]), end=1.0, step={"courant": 0.3}))
    assert sim.clock.rest_rate == pytest.approx(10.0, rel=1e-12)
