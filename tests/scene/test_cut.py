"""Particles that a surface cuts: their shares add up to the body wherever it lies on the grid."""

import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter
from region_entries import entries
from scenes import field, finish, scene, start

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.measure import TangledError, measure
from pgimp.geometry.regions import RegionEntry
from pgimp.mpi.comm import Serial
from pgimp.scene import latticebody
from pgimp.scene.latticebody import LEAST_FRACTION, LatticeBody
from pgimp.scene.populate import populate
from pgimp.scene.scene import Scene, count_particles

ENTRY = TypeAdapter(RegionEntry)


def region(entry):
    return ENTRY.validate_python(entry)


def box(low, high):
    return {"box": {"min": [float(x) for x in low], "max": [float(x) for x in high]}}


def ball(centre, radius):
    return {"ball": {"centre": [float(x) for x in centre], "radius": radius}}


def cylinder(start, end, radius):
    return {"cylinder": {"from": list(start), "to": list(end), "radius": radius}}


def half_space(point, normal):
    point, normal = [float(x) for x in point], [float(n) for n in normal]
    return {"half-space": {"point": point, "normal": normal}}


def body(entry, surface="cut", velocity=None):
    body = {"material": "soft", "region": entry, "surface": surface}
    return body if velocity is None else body | {"velocity": velocity}


def particles(case, planes=None):
    """Particles of a case, or of a range of planes; without the rows that are none."""
    scene_ = Scene(Case.model_validate(case))
    lattice, counts, notes = count_particles(scene_, Serial())
    planes = planes or (0, lattice.planes)
    p = populate(scene_, lattice, counts, planes)
    n = int(counts[:, planes[0] : planes[1]].sum())
    return type(p)._make(array[:n] for array in p), notes


def spinning(dimension):
    """A rigid motion: its entry in a case, and the velocity that it means at a point."""
    if dimension == 1:
        return [0.7], lambda x: np.array([0.7])
    about, translation = np.array([1.5, -2.0, 0.3])[:dimension], np.array([0.4, -0.3, 0.8])
    omega = np.array([0.0, 0.0, 1.3]) if dimension == 2 else np.array([0.9, -0.4, 1.3])
    motion = {
        "rotation": {"about": about.tolist(), "rate": 1.3 if dimension == 2 else omega.tolist()},
        "translation": translation[:dimension].tolist(),
    }

    def velocity(x):
        arm = np.zeros(3)
        arm[:dimension] = x - about
        return (translation + np.cross(omega, arm))[:dimension]

    return motion, velocity


# -- boxes: exact wherever they lie

NUMBER = st.floats(0.05, 0.95).map(lambda x: round(x, 6))


@st.composite
def blocks(draw, dimension):
    """Boxes of any size in (0.2, 5.8), some of them thinner than a particle."""
    low = [draw(NUMBER) * 4 + 0.2 for _ in range(dimension)]
    thick = [draw(st.sampled_from([0.01, 0.2, 1.0, 1.5])) * draw(NUMBER) for _ in range(dimension)]
    return box(low, [a + b for a, b in zip(low, thick, strict=True)])


def exact_moments(kind, entries, dimension):
    """Volume and centre of a union or a difference of boxes, by the boxes between their faces."""
    corners = [(e["box"]["min"], e["box"]["max"]) for e in entries]
    edges = [np.unique([c[d] for pair in corners for c in pair]) for d in range(dimension)]
    volume, moment = 0.0, np.zeros(dimension)
    for place in np.ndindex(*(len(e) - 1 for e in edges)):
        low = np.array([e[i] for e, i in zip(edges, place, strict=True)])
        high = np.array([e[i + 1] for e, i in zip(edges, place, strict=True)])
        middle = (low + high) / 2
        inside = [((np.array(a) < middle) & (middle < np.array(b))).all() for a, b in corners]
        if any(inside) if kind == "union" else inside[0] and not any(inside[1:]):
            volume += np.prod(high - low)
            moment += np.prod(high - low) * middle
    return volume, moment / volume if volume else moment


