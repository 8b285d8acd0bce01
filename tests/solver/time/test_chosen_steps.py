"""``step: {courant: auto}``: as long as is stable, whatever moves, and watched for energy."""

import json

import numpy as np
import pytest
from scenes import SOFT, box, energy, scene, start
from tiers import wide

from pgimp.errors import RunError
from pgimp.solver.state.vertex_motion import begin_motion
from pgimp.solver.time import energy_watch
from pgimp.solver.time.energy_watch import EnergyWatch

pytestmark = pytest.mark.slow(30)

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


def waves(lengths, cells, per_cell):
    """Waves of some lengths in cells that begin in a free bar, initial configuration."""
    body = box([2.0], [2.0 + cells]) | {"formulation": "total-lagrangian"}
    case = scene(1, body, cells=[cells + 4], end=40.0, step={"courant": "auto"},
                 per_cell=per_cell)  # fmt: skip
    case["materials"]["soft"] = SOFT | {"young": 1.0, "poisson": 0.0}
    sim = start(case)
    p, rows = sim.particles, sim.live()
    gradients = np.zeros((p.capacity, 1, 1))
    for length in lengths:
        k = 2.0 * np.pi / length
        p.v[rows, 0] += 1e-4 * np.cos(k * (p.x[rows, 0] - 2.0))
        gradients[rows, 0, 0] -= 1e-4 * k * np.sin(k * (p.x[rows, 0] - 2.0))
    begin_motion(sim.rank, gradients)
    sim.watch.begin(sim.rank)
    return sim


@pytest.mark.parametrize("per_cell", [1, 2])
@pytest.mark.parametrize("lengths", [[4], [6], [8], [12], [24], [24, 12, 8, 6, 4]])
def test_linear_waves_make_no_energy(lengths, per_cell):
    """That half a step lies between velocities and places swung by a third, and looked like it."""
    sim = waves(lengths, 24, per_cell)
    first, most = energy(sim.diagnostics()), 0.0
    while not sim.finished:
        sim.advance()
        most = max(most, energy(sim.diagnostics()))
    assert most > (1.3 if max(lengths) < 10 else 1.05) * first  # as velocities are late
    assert sim.watch.part == 1.0 and not sim.watch.said


@pytest.mark.parametrize(("affine", "too_long"), [(False, 1.2), (True, 1.12), (True, 1.2)])
def test_waves_in_steps_that_are_too_long_gain_little(affine, too_long):
    """A tenth of the step is what `auto` stays below the limit; what grows is found in time."""
    case = bar(end=10.0)
    case["method"]["affine"] = affine
    sim = start(case)
    p, rows = sim.particles, sim.live()
    p.v[rows, 0] = 1e-3 * np.cos(2.0 * np.pi * (p.x[rows, 0] - 2.0) / 8.0)
    p.v[rows] += 1e-7 * np.random.default_rng(1).standard_normal(p.v[rows].shape)
    sim.watch.begin(sim.rank)
    sim.clock._courant *= too_long
    first, most = energy(sim.diagnostics()), 0.0
    while not sim.finished:
        sim.advance()
        most = max(most, energy(sim.diagnostics()))
    assert sim.watch.part == 0.75 and len(sim.watch.said) == 1
    assert most < 6.0 * first  # measured 4.8, 3.7, 4.3: it trebles in a step
    assert energy(sim.diagnostics()) < 0.6 * first


def test_a_look_goes_on_from_a_checkpoint():
    """Wherever it is in its row of steps; older checkpoints have fewer numbers."""
    sims = [shaken(bar(per_cell=4, end=20.0), 1e-5) for _ in range(2)]
    seen = set()
    for sim in sims:
        sim.clock._courant = 0.5
    while not sims[0].watch.said:
        for sim in sims:
            sim.advance()
        sim.watch, before = EnergyWatch(sim.watch.speed), sim.watch
        sim.watch.numbers, sim.watch.said = json.loads(json.dumps(before.numbers)), before.said
        assert sim.watch.numbers == before.numbers == sims[0].watch.numbers
        assert sim.watch.close == before.close
        seen.add(len(before.numbers))
    assert sims[1].watch.said == sims[0].watch.said and seen == {6, 9, 12}
    sim.watch.numbers = before.numbers[:4]
    assert not sim.watch.close and sim.watch.numbers[:4] == before.numbers[:4]


def test_a_run_that_blows_up_is_ended(monkeypatch):
    monkeypatch.setattr(energy_watch, "SHORTER", 1.0)
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


@pytest.mark.parametrize("affine", [False, wide(True)])
def test_rubber_with_mean_dilatation_meets_a_wall_and_makes_no_energy(affine):
    """One particle a cell: in steps that are stable without `mean` it blows up."""
    rubber = SOFT | {"poisson": 0.499}
    case = scene(2, box([3.3, 0.5], [7.3, 4.5], [0.3, -1.0]), cells=[11, 8], per_cell=1, end=0.3,
                 step={"courant": "auto"}, materials={"soft": rubber},
                 boundaries={"y-min": "unilateral"})  # fmt: skip
    case["method"] |= {"volumetric": "b-bar", "affine": affine}
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
