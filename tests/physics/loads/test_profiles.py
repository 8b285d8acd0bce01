"""Loads whose size along a line moves: forces, ways, rest, a beam that is crossed, bad input."""

from math import pi

import numpy as np
import pytest
from scenes import box, scene, start
from studies.loads import moving

from pgimp.case.schema import Case

pytestmark = pytest.mark.slow(120)

EVERYWHERE = {"box": {"min": [-9.0] * 2, "max": [99.0] * 2}}
TOP = {"half-space": {"point": [0.0, 4.6], "normal": [0.0, -1.0]}}
#: With a ramp that is shorter than a particle, and a jump at the end.
TABLE = [[-0.8, 0.0], [-0.7, 1.0], [0.4, 0.6], [0.9, 0.2]]


def integral(table, low, high):
    """Integral of a table, zero beyond its ends, between two coordinates."""
    s, f = np.transpose(table)
    low, high = np.clip([low, high], s[0], s[-1])
    every = np.union1d(s[(s > low) & (s < high)], [low, high])
    return np.trapezoid(np.interp(every, s, f), every)


def loaded(body, load, profile, **parts):
    """A body under one load with a profile."""
    load = {"body": "body", "region": TOP, "profile": profile, **load}
    parts = {"cells": [9, 9], "end": 0.3, "step": 0.001} | parts
    return scene(parts.pop("dimensions", 2), body, tractions={"load": load}, **parts)


def forces(sim, steps, axis="y"):
    """Force on all in each of some steps."""
    line, found = sim.diagnostics(), []
    for _ in range(steps):
        before = line[f"momentum-{axis}"]
        sim.advance()
        line = sim.diagnostics()
        found.append((line[f"momentum-{axis}"] - before) / sim.dt)
    return np.array(found)


@pytest.mark.parametrize("configuration", ["current", "initial"])
@pytest.mark.parametrize("follower", [True, False])
def test_forces_on_a_straight_surface_are_exact_wherever_the_profile_is(configuration, follower):
    """It comes on at one end of a body that ends within cells, and leaves at the other.

    Loads end with a quarter of a particle, so that one of them is beside the load at both ends.
    """
    body = box([1.3, 2.2], [7.6, 4.95]) | {"formulation": configuration}
    edge = {"half-space": {"point": [0.0, 4.94], "normal": [0.0, -1.0]}}
    velocity = {"ramp": {"from": 0.0, "to": 6000.0, "duration": 0.002}}
    profile = {"along": [3.0, 0.0], "from": [0.4, 7.0], "velocity": velocity, "table": TABLE}
    case = loaded(
        body,
        {"pressure": 1e-5, "follower": follower, "region": edge},
        profile,
        end=0.003,
        step=0.00005,
    )
    sim, ramp = start(case), Case.model_validate(case).tractions["load"].profile.velocity
    found = forces(sim, 50)
    places = [0.4 + ramp.integral(0.00005 * step) for step in range(50)]
    right = [-1e-5 * integral(TABLE, 1.3 - place, 7.6 - place) for place in places]
    whole = [2.4 < place < 6.4 for place in places]
    assert places[-1] > 7.0 and sum(whole) > 10 and min(right) < -9e-6
    np.testing.assert_allclose(found[whole], np.array(right)[whole], rtol=1e-9)
    np.testing.assert_allclose(found, right, rtol=0, atol=0.1 * 1e-5)


def test_forces_on_a_disk_converge_to_the_integral():
    """In second order: parts are chords, and a table with kinks stands anywhere between them."""
    worst = []
    for radius in (2.5, 5.0, 10.0):
        disk = {"material": "soft", "region": {"ball": {"center": [16.1, 16.2], "radius": radius}}}
        table = [[s * radius, f] for s, f in ((-0.7, 0.0), (-0.1, 1.0), (0.5, 0.4))]
        most = 0.0
        for shift in (0.0, 0.13, 0.31, 0.44, 0.57):
            ahead = {"along": [1.0, 0.0], "from": [16.1 + shift, 0.0], "table": table}
            upper = {"half-space": {"point": [0.0, 16.2], "normal": [0.0, -1.0]}}
            case = loaded(disk, {"pressure": 1.0, "region": upper}, ahead, cells=[32, 32])
            right = -integral(table, -radius - shift, radius - shift)
            most = max(most, abs(forces(start(case), 1)[0] / right - 1.0))
        worst.append(most)
    assert worst[0] < 0.01 and worst[2] < worst[0] / 10.0, worst


