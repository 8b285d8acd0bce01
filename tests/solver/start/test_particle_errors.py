"""Particles that stop the run: what the message says, and how all ranks end."""

import re

import numpy as np
import pytest
from mentioned import mentions
from processes import PROGRAMS
from scenes import box, finish, scene, start, wall, write_case
from tiers import wide

import pgimp
from pgimp.errors import RunError

MESSAGE = re.compile(
    r"particle (?P<id>\d+) of body '(?P<body>\w+)' (?P<what>.+)\n"
    r"\s+in step (?P<step>\d+) to time (?P<time>\S+) \(dt (?P<dt>\S+)\), at \((?P<place>.+)\), "
    r"velocity\s+\((?P<velocity>.+)\), on rank (?P<rank>\d+)"
    r"(; (?P<others>\d+) others? (is|are) at fault in the same step)?\n"
    r"\s+try: (?P<advice>.+)"
)


def numbers(text):
    return [float(part) for part in text.split(", ")]


def fail(sim):
    """Run until a particle stops it: the message's parts, and the row of that particle."""
    with pytest.raises(RunError) as error:
        finish(sim)
    match = MESSAGE.fullmatch(str(error.value))
    assert match, str(error.value)
    rows = sim.live()
    (row,) = rows[sim.particles.id[rows] == int(match["id"])]
    # What can be checked of any message: it speaks of the particle that it names, and of now.
    assert match["body"] == sim.scene.body_names[sim.particles.body[row]]
    assert int(match["step"]) == sim.step + 1 and match["rank"] == "0"
    assert float(match["time"]) == pytest.approx(sim.time + float(match["dt"]), rel=1e-4)
    np.testing.assert_allclose(numbers(match["place"]), sim.particles.x[row], rtol=1e-5)
    np.testing.assert_allclose(numbers(match["velocity"]), sim.particles.v[row], rtol=1e-3)
    return match, row


def pair(dimension=2, **parts):
    """Two bodies that fly side by side."""
    rest, zeros = [2.0] * (dimension - 1), [0.0] * (dimension - 1)
    high = [4.0] * (dimension - 1)
    bodies = {
        "left": box([1.0, *rest], [3.0, *high], [0.1, *zeros]),
        "right": box([4.0, *rest], [6.0, *high], [0.1, *zeros]),
    }
    return scene(dimension, bodies, **parts)


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("value", [np.nan, -np.inf])
def test_a_deformation_that_is_no_number_is_found_in_the_same_step(dimension, value):
    sim = start(pair(dimension))
    for _ in range(7):
        sim.advance()
    victim = sim.live()[-2]
    sim.particles.F[victim, 0] = value
    match, row = fail(sim)
    assert row == victim and match["body"] == "right" and match["step"] == "8"
    assert "not a finite number" in match["what"]
    assert "smaller steps" in match["advice"]


@pytest.mark.parametrize("name", ["v", "sigma", "V"])
def test_what_spreads_over_the_grid_is_found_in_the_same_step_near_by(name):
    sim = start(pair())
    victim = sim.live()[-1]
    getattr(sim.particles, name)[victim] = np.nan
    place = sim.particles.x[victim].copy()
    match, _ = fail(sim)
    assert match["step"] == "1" and "not a finite number" in match["what"]
    assert match["body"] == "right"
    near = sim.particles.x[sim.particles.id == int(match["id"])]
    assert np.isnan(near).any() or np.abs(near - place).max() < 3.0


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_an_inverted_particle_is_found_in_the_same_step(dimension):
    sim = start(pair(dimension))
    for _ in range(3):
        sim.advance()
    victim = sim.live()[1]
    sim.particles.F[victim, -1] *= -1.0
    match, row = fail(sim)
    assert row == victim and match["step"] == "4"
    assert "inside out (det F <= 0)" in match["what"]
    assert "smaller steps" in match["advice"] and "gimp" in match["advice"]


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_particle_that_leaves_is_named_with_the_face(axis, side):
    velocity = np.zeros(3)
    velocity[axis] = 2.3 * side
    sim = start(scene(3, box([3.0] * 3, [5.0] * 3, velocity.tolist()), end=2.0, step=0.01))
    front = sim.particles.x[sim.live(), axis]
    ids = set(sim.particles.id[sim.live()[front == (front * side).max() * side]].tolist())
    match, _ = fail(sim)
    face = f"{'xyz'[axis]}-{'min' if side < 0 else 'max'}"
    mentions(match["what"], "left the domain", face)
    assert int(match["id"]) in ids
    # 3.25 from the front row to the face, at 0.023 a step.
    assert int(match["step"]) == int(np.ceil(3.25 / 0.023))
    assert "a larger grid" in match["advice"] and "boundaries" in match["advice"]


