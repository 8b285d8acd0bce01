"""Conditions on faces: what they hold, what they drag along, what they let go."""

import numpy as np
import pytest
from scenes import box, field, finish, scene, start, stir, tracked, wall

pytestmark = pytest.mark.slow(30)

SHAPES = ("gimp", "mpm")
CELLS = {"cells": [16, 12], "cell": 0.5}


@pytest.mark.parametrize("face", ["y-min", "y-max", "z-min", "z-max"])
@pytest.mark.parametrize("shape", SHAPES)
def test_motion_along_a_slip_wall_is_undisturbed(face, shape):
    axis, dimension = "xyz".index(face[0]), "xyz".index(face[0]) + 1
    low, high = [2.0] * dimension, [5.0] * dimension
    low[axis], high[axis] = (0.0, 3.0) if face.endswith("min") else (5.0, 8.0)
    velocity = [*[0.37, 0.29][:axis], 0.0]
    sim = start(
        scene(
            dimension,
            box(low, high, velocity),
            shape=shape,
            end=2.0,
            step=0.01,
            boundaries={face: "slip"},
        )
    )
    x0 = field(sim, "x")
    assert finish(sim).step == 200
    # Rounding; at corners also vertices below 1e-12 of a particle, which stand still.
    assert np.abs(field(sim, "x") - x0 - 2.0 * np.array(velocity)).max() < 1e-11
    assert np.abs(field(sim, "v") - velocity).max() < 1e-11
    assert np.abs(field(sim, "sigma")).max() < 1e-9


@pytest.mark.parametrize(
    ("known", "given"),
    [("fixed", wall(0.0, 0.0)), ("slip", wall(None, 0.0)), ("slip", wall(None, [[0.0, 0.0]]))],
)
def test_a_wall_at_no_velocity_is_a_wall_we_know(known, given):
    runs = []
    for condition in (known, given):
        body = box([2.0, 0.0], [5.0, 2.0])
        sim = start(
            scene(
                2,
                body,
                **CELLS,
                end=0.5,
                step=0.005,
                gravity=[0.3, -0.5],
                boundaries={"y-min": condition},
            )
        )
        stir(sim, 0.1)
        line = finish(sim).diagnostics()
        runs.append([*(field(sim, name) for name in ("x", "v", "F", "sigma")), [*line.values()]])
    for mine, theirs in zip(*runs, strict=True):
        assert np.array_equal(mine, theirs)


def test_what_hangs_from_a_ceiling_hangs_as_long_as_the_ceiling_holds():
    fallen = {}
    for ceiling in ("fixed", "slip", "unilateral"):
        body = box([2.0, 4.0], [5.0, 6.0])
        sim = start(
            scene(
                2,
                body,
                **CELLS,
                end=2.0,
                step=0.005,
                gravity=[0.0, -0.5],
                boundaries={"y-max": ceiling},
            )
        )
        y0 = field(sim, "x")[:, 1]
        finish(sim)
        fallen[ceiling] = field(sim, "x")[:, 1] - y0
    # The longest swing of a column of height 2: twice its sag g H^2/(2 c^2) = 0.0074.
    assert -0.03 < fallen["fixed"].min() < fallen["fixed"].max() < 0.001
    assert -0.03 < fallen["slip"].min() < fallen["slip"].max() < 0.001
    free = -0.5 * 0.005**2 * 400 * 401 / 2
    np.testing.assert_allclose(fallen["unilateral"], free, rtol=1e-10)


def test_a_fixed_wall_also_holds_sideways():
    moved = {}
    for floor in ("fixed", "slip"):
        body = box([2.0, 0.0], [5.0, 2.0])
        sim = start(
            scene(
                2,
                body,
                **CELLS,
                end=2.0,
                step=0.005,
                gravity=[0.5, 0.0],
                boundaries={"y-min": floor},
            )
        )
        x0 = field(sim, "x")[:, 0]
        finish(sim)
        moved[floor] = field(sim, "x")[:, 0] - x0
    np.testing.assert_allclose(moved["slip"], 0.5 * 0.005**2 * 400 * 401 / 2, rtol=1e-10)
    # Twice the sag g H^2/(2 mu/rho) = 0.026 of a column in shear, somewhat more at free corners.
    assert -0.01 < moved["fixed"].min() < moved["fixed"].max() < 0.08


