"""Prescribed motion of parts of bodies: exact motion, reactions, where a grip's edge is, ranks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from loaded_block import grip, loaded
from scenes import box, field, finish, scene, start

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.schema.tables import Table

pytestmark = pytest.mark.slow(20)

RAMP = [[0.0, 0.0], [0.3, 0.6], [0.5, -0.2]]


def line(**parts):
    """A bar from 2.1 to 10 whose ends are held, the right one as `RAMP` says."""
    constraints = {"left": grip([2.0], [3.5], 0.0), "right": grip([9.0], [11.0], RAMP)}
    parts = {"cells": [14], "end": 0.5, "constraints": constraints, **parts}
    return scene(1, box([2.1], [10.0]), **parts)


def at(table, t):
    """Value of a table at a time."""
    return np.interp(t, *np.transpose(table))


def test_held_particles_move_exactly_as_the_table_says():
    sim = start(line())
    x = field(sim, "x")[:, 0]
    grips = field(sim, "constraint")[:, 0]
    np.testing.assert_array_equal(grips, np.where(x < 3.5, 1, np.where(x >= 9.0, 2, 0)))
    way = np.zeros_like(x)
    while not sim.finished:
        sim.advance()
        v = at(RAMP, sim.time)  # a step's way is that of the velocity at its end
        way[grips == 2] += v * sim.dt
        np.testing.assert_array_equal(field(sim, "v")[grips == 1, 0], 0.0)
        np.testing.assert_allclose(field(sim, "v")[grips == 2, 0], v, rtol=1e-15, atol=1e-16)
    held = grips > 0
    np.testing.assert_allclose(field(sim, "x")[held, 0], (x + way)[held], rtol=1e-14)
    assert field(sim, "v")[~held, 0].std() > 0.01


def test_the_history_has_the_prescribed_displacement():
    """The area under `RAMP` in closed form; particles, in 50 steps, to first order in the step."""
    right = line()["constraints"]["right"]
    for name, other, rate in (("left", grip([2.0], [3.5], 0.0), 0.0),
                              ("mid", grip([5], [6], -0.5), -0.5)):  # fmt: skip
        sim = start(line(constraints={name: other, "right": right}))
        held, x = field(sim, "constraint")[:, 0] == 2, field(sim, "x")[:, 0]
        while not sim.finished:
            sim.advance()
            t = sim.time
            up, down = min(t, 0.3), max(t - 0.3, 0.0)
            columns = sim.diagnostics()
            way = up**2 + 0.6 * down - 2.0 * down**2
            assert columns["displacement.right-x"] == pytest.approx(way, rel=1e-14)
            assert columns[f"displacement.{name}-x"] == pytest.approx(rate * t, rel=1e-15, abs=0.0)
            moved = field(sim, "x")[held, 0] - x[held]
            # A step takes the velocity at its end, too much by half of what it grew by: 0.6 in all.
            np.testing.assert_allclose(moved, way, rtol=0, atol=1.01 * 0.5 * 0.6 * sim.dt)
        assert t == pytest.approx(0.5)
    names = [name for name in start(loaded()).diagnostics() if name.startswith("displacement")]
    assert names == ["displacement.pull-x", "displacement.lift-y"]


@given(
    times=st.lists(st.integers(-8, 40), min_size=1, max_size=6, unique=True).map(sorted),
    values=st.lists(st.integers(-9, 9), min_size=6, max_size=6),
    t=st.integers(0, 50),
)
def test_a_table_is_integrated_exactly(times, values, t):
    """Of whole numbers, so that a trapezium a unit of time is exact; any rows before and after."""
    rows = [(0.5 * a, float(v)) for a, v in zip(times, values, strict=False)]
    every = np.arange(t + 1) * 0.5
    expected = np.trapezoid(at(rows, every), every)
    assert Table(table=rows).integral(0.5 * t) == pytest.approx(expected, rel=1e-13, abs=1e-12)


def test_components_that_are_null_stay_free():
    sim = start(loaded())
    grips, x = field(sim, "constraint")[:, 0], field(sim, "x")
    finish(sim)
    v, moved = field(sim, "v"), field(sim, "x") - x
    pull, lift = grips == 1, grips == 2
    assert pull.sum() == 16 and lift.sum() == 4
    np.testing.assert_array_equal(v[pull, 0], 3.0)
    np.testing.assert_allclose(moved[pull, 0], 3.0, rtol=1e-13)
    np.testing.assert_array_equal(v[lift, 1], 1.0)
    # Velocities at the ends of 50 steps of 0.01 up the ramp, then 50 at its top.
    np.testing.assert_allclose(moved[lift, 1], 0.01 * (0.02 * 1275 + 50), rtol=1e-13)
    assert np.ptp(v[pull, 1]) > 0.05 and np.ptp(v[lift, 0]) > 0.02


def tractions_on(sim):
    """Force of all tractions in plain NumPy: Nanson's formula for every patch."""
    area, F = field(sim, "patch"), field(sim, "F").reshape(-1, 2, 2)
    force = np.zeros(2)
    for n, entry in enumerate(sim.case.tractions.values()):
        axis, side = "xy".index(entry.face[0]), -1 if entry.face.endswith("min") else 1
        N = np.eye(2)[axis] * side
        for A, f in zip(area[:, n], F, strict=True):
            a = np.linalg.det(f) * np.linalg.inv(f).T @ N * A
            if entry.pressure is not None:
                force -= entry.pressure * a
            else:
                t = np.array([at([[0, 0], [1, top]], sim.time) for top in (1.0, 4.0)])
                force += t * np.linalg.norm(a)
    return force


