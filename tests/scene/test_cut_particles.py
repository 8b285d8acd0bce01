"""Particles that a surface cuts: small parts, bodies that share one, light ones in motion."""

from itertools import pairwise

import numpy as np
import pytest
from cut_bodies import ball, body, box, particles, region, spinning
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import field, finish, scene, start

from pgimp.errors import CaseError
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.merge import LEAST_FRACTION

# -- small cut boxes


def test_small_parts_go_to_the_neighbour_inwards():
    """Boxes of 0.5: the part beyond 3 is 5e-4 of one, in a corner 2.5e-7."""
    end = 3.0 + 0.5 * 5e-4
    p, _ = particles(scene(2, body(box([1.0, 1.0], [end, end]))))
    f = p.V / 0.25
    assert len(f) == 16
    assert p.V.sum() == pytest.approx((end - 1.0) ** 2, rel=1e-13)
    last = np.isclose(p.x, 2.75)
    sides = last.sum(axis=1)
    np.testing.assert_allclose(f[sides == 0], 1.0, rtol=0, atol=0)
    np.testing.assert_allclose(f[sides == 1], 1.0 + 5e-4, rtol=1e-9)
    np.testing.assert_allclose(f[sides == 2], 1.0 + 2 * 5e-4 + 2.5e-7, rtol=1e-9)
    assert f.min() >= LEAST_FRACTION


@pytest.mark.parametrize(("part", "count"), [(0.9 * LEAST_FRACTION, 4), (1.1 * LEAST_FRACTION, 5)])
def test_parts_above_a_thousandth_stay(part, count):
    p, _ = particles(scene(1, body(box([1.0], [3.0 + 0.5 * part])), per_cell=2))
    assert len(p.V) == count
    assert p.V.sum() == pytest.approx(2.0 + 0.5 * part, rel=1e-13)


def test_a_small_part_without_a_neighbour_stays():
    p, _ = particles(scene(1, body(box([1.1], [1.1 + 1e-5]))))
    assert len(p.V) == 1
    assert p.V[0] == pytest.approx(1e-5, rel=1e-9)


# -- parts of the lattice


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_small_body_is_measured_once_for_every_part_of_it(data):
    """Whole boxes, fractions and moments of any part are those that are found for it alone."""
    D = data.draw(st.integers(1, 3))
    random = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    edges = [np.linspace(0.0, 4.0, 9)] * D
    centres = [0.25 + 0.5 * np.arange(8)] * D
    entry = ball(random.uniform(0.0, 4.0, D).tolist(), random.uniform(0.1, 2.0))
    if data.draw(st.booleans()):
        entry = {"difference": [box([0.3] * D, [3.9] * D), entry]}
    cut = data.draw(st.booleans())
    lattice_body = LatticeBody(region(entry), edges, centres, cut)
    alone = LatticeBody(region(entry), edges, centres, cut)
    for _ in range(3):
        ends = np.sort(random.integers(0, 9, (D, 2)), axis=1).tolist()
        part = [(a, max(a + 1, b)) if a < 8 else (7, 8) for a, b in ends]
        one, other = lattice_body.volume_fractions(part), alone._find_fractions(part)
        assert one.ranges == other.ranges
        for mine, theirs in zip(one[1:], other[1:], strict=True):
            np.testing.assert_array_equal(mine, theirs)


# -- bodies that meet


@pytest.mark.parametrize("D", [1, 2, 3])
def test_bodies_that_touch_within_a_particle_share_it(D):
    left, right = [1.0] * D, [3.0] * D
    between = [1.8, *right[1:]], [1.8, *left[1:]]
    case = scene(D, {"a": body(box(left, between[0])), "b": body(box(between[1], right))})
    p, notes = particles(case)
    for number, length in ((0, 0.8), (1, 1.2)):
        assert p.V[p.body == number].sum() == pytest.approx(length * 2 ** (D - 1), rel=1e-13)
    assert len(notes) == 1


def test_a_ball_in_a_hole_of_its_size_is_no_overlap():
    inner = ball([2.03, 1.97, 2.01], 1.1)
    hole = {"difference": [box([0.3] * 3, [3.9] * 3), inner]}
    p, _ = particles(scene(3, {"ball": body(inner), "hole": body(hole)}))
    assert p.V.sum() == pytest.approx(3.6**3, rel=1e-5)


def test_bodies_that_overlap_within_a_particle_are_refused():
    """No point of the lattice lies in both, but their shares of a particle exceed it."""
    case = scene(1, {"a": body(box([1.0], [2.2])), "b": body(box([2.05], [4.0]))})
    with pytest.raises(CaseError, match=r"'a' and 'b' overlap in the box of the particle"):
        particles(case)


# -- ranks


@pytest.mark.parametrize("D", [1, 2, 3])
def test_particles_do_not_depend_on_the_planes_that_are_made_together(D):
    case = scene(D, body(ball([3.91, 4.03, 3.97][:D], 2.27), velocity=spinning(D)[0]))
    whole, _ = particles(case)
    for cuts in ([0, 5, 16], [0, 3, 4, 6, 11, 16]):
        parts = [particles(case, (a, b))[0] for a, b in pairwise(cuts)]
        for i, array in enumerate(whole):
            assert np.concatenate([part[i] for part in parts]).tobytes() == array.tobytes()