@pytest.mark.parametrize("shape", SHAPES)
def test_a_separating_floor_does_not_hold_what_goes_up(shape):
    def rise(floor):
        body = box([2.0, 0.0], [5.0, 2.0], [0.0, 0.37])
        sim = start(
            scene(2, body, **CELLS, shape=shape, end=0.5, step=0.005, boundaries={"y-min": floor})
        )
        (reaction,) = tracked(sim, "reaction.y-min-y")
        return field(sim, "v")[:, 1], reaction

    speed, reaction = rise("unilateral")
    assert not reaction.any()
    np.testing.assert_allclose(speed, 0.37, rtol=1e-12)
    speed, reaction = rise("slip")
    assert reaction.min() < -1.0 and np.abs(speed - 0.37).max() > 0.1


def test_a_block_bounces_off_a_separating_floor_without_sticking():
    body = box([2.0, 0.75], [5.0, 2.75], [0.1, -0.6])
    sim = start(scene(2, body, **CELLS, end=2.5, step=0.005, boundaries={"y-min": "unilateral"}))
    force, up, along = tracked(sim, "reaction.y-min-y", "momentum-y", "momentum-x")
    touch, leave = np.flatnonzero(force)[[0, -1]]
    assert 0 < touch < leave < len(force) - 20
    # A vertex may be held while its own acceleration points up: that never adds up to a pull.
    assert force.min() > -1e-6 * force.max()
    assert up[0] == pytest.approx(-3.6, rel=1e-12)
    np.testing.assert_allclose(up[leave:], up[leave], rtol=1e-8)  # gone, and no more force
    np.testing.assert_allclose(along, 0.6, rtol=1e-8)  # frictionless
    assert up[-1] - up[0] == pytest.approx(force.sum() * 0.005, rel=1e-8)
    # What is missing is vibration, and what the vertices on the floor lose when they stop: of a
    # block of two cells a good part.
    assert 0.5 * 3.6 < up[-1] < 3.6
    assert field(sim, "x")[:, 1].min() > 0.3
    # It is felt when it is there, but for the way of a step.
    assert touch * 0.005 * 0.6 == pytest.approx(0.75, abs=0.06)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_body_that_moves_with_its_wall_feels_nothing(shape, dimension):
    """Floor and body speed up alike, by a table and by gravity."""
    g = [*[0.5, 0.31][: dimension - 1], 0.0]
    floor = wall(*([[0.0, 0.0], [2.0, 2.0 * each]] for each in g[:-1]), None)
    low, high = [1.0] * (dimension - 1) + [0.0], [4.0] * (dimension - 1) + [3.0]
    sim = start(
        scene(
            dimension,
            box(low, high),
            shape=shape,
            end=2.0,
            step=0.01,
            gravity=g,
            boundaries={f"{'xyz'[dimension - 1]}-min": floor},
        )
    )
    line = finish(sim).diagnostics()
    assert np.abs(field(sim, "v") - 2.0 * np.array(g)).max() < 1e-11
    assert np.abs(field(sim, "sigma")).max() < 1e-9
    reactions = [value for name, value in line.items() if name.startswith("reaction")]
    assert len(reactions) == dimension and np.abs(reactions).max() < 1e-8
    # The work of gravity, which takes the speed at the end of each step: dt/T too much.
    assert line["external-work"] == pytest.approx(line["kinetic-energy"] * 1.005, rel=1e-9)