def test_momentum_changes_by_the_impulses_of_all_that_acts():
    sim = start(loaded())
    before, impulse = sim.diagnostics(), np.zeros(2)
    names = ["reaction.y-min", "constraint.pull", "constraint.lift"]
    total, scale = np.zeros(2), np.zeros(2)
    for _ in range(60):
        impulse = sim.case.time.step * (tractions_on(sim) + before["mass"] * np.array([0.0, -2.0]))
        sim.advance()
        line = sim.diagnostics()
        now = np.array([[line[f"{name}-{axis}"] for axis in "xy"] for name in names]) * sim.dt
        change = np.array([line[f"momentum-{a}"] - before[f"momentum-{a}"] for a in "xy"])
        np.testing.assert_allclose(impulse + now.sum(axis=0), change, rtol=0, atol=1e-11)
        total, scale, before = total + now[1:].sum(axis=0), scale + np.abs(now).sum(axis=0), line
    assert (np.abs(total) > 1.0).all() and (scale > 1.0).all()  # far above the tolerance


@pytest.fixture(scope="module")
def stretched():
    """Stretch bars by 1e-4 slowly between grips of 2 cells, 10 apart, held at the places asked for.

    Returns
    -------
    callable
        ``(offset, shape, per_cell, configuration) -> (sim, line, error)``: edges of the grips lie
        `offset` beyond a vertex; `error` says how much further into the bar than the regions' edges
        the left and the right grip act, in cells.
    """

    def stretch(offset, shape="gimp", per_cell=2, configuration="current"):
        a, T, d = 2.0 + offset, 24.0, 1e-4  # a transit of the bar takes 1.4
        speed = [[0.0, 0.0], [T / 2, 2 * d / T], [T, 0.0]]
        body = box([a], [a + 14.0]) | {"formulation": configuration}
        case = scene(
            1, body, cells=[19], shape=shape, per_cell=per_cell, end=T + 2.8,
            step=0.02, history={"every": {"steps": 1}},
            constraints={
                "left": grip([a - 1], [a + 2], 0.0), "right": grip([a + 12], [a + 15], speed)
            },
        )  # fmt: skip
        sim = start(case)
        x = field(sim, "x")[:, 0]
        while sim.time < T - 1e-9:
            sim.advance()
        before = sim.diagnostics()
        assert before is not None
        finish(sim)  # two periods of what still swings
        u = field(sim, "x")[:, 0] - x
        middle = np.abs(x - a - 7.0) < 3.0
        slope, zero = np.polyfit(x[middle], u[middle], 1)
        return sim, sim.diagnostics(), (-zero / slope - a - 2, a + 12 - (d - zero) / slope)

    return stretch


