"""Runs that come to rest before time 0."""

import numpy as np
import pytest
from scenes import box, finish, scene, start

import pgimp
from pgimp.errors import CaseError, RunError

pytestmark = pytest.mark.slow(40)

CONFIGURATIONS = ("current", "initial")
DAMPED = (None, {"mass": 1.5}, {"local": 0.2}, {"kinetic": True})


def column(configuration, tolerance=1e-4, height=6, **parts):
    """A column of weight 6 on the floor, between smooth walls."""
    body = box([0.0, 0.0], [1.0, height]) | {"formulation": configuration}
    walls = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}
    parts = {"end": 1.0, "step": {"courant": 0.3}} | parts
    return scene(2, body, cells=[1, 7], boundaries=walls, gravity=[0.0, -1.0],
                 start={"equilibrate": {"tolerance": tolerance}}, **parts)  # fmt: skip


def settled(case):
    """A simulation at time 0."""
    sim = start(case)
    while sim.settling:
        assert sim.time == 0.0
        sim.advance()
    return sim


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
@pytest.mark.parametrize("damping", DAMPED)
def test_a_column_bears_its_weight_from_time_zero_on(configuration, damping):
    parts = {"damping": damping} if damping else {}
    sim = settled(column(configuration, **parts))
    steps, line = sim.step, sim.diagnostics()
    assert steps > 0 and steps % 10 == 0
    assert line["time"] == 0.0 and line["step"] == steps and line["dt"] == 0.0
    for name in ("kinetic-energy", "external-work", "dissipated-energy", "momentum-y"):
        assert line[name] == 0.0
    assert line["strain-energy"] > 0.2
    assert ("damped-energy" in line) == bool(damping)
    centre = line["body.body.centre-y"]
    pressed = 36.0 / (3.0 * 134.6)  # by its own weight
    assert centre == pytest.approx(3.0 - pressed, abs=5e-3)
    line = finish(sim).diagnostics()
    assert line["time"] == 1.0 and line["step"] > steps
    assert line["body.body.centre-y"] == pytest.approx(centre, abs=3e-4)
    assert line["reaction.y-min-y"] == pytest.approx(6.0, rel=1e-3)
    assert line["kinetic-energy"] < 1e-6 * line["strain-energy"]


def test_the_run_may_be_shorter_than_a_step():
    """Who wants the state at rest alone gives a tiny end: steps to rest stay as long as before."""
    assert settled(column("initial", end=1e-7)).step == settled(column("initial")).step


def test_displacements_begin_at_time_zero():
    sim = settled(column("current", output={"every": 1.0, "fields": ["displacement"]}))
    rows = sim.live()
    assert np.array_equal(sim.particles.origin[rows], sim.particles.x[rows])
    assert not sim.particles.v[rows].any()
    assert np.abs(sim.particles.F[rows, 3] - 1.0).max() > 0.02  # while deformation stays


def test_a_body_that_only_tractions_hold_comes_to_rest():
    """Stresses balance them at every vertex, which leaves nothing to compare with but them."""
    pull = {"body": "body", "traction": [1.0, 0.0]}
    case = scene(2, box([2.0, 2.0], [6.0, 4.0]), cells=[8, 6], end=0.5, step={"courant": 0.3},
                 tractions={"right": pull | {"face": "x-max"},
                            "left": pull | {"face": "x-min", "traction": [-1.0, 0.0]}},
                 start={"equilibrate": {}})  # fmt: skip
    sim = settled(case)
    sigma = sim.particles.sigma[sim.live(), 0]
    assert sigma.mean() == pytest.approx(1.0, rel=1e-2)
    assert sim.unbalanced < 1e-4


def test_without_loads_there_is_nothing_to_settle():
    case = column("current")
    del case["gravity"]
    assert settled(case).step == 10


def test_no_rest_ends_the_run_with_what_to_do():
    case = column("current")
    case["start"]["equilibrate"]["steps"] = 20
    with pytest.raises(
        RunError, match=r"start\.equilibrate: no rest after 20 steps: .* not 0\.0001"
    ):
        settled(case)


def test_what_falls_freely_has_no_rest():
    case = scene(1, box([1.0], [3.0]), gravity=[0.01], step={"courant": 0.3},
                 start={"equilibrate": {"steps": 40}})  # fmt: skip
    with pytest.raises(RunError, match=r"no rest after 40 steps: the unbalanced force is 0.5"):
        settled(case)


def test_fixed_steps_count_on_and_time_does_not():
    sim = settled(column("current", step=0.02, end=0.1))
    before = sim.step
    finish(sim)
    assert sim.step == before + 5 and sim.time == 0.1