@pytest.mark.parametrize(
    ("speed", "path"), [(0.5, 1.5), ([[0.0, 0.0], [2.0, 1.0]], 2.0)], ids=["constant", "table"]
)
def test_a_moving_wall_drags_a_body_along(speed, path):
    body = box([1.0, 0.0], [4.0, 2.0])
    sim = start(
        scene(2, body, **CELLS, end=3.0, step=0.005, boundaries={"y-min": wall(speed, 0.0)})
    )
    start_at = field(sim, "x")
    (momentum,) = tracked(sim, "momentum-x")
    moved = (field(sim, "x") - start_at)[:, 0]
    bottom = start_at[:, 1] < 0.25
    # The row next to the wall is an eighth of a length above it, which shears by about 1 %.
    np.testing.assert_allclose(moved[bottom], path, rtol=0.01)
    np.testing.assert_allclose(moved, path, rtol=0.15)  # the rest swings about it
    assert momentum[-200:].mean() / 6.0 == pytest.approx(path - 1.0, rel=0.3)


@pytest.mark.parametrize("shape", ["gimp", "finite-gimp", "fuzzy-constant"])
def test_a_wall_sits_on_any_plane_of_the_grid(shape):
    """The domain's faces, wherever the grid has its origin: the same motion, moved along."""

    def run(origin):
        body = box([origin, 0.0], [origin + 3.0, 2.0], [-0.4, 0.1])
        sides = {"x-min": "fixed", "y-min": "slip"}
        case = scene(2, body, **CELLS, shape=shape, end=0.5, step=0.005, boundaries=sides)
        case["grid"]["origin"] = [origin, 0.0]
        sim = start(case)
        (reaction,) = tracked(sim, "reaction.x-min-x")
        return field(sim, "x") - [origin, 0.0], field(sim, "sigma"), reaction

    # Coordinates near 1000 are rounded to 2e-13; times the stiffness of 100, over 100 steps.
    for mine, others in zip(run(0.0), run(-1027.75), strict=True):
        np.testing.assert_allclose(mine, others, atol=2e-9)
    assert np.abs(run(0.0)[2]).max() > 1.0


def test_a_point_on_the_upper_wall_loses_no_force():
    """Its weights' gradients are on vertices that have mass: momentum is that of the reactions."""
    case = scene(
        2,
        box([0.4, 0.0], [2.92, 3.47]),
        cells=[3, 4],
        shape="mpm",
        step=0.01782,
        end=54 * 0.01782,
        boundaries={"x-max": "slip", "y-min": {"velocity": [0.934, 0.418]}},
    )
    sim = start(case)
    held, last = 0, sim.diagnostics()
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        for axis in "xy":
            forces = sum(line[f"reaction.{face}-{axis}"] for face in case["boundaries"])
            gained = line[f"momentum-{axis}"] - last[f"momentum-{axis}"]
            # Of the order of the rounding of momenta of a few units.
            assert gained == pytest.approx(forces * sim.dt, abs=1e-12), (sim.step, axis)
        held, last = sim.rank.held, line
    assert held > 5 and (sim.particles.x[sim.live(), 0] > 2.999).any()


def test_gravity_works_along_the_way_that_a_wall_sets_particles_back():
    """Boxes at a wall have weight on the vertices before it, and creep through."""
    case = scene(2, box([1.0, 0.5], [3.0, 2.5], [1.0, 0.0]), cells=[3, 3], gravity=[2.0, 0.1],
                 shape="gimp", boundaries={"x-max": "slip"})  # fmt: skip
    sim = start(case)
    p, rows = sim.particles, sim.live()
    p.x[rows, 0] += 2.9999 - p.x[rows, 0].max()
    sim.population.sort()
    before, m = field(sim, "x"), field(sim, "m")
    sim.advance()
    work = m @ (field(sim, "x") - before) @ [2.0, 0.1]
    assert sim.rank.held > 0
    assert sim.diagnostics()["external-work"] == pytest.approx(work, rel=1e-13)