@settings(max_examples=60, deadline=None)
@given(st.data(), st.integers(1, 3), st.sampled_from(["union", "difference"]))
def test_sums_over_boxes_are_exact_at_any_offset(data, dimension, kind):
    """Mass, momentum (7, 8) and the first moment; (3)-(5) of unions and differences of boxes."""
    entries = data.draw(st.lists(blocks(dimension), min_size=2, max_size=3))
    volume, centre = exact_moments(kind, entries, dimension)
    assume(volume > 1e-6)
    motion, velocity = spinning(dimension)
    case = scene(
        dimension,
        body({kind: entries}, velocity=motion),
        cells=[10] * dimension,
        cell=[0.6, 0.7, 0.9][:dimension],
        per_cell=[2, 3, 1][:dimension],
    )
    p, _ = particles(case)
    # Up to 16 roundings of coordinates a box, in units of the thinnest that hold them: see
    # LatticeBody.rounding, which drops what is smaller. Volumes are at least 1e-6.
    assert p.V.sum() == pytest.approx(volume, rel=1e-12, abs=1e-12 * 0.126)
    assert p.m.sum() == pytest.approx(volume, rel=1e-12, abs=1e-12 * 0.126)
    momentum = (p.m[:, None] * p.v).sum(axis=0)
    np.testing.assert_allclose(momentum, volume * velocity(centre), rtol=1e-11, atol=1e-11 * volume)
    assert (p.V > 0.0).all()
    # The particles stand on the lattice, so their moment is off by the centroids' offsets only.
    h = np.array([0.3, 0.7 / 3, 0.9])[:dimension]
    moved = np.abs((p.m[:, None] * p.x).sum(axis=0) - volume * centre)
    assert (moved <= 0.5 * h * volume * (1 + 1e-9)).all()


@pytest.mark.parametrize("D", [1, 2, 3])
def test_a_box_on_the_lattice_is_made_of_whole_particles(D):
    """Also where its corners are not exactly those of the lattice's boxes."""
    made = {}
    for surface in ("cut", "whole"):
        block = body(box([0.3] * D, [0.9] * D), surface, [0.1] * D)
        case = scene(D, block, cells=[12] * D, cell=0.1)
        made[surface], _ = particles(case)
    for a, b in zip(made["cut"], made["whole"], strict=True):
        assert a.tobytes() == b.tobytes()
    assert len(made["cut"].m) == 12**D


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("thickness", [0.3, 1e-2, 1e-4, 1e-7])
def test_thin_plates_exist_with_their_mass(D, thickness):
    low, high = [1.1] * D, [4.4] * D
    high[-1] = low[-1] + thickness
    p, _ = particles(scene(D, body(box(low, high))))
    assert p.m.sum() == pytest.approx(thickness * 3.3 ** (D - 1), rel=1e-8)
    with pytest.raises(CaseError, match="holds no particle"):
        particles(scene(D, body(box(low, [*high[:-1], low[-1] + 0.1]), "whole")))


# -- curved surfaces

SHAPES = {
    "disk": (ball([0.0, 0.0], 1.0), 2, math.pi),
    "ball": (ball([0.0] * 3, 1.0), 3, 4 / 3 * math.pi),
    "cylinder": (cylinder([0.0, 0.0, -0.7], [0.0, 0.0, 0.6], 1.0), 3, 1.3 * math.pi),
    "tilted": (
        cylinder([-0.4, -0.3, -0.5], [0.3, 0.4, 0.6], 0.7),
        3,
        0.49 * math.pi * math.sqrt(2.19),
    ),
    "shell": (
        {"difference": [ball([0.0] * 3, 1.0), ball([0.1, 0.0, 0.0], 0.6)]},
        3,
        4 / 3 * math.pi * (1 - 0.216),
    ),
}