# -- in motion


# The lightest particle of this disk has 1.001e-3 of a whole one: just too much to merge.
CENTRE, RADIUS = [4.65, 4.18], 2.71


@pytest.mark.parametrize("shape", ["gimp", "mpm"])
def test_a_free_disk_flies_on(shape):
    """Through several cells, under Courant 0.3: no vertex that a light particle leads runs away.

    Rigid translation is exact, so that stress is rounding that must not grow while 16 waves
    cross the disk.
    """
    disk = body(ball(CENTRE, RADIUS), velocity=[1.5, 1.1])
    case = scene(2, disk, cells=[24, 20], shape=shape, end=8.0, step={"courant": 0.3})
    sim = start(case)
    assert LEAST_FRACTION < field(sim, "V").min() / 0.25 < 1.01 * LEAST_FRACTION
    before = (field(sim, "m")[:, None] * field(sim, "v")).sum(axis=0)
    finish(sim)
    assert sim.step > 300
    v, m = field(sim, "v"), field(sim, "m")
    np.testing.assert_allclose((m[:, None] * v).sum(axis=0), before, rtol=1e-12)
    assert np.abs(v - [1.5, 1.1]).max() < 1e-9
    assert np.abs(field(sim, "sigma")).max() < 1e-9


def test_light_particles_leave_a_deformed_disk_stable():
    """A disk that starts to spin pulsates, at strains of a hundredth, for 300 steps.

    mpm turns particles inside out here, with whole particles too: it has no step that is stable
    whatever the weight of the vertex that only the last particle leads.
    """
    motion = {"rotation": {"about": CENTRE, "rate": 1.0}, "translation": [0.6, 0.7]}
    disk = body(ball(CENTRE, RADIUS), velocity=motion)
    sim = start(scene(2, disk, cells=[14, 14], end=6.0, step={"courant": 0.3}))
    first = sim.diagnostics()
    finish(sim)
    last = sim.diagnostics()
    assert sim.step > 300
    for axis in "xy":
        name = f"momentum-{axis}"
        assert last[name] == pytest.approx(first[name], rel=1e-11)
    start_energy = first["kinetic-energy"]
    total = last["kinetic-energy"] + last["strain-energy"]
    assert 0.9 * start_energy < total < start_energy
    F = field(sim, "F").reshape(-1, 2, 2)
    assert 0.7 < np.linalg.det(F).min() and np.linalg.det(F).max() < 1.4


@pytest.mark.parametrize("D", [2, 3])
def test_what_surfaces_leave_is_known_to_contact(D):
    """Moments of a body are those of its parts, and curvature is that of a ball, none of a box."""
    radius, cell = 5.0, 0.5
    bodies = {
        "round": body(ball([4.3, 4.1, 4.4][:D], radius * cell)),
        "flat": body(box([7.3, 1.15, 1.4][:D], [9.1, 4.9, 4.9][:D])),
    }
    case = scene(D, bodies, cells=[20, 16, 16][:D], cell=cell, contact=[{"bodies": "all"}])
    p, _ = particles(case)
    without, _ = particles(case | {"contact": []})
    assert p.offset.shape == (len(p.m), D) and without.offset.shape == (len(p.m), 0)
    assert (p.x == without.x).all() and (p.m == without.m).all()
    cut = (p.offset != 0.0).any(axis=1)
    assert (np.abs(p.V0[~cut] - 0.25**D) < 1e-15).all()
    size = 0.25 * np.ones(D)
    assert (np.abs(p.offset) <= size).all()
    # Centres of mass: exact of a box, of high order of a ball.
    for number, middle in enumerate(([4.3, 4.1, 4.4][:D], [8.2, 3.025, 3.15][:D])):
        own = p.body == number
        centre = p.V0[own] @ (p.x + p.offset)[own] / p.V0[own].sum()
        assert centre == pytest.approx(np.array(middle), abs=1e-3 if number == 0 else 1e-12)
    bent = p.excess[:, 0] / cell
    exact = (D - 1) / radius * (1.0 / 12.0 + 1.0 / 16.0)
    # Taken at the particles, up to half a box from the surface.
    assert bent[cut & (p.body == 0)] == pytest.approx(exact, rel=0.15)
    assert (bent[~cut] == 0.0).all()
    # Only particles within a quarter of a cell of an edge, where it is rounded outside, are not 0.
    edges = np.array([[7.3, 1.15, 1.4][:D], [9.1, 4.9, 4.9][:D]])
    near = np.abs(p.x[:, None] - edges).min(axis=1) < 0.3 * cell
    plain = cut & (p.body == 1) & (near.sum(axis=1) < 2)
    assert plain.sum() > 10 and np.abs(bent[plain]).max() < 1e-9
