"""Bodies whose surface cuts particles' boxes: volumes and masses, exact or by convergence."""

import math

import numpy as np
import pytest
from cut_bodies import ball, body, box, cylinder, half_space, particles, region, spinning
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from region_entries import entries
from scenes import scene

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.measure import TangledError, measure
from pgimp.scene.bodies import lattice_body as latticebody
from pgimp.scene.bodies.lattice_body import LatticeBody

pytestmark = pytest.mark.slow(105)

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
    for surface in ("cut-particles", "whole-particles"):
        block = body(box([0.3] * D, [0.9] * D), surface, [0.1] * D)
        case = scene(D, block, cells=[12] * D, cell=0.1)
        made[surface], _ = particles(case)
    for a, b in zip(made["cut-particles"], made["whole-particles"], strict=True):
        assert a.tobytes() == b.tobytes()
    assert len(made["cut-particles"].m) == 12**D


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("thickness", [0.3, 1e-2, 1e-4, 1e-7])
def test_thin_plates_exist_with_their_mass(D, thickness):
    low, high = [1.1] * D, [4.4] * D
    high[-1] = low[-1] + thickness
    p, _ = particles(scene(D, body(box(low, high))))
    assert p.m.sum() == pytest.approx(thickness * 3.3 ** (D - 1), rel=1e-8)
    with pytest.raises(CaseError, match="contains no particle"):
        particles(scene(D, body(box(low, [*high[:-1], low[-1] + 0.1]), "whole-particles")))


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
        for n, surface in (*((n, "cut-particles") for n in (8, 16, 24)), (16, "whole-particles"))
    }
    bound = 3e-4 if name == "tilted" else 4e-6
    assert rms[8, "cut-particles"] < bound
    order = np.log(rms[8, "cut-particles"] / rms[24, "cut-particles"]) / np.log(3.0)
    assert order > (1.4 if name == "tilted" else 3.2)
    assert rms[16, "cut-particles"] < 0.02 * rms[16, "whole-particles"]


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
        volume = sum(s.fractions.sum() + np.delete(s.whole, s.indices).sum() for s in surveys)
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