@pytest.mark.wide
def test_forces_of_the_front_of_a_wave_on_a_bar():
    """In 1D the surface is a point: the load is there from when the front comes."""
    front = {"along": [1.0], "from": [-1.0], "velocity": 100.0, "beyond": "hold",
             "table": [[-1.0, 0.5], [0.0, 1.0]]}  # fmt: skip
    end = {"box": {"min": [0.0], "max": [2.0]}}
    case = loaded(
        {"material": "soft", "region": {"box": {"min": [1.25], "max": [6.0]}}},
        {"traction": [1e-6], "region": end}, front | {"table": [[-1.0, 0.5], [0.0, 1.0]]},
        cells=[9], dimensions=1, end=0.05,
    )  # fmt: skip
    found = 1e6 * forces(start(case), 40, "x")
    place = -1.0 + 0.1 * np.arange(40)
    np.testing.assert_allclose(found, np.clip(1.0 + 0.5 * (1.25 - place), 0.5, 1.0), atol=1e-6)


@pytest.mark.wide
@pytest.mark.parametrize("along", [[1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [1.0, 1.0, 0.0]])
def test_forces_on_a_block(along):
    """Between walls, so that the surface has no edges, where parts have two faces."""
    top = {"half-space": {"point": [0.0, 0.0, 2.6], "normal": [0.0, 0.0, -1.0]}}
    profile = {"along": along, "from": [3.13, 3.24, 0.0], "table": TABLE}
    body = {"material": "soft", "region": {"box": {"min": [0.0, 0.0, 1.0], "max": [7.0, 7.0, 3.0]}}}
    case = loaded(
        body, {"pressure": 1.0, "region": top}, profile, cells=[7, 7, 5], dimensions=3,
        boundaries={f"{axis}-{end}": "slip" for axis in "xy" for end in ("min", "max")},
    )  # fmt: skip
    (found,) = forces(start(case), 1, "z")
    a = np.array(along[:2]) / np.linalg.norm(along)
    x = np.stack(np.meshgrid(*[np.arange(0.0025, 7.0, 0.005)] * 2), axis=-1)
    s, f = (x - [3.13, 3.24]) @ a, np.transpose(TABLE)
    right = -np.interp(s, *f, 0.0, 0.0).sum() * 0.005**2
    # Along a diagonal rows end at the walls in steps.
    assert found == pytest.approx(right, rel=5e-4 if a[0] * a[1] == 0.0 else 5e-3)


@pytest.mark.wide
def test_forces_on_rings():
    """Of a wave that spreads over the top, and of a traction that runs up the mantle."""
    body, radius = box([0.0, 1.0], [4.0, 4.95]), 1.83
    spreads = {"along": [1.0, 0.0], "from": [radius, 0.0], "table": TABLE}
    case = loaded(body, {"pressure": 1.0}, spreads, geometry="axisymmetric")
    s, f = np.transpose(TABLE)
    r = np.linspace(radius - 0.8, radius + 0.9, 100001)
    right = -2.0 * pi * np.trapezoid(r * np.interp(r - radius, s, f), r)
    assert forces(start(case), 1)[0] == pytest.approx(right, rel=5e-3)
    mantle = {"half-space": {"point": [3.7, 0.0], "normal": [-1.0, 0.0]}}
    runs = {"along": [0.0, 1.0], "from": [0.0, 2.63], "table": TABLE}
    load = {"traction": [0.0, 1.0], "region": mantle}
    (found,) = forces(start(loaded(body, load, runs, geometry="axisymmetric")), 1)
    assert found == pytest.approx(2.0 * pi * 4.0 * integral(TABLE, -9.0, 9.0), rel=1e-12)


def test_a_load_that_crosses_a_beam_moves_it_as_timoshenko_says():
    """At half of the critical speed; and its work is in the energies."""
    mean, most, peak, lost, *_ = moving.crossed(2)
    assert mean < 0.03 and most < 0.06 and abs(peak) < 0.04
    assert lost < 1e-3


def test_the_exact_beam_is_that_of_a_slow_load_at_rest():
    """With the deflection of a force in the middle, with that of its shear."""
    slow = 0.002 * moving.critical()
    end = 0.5 * (moving.SPAN + moving.WIDTH) / slow
    _, found = moving.exact(end, slow, 40000)
    L, q, c = moving.SPAN, moving.PRESSURE * moving.YOUNG, moving.WIDTH
    bent = q * c * (8 * L**3 - 4 * c**2 * L + c**3) / (384.0 * moving.YOUNG / 12.0)
    sheared = q * c * (2 * L - c) / 8.0 / (5.0 / 6.0 * 0.5 * moving.YOUNG)
    assert found[-1] == pytest.approx(bent + sheared, rel=2e-3)


def staged(*profiles):
    """Profiles of a case's stages, one a time unit."""
    case = loaded(box([1.0, 1.0], [6.0, 5.0]), {"pressure": 1.0}, profiles[0], end=1.0)
    case["time"]["stages"] = [
        {"name": f"s{i}", "end": 2.0 + i, "tractions": {"load": {"profile": profile}}}
        for i, profile in enumerate(profiles[1:])
    ]
    return Case.model_validate(case).stages


def origin(case, t):
    """Where the profile's coordinate is zero at a time, along its line."""
    (load,) = _surfaces(case).at(t)
    return load.profile.origin


def _surfaces(case):
    from pgimp.scene.surfaces import SurfaceLoads

    return SurfaceLoads(case, {"body": True})


def test_a_profile_goes_on_in_stages_unless_it_begins_elsewhere():
    first = {"along": [0.0, 2.0], "from": [9.0, 1.0], "velocity": 3.0, "table": TABLE}
    table = {"table": [[0.0, 4.0], [1.0, 4.0], [3.0, 0.0]]}
    faster = first | {"velocity": table, "table": [[0.0, 1.0], [1.0, 1.0]]}
    other = faster | {"from": [0.0, 7.0]}
    cases = staged(first, faster, other, other | {"beyond": "hold"}, None, first)
    assert origin(cases[0], 1.0) == 4.0
    assert origin(cases[1], 1.0) == 4.0
    assert origin(cases[1], 2.0) == pytest.approx(7.0)
    assert origin(cases[2], 2.0) == 7.0
    assert origin(cases[2], 3.0) == origin(cases[3], 3.0) == pytest.approx(8.0)
    assert _surfaces(cases[4]).at(4.5)[0].profile == ()
    assert origin(cases[5], 5.0) == pytest.approx(1.0)  # anew


def test_a_stage_cannot_change_a_velocity_that_a_program_sets():
    first = {"along": [1.0, 0.0], "velocity": {"control": "pace"}, "table": TABLE}
    same = first | {"table": [[0.0, 1.0], [1.0, 1.0]]}
    assert len(staged(first, same)) == 2
    for change in ({"velocity": 1.0}, {"from": [2.0, 0.0]}):
        with pytest.raises(ValueError, match="is set by a program, or was"):
            staged(first, same | change)


def test_a_profile_that_stands_still_costs_no_step_and_comes_to_rest():
    """A load over the middle third, on a block that rests in a mould."""
    profile = {"along": [1.0, 0.0], "from": [4.5, 0.0], "table": [[-1.5, 1.0], [1.5, 1.0]]}
    case = loaded(
        box([0.0, 0.0], [9.0, 5.0]), {"pressure": 0.5}, profile,
        boundaries={"x-min": "slip", "x-max": "slip", "y-min": "fixed"},
        step={"courant": 0.3}, start={"equilibrate": {"tolerance": 2e-3, "steps": 3000}},
    )  # fmt: skip
    sim = start(case)
    assert not _surfaces(Case.model_validate(case)).varies
    while sim.settling:
        sim.advance()
    p, rows = sim.particles, sim.live()
    low = rows[p.x[rows, 1] < 0.5]
    held = (p.sigma[low, 1] * p.V[low]).sum() / 0.5
    assert held == pytest.approx(-0.5 * 3.0, rel=0.02)


def test_a_scene_without_a_profile_has_the_types_that_it_had():
    case = loaded(box([1.0, 1.0], [6.0, 5.0]), {"pressure": 1.0}, None)
    (load,) = _surfaces(Case.model_validate(case)).at(0.0)
    assert load.profile == ()


def test_a_load_that_has_lain_for_long_presses_by_its_profile():
    profile = {"along": [1.0, 0.0], "from": [3.0, 0.0], "table": [[0.0, 0.0], [4.0, 4.0]]}
    case = loaded(
        box([1.0, 0.0], [7.0, 5.0]), {"pressure": 2.0}, profile, gravity=[0.0, -0.01],
        start={"stress": {"k0": 0.5, "surcharge": ["load"]}}, boundaries={"y-min": "fixed"},
    )  # fmt: skip
    sim = start(case)
    p, rows = sim.particles, sim.live()
    x, y = p.x[rows].T
    right = -0.01 * (5.0 - y) - np.where(x > 3.0, 2.0 * (x - 3.0), 0.0)
    np.testing.assert_allclose(p.sigma[rows, 1], right, atol=1e-4)