def volume_error(name, per_radius, surface, offset):
    """Relative error of the mass of a body whose radius is about so many particles."""
    entry, D, exact = SHAPES[name]
    cells = 3 * per_radius // 2
    h = 2.0 / per_radius
    case = scene(D, body(entry, surface), cells=[cells] * D, cell=h)
    case["grid"]["origin"] = [-1.5 + h * (o - 0.5) for o in offset[:D]]
    p, _ = particles(case)
    return p.V.sum() / exact - 1.0


@pytest.mark.parametrize("name", SHAPES)
def test_the_mass_of_round_bodies_converges_fast(name):
    """Root mean square error over offsets: fourth order, but for rims of tilted ends.

    A rim between surfaces that no plane separates is a kink within boxes. Each has an error of
    about a hundredth of its volume h^3, and 1/h of them meet the rim: h^2 in all if the errors had
    one sign. Whole particles leave an error of the order of h^3 a box with either sign, at h^-2
    boxes: h^2 as well, of a hundred times the size, and h where the surface lies along the grid.
    """
    rng = np.random.default_rng(3)
    offsets = rng.random((4, 3))
    rms = {
        (n, surface): np.sqrt(np.mean([volume_error(name, n, surface, o) ** 2 for o in offsets]))
        for n, surface in ((8, "cut"), (16, "cut"), (24, "cut"), (16, "whole"))
    }
    bound = 3e-4 if name == "tilted" else 4e-6
    assert rms[8, "cut"] < bound
    order = np.log(rms[8, "cut"] / rms[24, "cut"]) / np.log(3.0)
    assert order > (1.4 if name == "tilted" else 3.2)
    assert rms[16, "cut"] < 0.02 * rms[16, "whole"]


