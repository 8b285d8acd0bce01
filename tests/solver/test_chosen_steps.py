"""``step: {courant: auto}``: as long as is stable, whatever moves, and watched for energy."""

import numpy as np
import pytest
from scenes import SOFT, box, energy, scene, start

from pgimp.errors import RunError
from pgimp.solver import energywatch

#: Wave speed of the bar, in cells.
SPEED = 10.0


def bar(velocity=0.0, end=2.0, per_cell=2, shape="gimp", **parts):
    return scene(
        1, box([2.0], [10.0], [velocity]), cells=[100], end=end, step={"courant": "auto"},
        per_cell=per_cell, shape=shape, **parts,
    )  # fmt: skip


def shaken(case, amplitude=1e-3):
    """The case, its particles shaken so that every mode is there."""
    sim = start(case)
    p, rows = sim.particles, sim.live()
    p.v[rows] += amplitude * np.random.default_rng(2).standard_normal(p.v[rows].shape)
    sim.watch.begin(sim.rank)
    return sim


@pytest.mark.parametrize("velocity", [0.0, 5.0, 30.0])
def test_a_body_that_moves_takes_the_steps_of_one_at_rest(velocity):
    """Nine tenths of 0.60 of a cell by waves; half a cell by particles is the most."""
    sim = shaken(bar(velocity))
    first = energy(sim.diagnostics())
    while not sim.finished:
        sim.advance()
        longest = min(0.9 * 0.6 / SPEED, 0.5 / max(velocity, 1e-9))
        assert sim.dt <= longest * (1.0 + 1e-3)
        if sim.time < 1.0:
            assert sim.dt > 0.95 * longest  # evenly to the end
    assert energy(sim.diagnostics()) < first * (1.0 + 1e-6)
    assert not sim.watch.said


def test_steps_that_are_too_long_become_shorter():
    """As if the limit of four particles a cell, 0.48, were thought to be 0.5: it is kept to."""
    sim = shaken(bar(per_cell=4, end=20.0), 1e-5)
    sim.clock._courant = 0.5
    first = energy(sim.diagnostics())
    most = 0.0
    while not sim.finished:
        sim.advance()
        most = max(most, energy(sim.diagnostics()))
    assert sim.watch.part == 0.75
    assert "has come from nothing; from now on steps have" in sim.watch.said[0]
    assert first < most < 20.0 * first  # by what ten steps make of a little; measured 8.4
    assert energy(sim.diagnostics()) < most
    state = sim.watch.numbers
    assert state[0] == sim.watch.part == sim.clock.part


def test_a_run_that_blows_up_is_ended(monkeypatch):
    monkeypatch.setattr(energywatch, "SHORTER", 1.0)
    sim = shaken(bar(per_cell=4, end=20.0), 1e-5)
    sim.clock._courant = 0.7
    with pytest.raises(RunError, match="has come from nothing: the solution is not stable"):
        while not sim.finished:
            sim.advance()


def test_what_falls_and_is_compressed_makes_no_energy():
    """A wall, gravity that grows, a body that meets the wall: nothing to say."""
    case = bar(-1.0, end=3.0, gravity={"table": [[0.0, [0.0]], [1.0, [-5.0]]]},
               boundaries={"x-min": "fixed"})  # fmt: skip
    sim = start(case)
    while not sim.finished:
        sim.advance()
    assert sim.watch.part == 1.0 and not sim.watch.said


@pytest.mark.parametrize("affine", [False, True])
def test_rubber_with_mean_dilatation_meets_a_wall_and_makes_no_energy(affine):
    """One particle a cell: in steps that are stable without `mean` it blows up."""
    rubber = SOFT | {"poisson": 0.499}
    case = scene(2, box([3.3, 0.5], [7.3, 4.5], [0.3, -1.0]), cells=[11, 8], per_cell=1, end=0.3,
                 step={"courant": "auto"}, materials={"soft": rubber},
                 boundaries={"y-min": "separating"})  # fmt: skip
    case["method"] |= {"volumetric": "mean", "affine": affine}
    sim = start(case)
    first = energy(sim.diagnostics())
    while not sim.finished:
        sim.advance()
        # By less than the error of first order of the step in which the wall stops it, 0.02.
        assert energy(sim.diagnostics()) < 1.04 * first
    assert sim.watch.part == 1.0 and not sim.watch.said


def test_what_is_watched_is_what_the_history_says_of_a_metal_that_yields():
    """Its sums have more columns than those of a solid that gives back all."""
    metal = {"model": "von-mises", "young": 100.0, "poisson": 0.0, "density": 1.0,
             "yield-stress": 1.0}  # fmt: skip
    sim = start(bar(-4.0, end=0.6, boundaries={"x-min": "fixed"}, materials={"soft": metal}))
    while not sim.finished:
        sim.advance()
    said = sim.diagnostics()
    assert said["plastic-work"] > 0.01 * said["kinetic-energy"]
    *found, work, mass = sim.watch._sums(sim.rank)
    assert sum(found) == pytest.approx(energy(said), rel=1e-12)
    assert mass == pytest.approx(said["mass"], rel=1e-12)
    assert work == pytest.approx(said["external-work"], abs=1e-12)


def test_what_rests_may_round():
    """No energy at all, but for rounding, is no reason to say anything."""
    sim = start(bar(end=3.0))
    p, rows = sim.particles, sim.live()
    p.v[rows] += 1e-15 * np.random.default_rng(2).standard_normal(p.v[rows].shape)
    while not sim.finished:
        sim.advance()
    assert sim.watch.part == 1.0 and not sim.watch.said
