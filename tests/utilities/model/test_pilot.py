"""Steps predicted by a pilot run against the steps that runs take, where waves become faster."""

from math import cos, inf, pi

import pytest
from mentioned import mentions

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation
from pgimp.solver.time.held_rate import HeldRate
from pgimp.utilities.check.steps import predicted
from pgimp.utilities.model import pilot as pilots
from pgimp.utilities.model.costs import Costs
from pgimp.utilities.model.pilot import coarse, pilot

pytestmark = pytest.mark.slow(20)

#: 50 us a step and 0.2 us a particle, as on a laptop: what the machine measures must not matter.
COSTS = Costs(50e-6, ((100, 0.2e-6), (10_000, 0.2e-6)), 0.0)


def squeezed(**more):
    """A column pressed by its weight, tenfold in the end, to some four fifths of its height."""
    return Case.model_validate(
        {
            "format": 1,
            "dimensions": 2,
            "grid": {"size": [1.0, 2.5], "cell": [0.0625, 0.0625]},
            "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
            "time": {"end": 1.0, "step": {"courant": 0.3}},
            "materials": {
                "m": {"model": "neo-hookean", "young": 1e5, "poisson": 0.3, "density": 1000.0}
            },
            "bodies": {
                "b": {"material": "m", "region": {"box": {"min": [0.0, 0.0], "max": [1.0, 2.0]}}}
            },
            "gravity": {"table": [[0.0, [0.0, 0.0]], [1.0, [0.0, -60.0]]]},
            "boundaries": {"x-min": "slip", "x-max": "slip", "y-min": "fixed"},
        }
        | more
    )


@pytest.fixture(scope="module")
def run():
    """The whole run: its steps, and those that its first step lets expect."""
    sim = Simulation(squeezed(), Serial())
    expected = sim.case.time.end / sim.clock.next(sim.done, sim.rate).dt
    while not sim.finished:
        sim.advance()
    return sim, expected


def test_steps_are_predicted_where_the_wave_becomes_faster(run, monkeypatch):
    sim, expected = run
    assert sim.step > 1.1 * expected
    for seconds, factor in ((10.0, 1.0), (0.05, 1.5)):
        monkeypatch.setattr(pilots, "_SECONDS", seconds)
        monkeypatch.setattr(pilots, "perf_counter", lambda: 0.0)
        found = pilot(sim.case, sim.count, expected, COSTS, 16.0)
        assert found.factor == 1.0 if factor == 1.0 else found.factor > factor
        assert found.done == 1.0 and not found.failure
        assert found.steps == pytest.approx(sim.step, rel=0.05)


def test_a_pilot_run_tells_the_strain_of_each_body(run, monkeypatch):
    """At the foot of the column it is that of the run's own particles, to the cells."""
    sim, expected = run
    monkeypatch.setattr(pilots, "_SECONDS", 10.0)
    found = pilot(sim.case, sim.count, expected, COSTS, 16.0)
    height = sim.particles.F[sim.live(), 3]  # of a column whose sides are held
    assert 0.3 < found.strains["b"] == pytest.approx(1.0 - height.min(), rel=0.1)


def test_a_pilot_run_that_takes_too_long_is_ended(run, monkeypatch):
    sim, expected = run
    ticks = iter(range(10**6))
    monkeypatch.setattr(pilots, "perf_counter", lambda: next(ticks) * 0.01)
    found = pilot(sim.case, sim.count, expected, COSTS, 6.0)  # coarser cells are not allowed
    assert 0.0 < found.done < 1.0
    assert expected < found.steps < 1.2 * sim.step
    said = predicted(sim.case, found)
    assert f"if waves stay as fast as at t = {found.done:.3g}, where a pilot run of" in said
    assert "ran out of time; more if they become faster" in said


def test_a_pilot_run_that_takes_too_long_is_repeated_on_coarser_cells(run, monkeypatch):
    sim, expected = run
    ticks = iter(range(10**6))
    monkeypatch.setattr(pilots, "perf_counter", lambda: next(ticks) * 0.01)
    found = pilot(sim.case, sim.count, expected, COSTS, 16.0)
    assert found.done == 1.0 and found.factor > 1.2
    assert found.steps == pytest.approx(sim.step, rel=0.1)