def test_both_grips_feel_the_stress_of_a_bar_stretched_slowly(stretched):
    sim, line, (left, right) = stretched(0.0)
    x = field(sim, "x")[:, 0]
    sigma = field(sim, "sigma")[(x > 4.5) & (x < 13.5), 0]
    # What still swings is a part (1.4/24)^2 of the load.
    np.testing.assert_allclose(sigma, 100.0 * 1e-4 / 10.0, rtol=5e-3)
    np.testing.assert_allclose(line["constraint.right-x"], sigma.mean(), rtol=5e-3)
    np.testing.assert_allclose(line["constraint.left-x"], -sigma.mean(), rtol=5e-3)
    assert abs(left) < 0.01 and abs(right) < 0.01


@pytest.mark.parametrize("shape", ["gimp", "mpm"])
def test_a_grip_acts_up_to_a_vertex_near_its_edge(stretched, shape):
    for offset in (0.25, 0.375, 0.5):
        for error, edge in zip(stretched(offset, shape)[2], (offset, -offset), strict=True):
            # A vertex: what the grip acts beyond its edge makes up a whole number.
            assert abs(error + edge - round(error + edge)) < 0.01
            # The last particle held may end a quarter of a cell before the region does.
            assert -0.26 < error < 1.01


def test_a_grip_in_the_initial_configuration_acts_up_to_the_nearest_vertex(stretched):
    """Three particles a cell: edges at a third and two thirds of it, both away from the bar."""
    for offset in (1.0 / 3.0, 2.0 / 3.0):
        errors = np.array(stretched(offset, "gimp", 3, "initial")[2])
        np.testing.assert_allclose(np.abs(errors), 1.0 / 3.0, atol=0.01)


def test_constraints_that_share_vertices_split_what_they_give():
    """Halves held by two constraints alike act as one that holds all."""
    one = {
        "all": grip([7.0, 0.0], [8.0, 4.0], 3.0, -0.5),
        "none": grip([2.0, 3.0], [2.5, 4.0], None, None),
    }
    two = {
        "upper": grip([7.0, 2.0], [8.0, 4.0], 3.0, -0.5),
        "lower": grip([7.0, 0.0], [8.0, 2.0], 3.0, -0.5),
    }
    sims = [start(loaded(constraints=c, end=0.3)) for c in (one, two)]
    for sim in sims:
        sim.diagnostics()
        finish(sim)
    for name in ("x", "v", "F", "sigma"):
        np.testing.assert_array_equal(*(field(sim, name) for sim in sims))
    lines = [sim.diagnostics() for sim in sims]
    for axis in "xy":
        whole = lines[0][f"constraint.all-{axis}"]
        assert lines[0][f"constraint.none-{axis}"] == 0.0
        halves = lines[1][f"constraint.upper-{axis}"] + lines[1][f"constraint.lower-{axis}"]
        assert halves == pytest.approx(whole, rel=1e-11) and abs(whole) > 0.1


def problems(**constraint):
    case = loaded(constraints={"pull": grip([7.0, 0.0], [8.0, 4.0], 3.0, None) | constraint})
    with pytest.raises(Exception) as caught:
        Case.model_validate(case)
    return str(caught.value)


def test_wrong_entries_are_named():
    assert "bdy" in problems(body="bdy") and "constraints.pull.body" in problems(body="bdy")
    text = problems(velocity=[1.0])
    assert "constraints.pull.velocity" in text and "expected 2 entries" in text
    text = problems(region={"box": {"min": [0.0], "max": [1.0]}})
    assert "constraints.pull.region.box.min" in text
    text = problems(region={"bal": {"centre": [0.0, 1.0], "radius": 1.0}})
    assert "constraints.pull.region" in text and "ball" in text
    assert "constraints.pull.velocity.0" in problems(velocity=["fast", 0.0])


def test_a_region_without_a_particle_of_the_body_is_named():
    case = line(constraints={"left": grip([2.0], [3.5], 0.0), "off": grip([11.0], [12.0], RAMP)})
    with pytest.raises(CaseError, match=r"off\.region: contains no particle of .* 0\.5 apart"):
        start(case)