@pytest.mark.parametrize(("dimension", "axis"), [(1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)])
def test_a_particle_that_moves_by_more_than_a_cell_is_found(dimension, axis):
    sim = start(pair(dimension, cells=[40] * dimension))
    sim.advance()
    right = sim.live()[sim.particles.body[sim.live()] == 1]
    before = sim.particles.x[right, axis].copy()
    sim.particles.v[right, axis] = 99.0  # 0.99 cells: allowed, and as fast the vertices around
    sim.advance()
    np.testing.assert_allclose(sim.particles.x[right, axis] - before, 0.99, rtol=1e-5)
    sim.particles.v[right, axis] = 101.0
    match, row = fail(sim)
    mentions(match["what"], "more than a cell", "one step")
    assert match["step"] == "3" and match["body"] == "right"
    (moved,) = sim.particles.x[row, axis] - before[right == row]
    assert moved == pytest.approx(0.99 + 1.01, rel=1e-5)


def clap(side):
    """A bar whose wall, at x-min or x-max, jumps inwards by more than a cell a step at t = 0.5."""
    low, sign = (0.0, 1.0) if side == "min" else (4.0, -1.0)
    jump = wall([[0.0, 0.0], [0.5, 0.0], [0.51, sign * 300.0]])
    return scene(
        1,
        box([low], [low + 4.0]),
        boundaries={f"x-{side}": jump},
        output={"every": 0.1},
        history={"every": {"steps": 10}},
    )


def test_a_violent_wall_turns_the_particle_next_to_it_inside_out():
    match, _ = fail(start(clap("min")))
    assert (match["id"], match["step"]) == ("0", "51") and "inside out" in match["what"]


@pytest.mark.parametrize(
    "kind", ["one rank", 26, *(wide(kind) for kind in ("every rank", 40, 48, 50))]
)
def test_all_ranks_end_together_with_one_message(tmp_path, mpirun, kind):
    """Also if a frame, a re-sort or the end is due with the step, or nothing."""
    if kind == "every rank":  # a bar that leaves sideways leaves on all ranks in the same step
        body = box([1.0, 5.0], [7.0, 7.0], [0.0, 2.3])
        case = scene(2, body, step=0.01, output={"every": 0.1}, history={"every": {"steps": 10}})
    else:
        case = clap("max") | ({"time": {"step": 0.01, "end": 0.5}} if kind == 50 else {})
    command = ["-m", "pgimp"]
    if isinstance(kind, int):
        command = [PROGRAMS / "rank_probe.py", "poison", 1, kind]
    write_case(tmp_path / "bad.yaml", case)
    job = mpirun(3, [*command, "bad.yaml", "-o", "out"], cwd=tmp_path)
    assert job.returncode == 1
    assert "Traceback" not in job.stderr + job.stdout
    found = list(MESSAGE.finditer(job.stderr))
    assert len(found) == 1 and len(re.findall("^pgimp: ", job.stderr, re.MULTILINE)) == 1
    (match,) = found
    rank, step, what = {
        "one rank": ("2", 51, "inside out"),
        "every rank": ("0", int(np.ceil(1.25 / 0.023)), "left the domain through y-max"),
    }.get(kind, ("1", kind, "not a finite number"))
    assert match["rank"] == rank and "pgimp: rank 0: particle" in job.stderr
    assert int(match["step"]) == step and what in match["what"]
    # What the run has written before is whole.
    run = pgimp.open(tmp_path / "out")
    assert run.state == "failed" and what in run.info["message"]
    assert run.info["steps"] == step - 1
    frames = (step - 1) // 10 + 1
    np.testing.assert_allclose(run.times, 0.1 * np.arange(frames), atol=1e-12)
    assert list(run.history["step"]) == [10 * i for i in range(frames)]
    assert all(np.isfinite(frame["stress"]).all() for frame in run)
    assert f"holds {frames} frames, to t = {0.1 * (frames - 1):g}" in job.stderr