HALF = {
    "pressed to half its height": {
        "gravity": [0.0, 0.0],
        "constraints": {
            "top": {
                "body": "b",
                "region": {"box": {"min": [0.0, 1.7], "max": [1.0, 2.0]}},
                "velocity": [0.0, -1.0],
            }
        },
    },
    "falls at a third of its wave speed": {
        "gravity": [0.0, 0.0],
        "bodies": {
            "b": {
                "material": "m",
                "region": {"box": {"min": [0.0, 0.25], "max": [1.0, 2.25]}},
                "velocity": [0.0, -4.0],
            }
        },
        "boundaries": {"x-min": "slip", "x-max": "slip", "y-min": "unilateral"},
        "grid": {"size": [1.0, 4.0], "cell": [0.0625, 0.0625]},
        "time": {"end": 0.5, "step": {"courant": 0.3}},
    },
}


@pytest.mark.parametrize("kind", HALF)
def test_steps_are_within_a_tenth_where_said(kind, monkeypatch):
    """Waves become much faster, early or late; half of the cells, and fewer, predict the steps."""
    case = squeezed(**HALF[kind])
    sim = Simulation(case, Serial())
    expected = case.time.end / sim.clock.next(sim.done, sim.rate).dt
    while not sim.finished:
        sim.advance()
    assert sim.step > 1.04 * expected
    monkeypatch.setattr(pilots, "perf_counter", lambda: 0.0)
    for seconds in (0.1, 0.03):
        monkeypatch.setattr(pilots, "_SECONDS", seconds)
        found = pilot(case, sim.count, expected, COSTS, 16.0)
        assert found.factor > 1.0 and found.done == 1.0 and 0.0 < found.error < 0.1
        assert found.steps == pytest.approx(sim.step, rel=0.1)
        assert predicted(case, found).startswith(f"about {found.steps:,.0f} to t = ")


def test_what_cells_do_to_the_prediction_is_said():
    case = squeezed()
    fine = pilots.Pilot(1000.0, 500, 2.0, 1.0, "", 0.3)
    assert pilots._error(fine, fine._replace(steps=800.0, factor=2.5)) == pytest.approx(0.5)
    assert pilots._error(fine, fine._replace(factor=2.6)) == pytest.approx(0.05)
    for other in (None, fine, fine._replace(factor=2.6, done=0.9)):
        assert pilots._error(fine, other) == inf
    said = predicted(case, fine._replace(error=0.2))
    mentions(said, "roughly 1,000", "t = 1", "pilot run of 500 particles")
    failed = fine._replace(done=0.5, failure="x")
    assert "if waves stay as fast as at t = 0.5, where" in predicted(case, failed)
    assert "failed; more if they become faster" in predicted(case, failed)


@pytest.mark.parametrize("longer", [1, 3, 10])
@pytest.mark.parametrize("period", [0.3, 3.0, 30.0])
def test_steps_are_counted_as_the_run_takes_them(period, longer):
    """Short at once, long rarely: in a vibration steps stay short, after it they lengthen."""

    def rate(time):
        return 10.0 + 2.0 * cos(2.0 * pi * time / period) if time < 30.0 else 9.0

    held, time, steps = HeldRate(), 0.0, 0
    while time < 60.0:
        time, steps = time + 0.3 / held.follow(rate(time)), steps + 1
    own, time = pilots._OwnSteps(0.3), 0.0
    while time < 60.0:  # the pilot's steps are longer
        own.take(longer * 0.03, rate(time))
        time += longer * 0.03
    # By the average rate there would be 11 % fewer where the vibration is not followed.
    assert own.count == pytest.approx(steps, rel=0.02)


def test_a_pilot_run_that_fails_says_so():
    """Flung out of the domain."""
    case = squeezed(boundaries={}, gravity=[0.0, -60.0])
    found = pilot(case, 2048, 100.0, COSTS, 16.0)
    assert "left the domain through y-min" in found.failure
    assert "\n" not in found.failure
    assert found.done < 0.5


def test_a_fixed_step_keeps_its_number_and_its_courant_number():
    case = squeezed()
    longest = 0.3 * 0.0625 / 11.6  # the wave at rest has 11.6 m/s
    case = squeezed(time={"end": 640 * longest, "step": longest})
    found = pilot(case, 2048, 640.0, COSTS, 16.0)
    assert found.steps == 640.0
    assert 0.32 < found.courant < 0.6


def test_no_pilot_run_of_what_cannot_be_coarse(monkeypatch):
    """Constraints hold a row of particles, which may lie elsewhere on other grids."""
    row = {"box": {"min": [0.0, 0.07], "max": [1.0, 0.09]}}
    case = squeezed(constraints={"g": {"body": "b", "velocity": [0, 0], "region": row}})
    with pytest.raises(CaseError, match="contains no particle"):
        Simulation(coarse(case, 1.5), Serial())
    monkeypatch.setattr(pilots, "_SECONDS", 0.05)
    found = pilot(case, 2048, 600.0, COSTS, 16.0)
    assert found is None or found.factor > 1.0