def test_stages_do_not_settle_again():
    case = column("current", end=0.2)
    case["time"]["stages"] = [{"name": "more", "end": 0.4, "gravity": [0.0, -2.0]}]
    sim = settled(case)
    while not sim.finished:
        sim.advance()
        assert not sim.settling
    assert sim.stage == 1 and sim.time == 0.4


@pytest.mark.parametrize(
    ("parts", "where"),
    [
        ({"boundaries": {"x-min": {"velocity": [1.0, None]}}}, r"boundaries\.x-min"),
        (
            {"constraints": {"grip": {"body": "body", "velocity": [0.5, None],
                                      "region": {"box": {"min": [0.0, 0.0], "max": [1.0, 1.0]}}}}},
            r"constraints\.grip\.velocity",
        ),
        ({"bodies": {"body": box([0.0, 0.0], [1.0, 1.0], [0.0, 1.0])}}, r"bodies\.body\.velocity"),
    ],
)  # fmt: skip
def test_what_moves_at_time_zero_is_refused(parts, where):
    with pytest.raises(CaseError, match=where + r": moves at time 0"):
        pgimp.load(column("current") | parts)


@pytest.mark.parametrize("key", ["damping", "start"])
def test_rigid_bodies_that_move_freely_are_refused(key):
    case = column("current")
    ball = {"centre": [0.5, 6.4], "radius": 0.3}
    case["bodies"]["ball"] = {"rigid": {"density": 1.0}, "region": {"ball": ball}}
    if key == "damping":
        del case["start"]
        case["damping"] = {"mass": 1.0}
    with pytest.raises(CaseError, match=rf"{key}.*'ball' is rigid and moves freely"):
        pgimp.load(case)


@pytest.mark.parametrize(
    ("damping", "text"),
    [
        ({}, r"damping: expected one of \{mass: RATE\}"),
        ({"mass": -1.0}, r"damping\.mass: must be above 0"),
        ({"local": 1.0}, r"damping\.local: must be below 1"),
    ],
)
def test_damping_needs_a_kind_and_numbers_within_range(damping, text):
    with pytest.raises(CaseError, match=text):
        pgimp.load(column("current") | {"damping": damping})


def test_local_damping_beside_contact_is_refused():
    case = column("current", damping={"local": 0.2}, contact=[{"bodies": "all"}])
    with pytest.raises(CaseError, match=r"damping\.local: is a part .* before contact"):
        pgimp.load(case)


def test_frames_history_and_log_begin_with_the_state_at_rest(tmp_path):
    run = pgimp.run(column("current", end=0.1), output=tmp_path / "run", quiet=True)
    first, line = run.frames[0], run.history[0]
    assert first.time == line["time"] == 0.0
    assert first.step == line["step"] > 0
    assert np.abs(first["stress"][:, 1]).max() > 5.0
    log = " ".join((tmp_path / "run" / "log.txt").read_text().split())
    assert f"settled in {first.step} steps: the unbalanced force is" in log


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_a_probe_follows_the_particle_that_was_closest_without_load(configuration, tmp_path):
    """The one at the end of a cell, which sinks by more than half of it, also after a resume."""
    case = column(configuration, end=0.1, damping={"kinetic": True})
    case |= {"output": {"every": 0.1, "fields": ["displacement"]},
             "probes": {"mark": {"body": "body", "at": [0.25, 5.49]}},
             "checkpoint": {"every": {"steps": 10}, "keep": 10000}}  # fmt: skip
    run = pgimp.run(case, output=tmp_path, quiet=True)

    def displacements():
        mark = pgimp.open(tmp_path).probes["mark"]
        return np.stack([mark["displacement-x"], mark["displacement-y"]], axis=1)

    first, found = run.frames[0], displacements()
    number = pgimp.Simulation(case | {"start": {}}).particles
    at = number["position"][:, :2]
    followed = number["id"][np.argmin(np.abs(at - [0.25, 5.49]).sum(axis=1))]
    assert at[followed].tolist() == [0.25, 5.25]
    row = np.searchsorted(first["id"], followed)
    assert np.array_equal(found[0], first["displacement"][row, :2])
    if configuration == "initial":
        assert found[0, 1] < -0.1
    mark = run.probes["mark"]
    assert mark["position-y"][0] == pytest.approx(first["position"][row, 1], abs=1e-15)
    assert np.array_equal(found[-1], run.frames[-1]["displacement"][row, :2])
    for path in sorted((tmp_path / "checkpoints").iterdir())[2:]:
        path.unlink()
    assert first.step > 20
    pgimp.run(case, output=tmp_path, quiet=True, resume=True)
    assert np.array_equal(displacements(), found)