def polygon_area(planes):
    """Area of what planes n.x <= b leave of the square (0, 1)^2: the square is clipped by each."""
    corners = [np.array(p, float) for p in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for n, b in planes:
        kept = []
        for p, q in zip(corners, corners[1:] + corners[:1], strict=True):
            u, v = n @ p - b, n @ q - b
            if u <= 0:
                kept.append(p)
            if (u < 0 < v) or (v < 0 < u):
                kept.append(p + u / (u - v) * (q - p))
        corners = kept
    if len(corners) < 3:
        return 0.0
    x, y = np.array(corners).T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def polytope_volume(planes):
    """Volume of what planes leave of the cube: areas of slices between the heights of corners.

    In between they are quadratic in the height, which Simpson's rule integrates exactly.
    """
    cube = [(s * e, max(s, 0.0)) for e in np.eye(3) for s in (-1.0, 1.0)]
    heights = {0.0, 1.0}
    for three in combinations([*planes, *cube], 3):
        N, b = np.array([n for n, _ in three]), np.array([b for _, b in three])
        if abs(np.linalg.det(N)) > 1e-12:
            heights.add(float(np.clip(np.linalg.solve(N, b)[2], 0.0, 1.0)))

    def area(z):
        return polygon_area([(n[:2], b - n[2] * z) for n, b in planes])

    total = 0.0
    for low, high in pairwise(sorted(heights)):
        # Slices at the very ends may be cut by what begins there.
        a, c = (low + t * (high - low) for t in (0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)))
        total += 0.5 * (high - low) * (area(a) + area(c))
    return total


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 3), st.integers(1, 4))
def test_what_half_spaces_leave_of_a_box_is_exact(seed, dimension, number):
    """However many planes meet in a particle's box, at edges and corners of the body."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(number, dimension))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    feet = rng.uniform(0.1, 0.9, (number, dimension))
    unit = box([0.0] * dimension, [1.0] * dimension)
    cuts = [half_space(p, n) for p, n in zip(feet, normals, strict=True)]
    planes = [(n, n @ p) for n, p in zip(normals, feet, strict=True)]
    expected = (polygon_area if dimension == 2 else polytope_volume)(planes)
    low = np.zeros((1, dimension))
    for entry in ({"intersection": [unit, *cuts]}, {"intersection": [*cuts, unit]}):
        volume, _ = measure(region(entry), low, low + 1.0)
        assert volume[0] == pytest.approx(expected, abs=1e-12)
    rest, _ = measure(region({"difference": [unit, {"intersection": [unit, *cuts]}]}), low, low + 1)
    assert rest[0] == pytest.approx(1.0 - expected, abs=1e-12)
    case = scene(dimension, body({"intersection": [unit, *cuts]}), cells=[3] * dimension, cell=0.47)
    if expected > 1e-6:
        p, _ = particles(case)
        assert p.V.sum() == pytest.approx(expected, abs=1e-11)


def quarter(kind, D, shift=0.0):
    """A quarter or an eighth of a ball of radius 1: the part where no coordinate is below `shift`.

    Cut by half-spaces, by a box, and by what other boxes leave.
    """
    whole = ball([shift] * D, 1.0)
    axes = np.eye(D)
    if kind == "half-spaces":
        return {"intersection": [whole, *(half_space([shift] * D, -axis) for axis in axes)]}
    if kind == "box":
        return {"intersection": [whole, box([shift] * D, [3.0] * D)]}
    beyond = [box([-3.0] * D, 3.0 - (3.0 - shift) * axis) for axis in axes]
    return {"difference": [whole, *beyond]}


@pytest.mark.parametrize("surface", ["cut", "whole"])
@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", ["half-spaces", "box", "boxes"])
def test_a_quarter_of_a_ball_on_slip_planes_is_as_exact_as_the_ball(kind, D, surface):
    """The domain ends at the planes; particles and volume are those of the ball in that corner."""
    n = 8
    whole = scene(D, body(ball([0.0] * D, 1.0), surface), cells=[2 * n + 4] * D, cell=2 / n)
    whole["grid"]["origin"] = [-2 - 4 / n] * D
    part = scene(D, body(quarter(kind, D), surface), cells=[n + 2] * D, cell=2 / n)
    part["boundaries"] = {f"{axis}-min": "slip" for axis in "xyz"[:D]}
    p, _ = particles(part)
    exact = (math.pi if D == 2 else 4 / 3 * math.pi) / 2**D
    error = p.V.sum() / exact - 1.0
    assert abs(error) < (4e-6 if surface == "cut" else 0.05)
    q, _ = particles(whole)
    np.testing.assert_allclose(p.V.sum() * 2**D, q.V.sum(), rtol=1e-13)
    corner = (q.x > 0).all(axis=1)
    np.testing.assert_allclose(p.x, q.x[corner], atol=1e-13)
    np.testing.assert_allclose(p.V, q.V[corner], rtol=1e-11)


@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("kind", ["half-spaces", "box", "boxes"])
def test_a_quarter_that_ends_between_the_particles_is_as_exact(kind, D):
    """Nothing about the planes of the grid is needed, as long as the cuts lie across axes."""
    case = scene(D, body(quarter(kind, D, 0.0321)), cells=[16] * D, cell=0.2)
    case["grid"]["origin"] = [-0.4] * D
    p, _ = particles(case)
    exact = (math.pi if D == 2 else 4 / 3 * math.pi) / 2**D
    assert p.V.sum() == pytest.approx(exact, rel=2e-5)


def test_a_ball_that_a_tilted_plane_cuts_converges():
    """By second order at least, as for the rim of a tilted cylinder."""
    normal = np.array([0.48, 0.6, 0.64])
    half = {"intersection": [ball([0.0] * 3, 1.0), half_space([0.0] * 3, normal)]}
    rng = np.random.default_rng(1)
    errors = []
    for n in (8, 24):
        of = []
        for offset in rng.random((4, 3)):
            case = scene(3, body(half), cells=[3 * n // 2] * 3, cell=2 / n)
            case["grid"]["origin"] = (-1.5 + 2 / n * (offset - 0.5)).tolist()
            of.append(particles(case)[0].V.sum() / (2 / 3 * math.pi) - 1.0)
        errors.append(np.sqrt(np.mean(np.square(of))))
    assert errors[0] < 3e-4
    assert np.log(errors[0] / errors[1]) / np.log(3.0) > 1.4


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (half_space([0.5, 0.5], [1, 0]), "has no end towards x-min, y-min, y-max, which"),
        (
            {"union": [ball([1, 1], 0.5), half_space([0.5, 0.5], [0, -1])]},
            "has no end towards x-min, x-max, y-max",
        ),
        ({"intersection": [ball([1, 1], 0.5), box([3, 3], [4, 4])]}, "is empty: no point"),
        ({"difference": [box([1, 1], [2, 2]), ball([1, 1], 2)]}, "is empty: no point"),
        ({"intersection": [ball([1, 1], 2), box([0.5, 0], [4, 4])]}, "beyond the domain at y-max"),
    ],
)
def test_regions_without_an_end_or_a_point_are_refused_as_bodies(entry, message):
    case = scene(2, body(entry), cells=[8, 2])
    with pytest.raises(ValueError, match=message):
        Case.model_validate(case)
    held = {"grip": {"body": "body", "region": half_space([0.5, 0.5], [1, 0]), "velocity": [0, 0]}}
    Case.model_validate(scene(2, body(ball([1, 1], 0.5)), constraints=held))


LENGTH = st.floats(1.0, 3.0)


@st.composite
def curved(draw, dimension):
    """A region near the box (0, 1)^D, of any kind but boxes alone."""
    centre = draw(st.lists(st.floats(-1.5, 2.5), min_size=dimension, max_size=dimension))
    kinds = ["ball", "shell", "both", "part"] + ["cylinder"] * (dimension == 3)
    kind = draw(st.sampled_from(kinds))
    first = ball(centre, draw(LENGTH))
    if kind == "part":
        normals = st.lists(st.floats(-1.0, 1.0), min_size=dimension, max_size=dimension)
        cuts = draw(st.lists(normals.filter(lambda n: np.linalg.norm(n) > 0.1), max_size=2))
        return {"intersection": [first, *(half_space([0.4] * dimension, n) for n in cuts), first]}
    if kind == "ball":
        return first
    if kind == "shell":
        return {"difference": [first, ball([c + 0.1 for c in centre], draw(LENGTH))]}
    if kind == "both":
        return {
            "union": [first, box([0.2] * dimension, [c + draw(LENGTH) for c in [0.2] * dimension])]
        }
    end = draw(st.lists(st.floats(-2.0, 3.0), min_size=3, max_size=3))
    assume(math.dist(centre, end) > 0.3)
    return cylinder(centre, end, draw(LENGTH))


@settings(max_examples=80, deadline=None)
@given(st.data(), st.integers(2, 3))
def test_fractions_are_those_of_a_count_of_points(data, dimension):
    """A box cut by surfaces no more curved than it is wide, against 10^6 points within it."""
    entry = region(data.draw(curved(dimension)))
    n = 1000 if dimension == 2 else 100
    x = (np.arange(n) + 0.5) / n
    points = np.stack(np.meshgrid(*[x] * dimension, indexing="ij"), axis=-1)
    points = points.reshape(-1, dimension)
    inside = entry.contains(points)
    volume, moment = measure(entry, np.zeros((1, dimension)), np.ones((1, dimension)))
    # Two nodes a direction. Of a ball that just fits into the box, in a scene as large as a
    # particle, they find 0.577 for 0.524; so radii here are at least the width of the box. Where a
    # plane meets such a ball within the box, the piece beyond both is off by up to 0.048.
    corner = "HalfSpace" in repr(entry)
    assert volume[0] == pytest.approx(inside.mean(), abs=0.06 if corner else 0.03)
    expected = (inside[:, None] * (points - 0.5)).mean(axis=0)
    np.testing.assert_allclose(moment[0], expected, atol=0.03 if corner else 0.015)


@settings(max_examples=80, deadline=None)
@given(
    st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
    st.floats(-0.7, 0.7),
)
def test_flat_cuts_at_any_angle_are_exact(normal, shift):
    """The end of a wide cylinder, against the volume cut off a cube by a plane (closed form)."""
    normal = np.array(normal)
    assume(np.linalg.norm(normal) > 0.1)
    normal /= np.linalg.norm(normal)
    assume(np.abs(normal).min() > 1e-2)  # the closed form below divides by the product
    foot = 0.5 + shift * normal
    entry = region(cylinder((foot - 50.0 * normal).tolist(), foot.tolist(), 40.0))
    volume, _ = measure(entry, np.zeros((1, 3)), np.ones((1, 3)))
    # Reflections that make the normal positive; then the sum over the corners of max(., 0)^3.
    level = normal @ foot - np.minimum(normal, 0.0).sum()
    n = np.abs(normal)
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        total += (-1) ** sum(corner) * max(level - n @ np.array(corner), 0.0) ** 3
    assert volume[0] == pytest.approx(total / (6 * n.prod()), abs=1e-9)


@settings(max_examples=100, deadline=None)
@given(st.data(), st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_what_is_measured_does_not_depend_on_the_others(data, dimension, seed):
    entry = region(data.draw(curved(dimension)))
    low = np.random.default_rng(seed).uniform(-1.0, 2.0, (12, dimension))
    together = measure(entry, low, low + 0.4)
    for i in (0, 5, 11):
        alone = measure(entry, low[i : i + 1], low[i : i + 1] + 0.4)
        assert alone[0][0] == together[0][i]
        assert (alone[1][0] == together[1][i]).all()


@settings(max_examples=25, deadline=None)
@given(st.data(), st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_volumes_of_any_region_are_those_of_a_count(data, dimension, seed):
    """Unions, differences and intersections of all kinds, within a box, by points at random.

    A point in each of many small boxes: only those at the surface tell by chance.
    """
    limits = box([-4.0] * dimension, [4.0] * dimension)
    found = region({"intersection": [data.draw(entries(dimension)), limits]})
    edges, n = np.linspace(-4.1, 4.1, 42), {1: 100_000, 2: 700, 3: 100}[dimension]
    centres = 0.5 * (edges[1:] + edges[:-1])
    body = LatticeBody(found, [edges] * dimension, [centres] * dimension, True)
    surveys = body.slabs((0, 41))
    try:
        volume = sum(s.fractions.sum() + np.delete(s.whole, s.places).sum() for s in surveys)
    except TangledError:
        assume(False)
    volume *= 0.2**dimension
    rng = np.random.default_rng(seed)
    points = np.stack(np.meshgrid(*[np.arange(n)] * dimension), axis=-1).reshape(-1, dimension)
    points = -4.1 + 8.2 / n * (points + rng.random(points.shape))
    counted = found.contains(points).mean() * 8.2**dimension
    # Six standard deviations of 1e5 boxes at the surface, 0.02 * 6; and what balls that are
    # smaller than a particle's box, 0.2, leave.
    assert volume == pytest.approx(counted, abs=0.2, rel=2e-3)


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


def test_of_many_parts_only_those_nearby_are_looked_at(monkeypatch):
    """The same bits as looking at all of them."""
    balls = [ball([2.0 + 3.7 * i, 2.0 + 3.3 * j], 1.9) for i in range(6) for j in range(3)]
    holed = {"difference": [box([0.3, 0.3], [23.0, 11.0]), *balls, {"union": balls}]}
    edges = [np.arange(49) * 0.5, np.arange(25) * 0.5]
    centres = [0.5 * (e[1:] + e[:-1]) for e in edges]

    def surveys(entry):
        found = LatticeBody(region(entry), edges, centres, True).slabs((0, 48))
        return [[np.asarray(part).tobytes() for part in survey] for survey in found]

    for entry in ({"union": balls}, holed):
        nearby = surveys(entry)
        with monkeypatch.context() as patched:
            patched.setattr(latticebody, "_FEW", 10**6)
            assert surveys(entry) == nearby


def test_more_surfaces_in_a_box_than_can_be_told_apart_are_refused():
    balls = [ball([0.5, 0.5], 0.1 + 1e-4 * i) for i in range(200)]
    with pytest.raises(TangledError, match="more surfaces in one particle's box"):
        measure(region({"union": balls}), np.zeros((1, 2)), np.ones((1, 2)))


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
