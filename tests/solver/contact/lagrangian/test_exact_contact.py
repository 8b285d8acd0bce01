"""Contact of bodies that are exact to their surface: rows of parts, masters in place of slaves."""

from itertools import product

import numpy as np
import pytest
from scenes import SOFT, finish, scene, start

from pgimp.kernels.contact.lagrangian.books import book_mirrored
from pgimp.kernels.contact.lagrangian.reference_grid import key_bits, key_of_vertex
from pgimp.kernels.contact.lagrangian.reference_numbers import WIDE, ReferenceSupports, add_part
from pgimp.kernels.contact.surfaces.groups import solve_groups
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD
from pgimp.solver.contact.lagrangian.lagrangian import LagrangianContact
from pgimp.solver.lagrangian.masters import Vertices

pytestmark = pytest.mark.slow(60)

HARD = SOFT | {"young": 1000.0}
TOP = {"of": [0.0, 1.0]}


def exact(region, **more):
    """A body in the initial configuration, exact to its surface."""
    body = {"material": "soft", "region": region, "configuration": "initial"}
    return body | more


#: A body that meets nobody: beside whole particles, all meet at vertices of the grid.
IDLE = {"material": "soft", "configuration": "initial", "surface": "whole"}


def with_idle(bodies, low, high):
    return bodies | {"idle": IDLE | {"region": {"box": {"min": low, "max": high}}}}


def block(low, high, **more):
    return exact({"box": {"min": low, "max": high}}, **more)


def energy(line):
    return line["kinetic-energy"] + line["strain-energy"]


@pytest.mark.parametrize("D", [2, 3])
def test_rows_of_a_part_are_means_over_it(D):
    """N + grad N . way of a cell's vertices: means over a simplex, by sums over its points."""
    rng = np.random.default_rng(1)
    corner = rng.uniform(0.1, 0.9, (D + 1, D))
    weights = rng.dirichlet(np.ones(D + 1), 200_000)
    points = weights @ corner
    centroid = points.mean(axis=0)
    away = points - centroid
    pairs = ((1, 2), (0, 2), (0, 1), (0, 1, 2)) if D == 3 else ((0, 1),)
    middle, way = np.full(D, 0.5), rng.uniform(-1.0, 1.0, D)
    parts = np.zeros((1, 7))
    parts[0, 3 - D : 3] = centroid - middle
    parts[0, 3 : 3 + len(pairs)] = [away[:, each].prod(axis=1).mean() for each in pairs]
    supports = ReferenceSupports.empty(1)
    supports.first[:], supports.many[:] = 0, 1
    supports.w[:], supports.g[:] = 1.0, 0.0
    supports.many[0, 3 - D :] = 2
    for axis in range(D):
        row, c = 3 - D + axis, centroid[axis]
        supports.w[row, :2], supports.g[row, :2] = (1.0 - c, c), (-1.0, 1.0)
    box = np.zeros((WIDE * WIDE, WIDE))
    by_axis = tuple(np.concatenate([np.zeros(3 - D), way]))
    add_part.py_func(box, supports, 0, (0, 0, 0), 2.0, by_axis, parts)
    to = middle + way - centroid  # from the centroid to the row's vertex
    box = box.reshape(WIDE, WIDE, WIDE)
    for vertex in product((0, 1), repeat=D):
        n = np.where(np.array(vertex) == 1, points, 1.0 - points)
        sign = np.where(np.array(vertex) == 1, 1.0, -1.0)
        truth = n.prod(axis=1).mean()
        for d in range(D):
            truth += to[d] * sign[d] * np.delete(n, d, axis=1).prod(axis=1).mean()
        found = box[(*[0] * (3 - D), *vertex)]
        assert found == pytest.approx(2.0 * truth, abs=1e-10)


def disks(**parts):
    """Two disks of four cells' radius, cut anywhere, that meet head on as they pass."""
    bodies = {
        name: exact({"ball": {"centre": [x, y], "radius": 2.0}}, velocity=[v, 0.02])
        for name, x, y, v in (("a", 3.13, 3.13, 0.2), ("b", 7.33, 3.38, -0.2))
    }
    bodies = with_idle(bodies, [0.1, 5.6], [1.0, 6.3])
    return scene(2, bodies, cells=[24, 13], cell=0.5, end=3.0, step={"courant": 0.3},
                 materials={"soft": HARD}, contact=[{"bodies": "all", "friction": 0.3}],
                 **parts)  # fmt: skip


def test_disks_keep_momentum_spin_and_energy():
    sim = start(disks())
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    push = first["body.a.momentum-x"]
    assert len(sim.rank.slaves.keys) > 20
    assert last["body.a.momentum-x"] < -0.8 * push
    for name in ("momentum-x", "momentum-y", "angular-momentum-z"):
        assert abs(last[name] - first[name]) < 1e-11 * push
    assert 0.9 < energy(last) / energy(first) < 1.0


def test_rows_extrapolate_affine_motions_from_vertices_that_are_no_slaves(monkeypatch):
    """The sum of a row is 1, its vertices' places in space give the contact vertex."""
    found, couple = [], LagrangianContact._couple

    def keep(self, near, contact_vertices, pairs):
        coupling = couple(self, near, contact_vertices, pairs)
        found[:] = near, pairs, coupling
        return coupling

    monkeypatch.setattr(LagrangianContact, "_couple", keep)
    sim = start(disks())
    while sim.time < 0.9:
        before = sim.rank.grid.kept.values.copy()
        sim.advance()
    near, pairs, coupling = found
    rank, frame = sim.rank, sim.scene.domain.frame
    bits = key_bits.py_func(frame, 2)
    fold = {}
    for keys in (rank.slaves.keys, rank.slaves.masters):
        x, y, z, field = Vertices.numbers(rank, keys)
        fold.update(zip(key_of_vertex.py_func(bits, (x, y, z), field).tolist(), keys, strict=True))
    slaves = set(rank.slaves.keys.tolist())
    keys = near.vertices.keys[coupling.column]
    assert not any(fold.get(key) in slaves for key in keys.tolist())
    field = keys & ((1 << bits[2]) - 1)
    x = keys >> (bits[0] + bits[1] + bits[2])
    y = (keys >> (bits[1] + bits[2])) & ((1 << bits[0]) - 1)
    window = rank.grid.window
    at = (x - window.lower[0]) * window.stride[0] + (y - window.lower[1]) * window.stride[1]
    at += field * window.extent[1] * window.extent[2] * RECORD
    place = np.stack([x, y], axis=1) - frame.ghost
    place = place * 0.5 + before[at[:, None] + DISPLACEMENT + np.arange(2)]
    some = 0
    for end in pairs.ends:
        for r in end["rows"]:
            k = slice(coupling.start[r], coupling.start[r + 1])
            entry = coupling.entry[k, 0]
            assert entry.sum() == pytest.approx(1.0, abs=1e-12)
            vertex = (end["vertex"][:2] - frame.ghost) * 0.5
            np.testing.assert_allclose(entry @ place[k], vertex, atol=1e-9)
            some += 1
    assert some > 4


@pytest.mark.parametrize("by", ["vertices", "surfaces"])
@pytest.mark.parametrize("floor", ["wall", "rigid"])
def test_a_cut_block_rests_on_a_floor(floor, by):
    """The floor bears its weight; nothing goes through, along the grid and across it."""
    bodies = {"block": block([1.98, 1.0], [5.02, 4.03])}
    case = scene(2, bodies, cells=[8, 6], end=6.0, step={"courant": 0.3},
                 materials={"soft": HARD}, gravity=[0.0, -1.0],
                 damping={"mass": 3.0})  # fmt: skip
    if floor == "wall":
        bodies["block"]["region"] = {"box": {"min": [1.98, 0.0], "max": [5.02, 3.03]}}
        case["boundaries"] = {"y-min": "separating"}
        name = "reaction.y-min-y"
    else:
        low = {"box": {"min": [-2.0, -3.0], "max": [10.0, 1.0]}}
        bodies["floor"] = {"rigid": {}, "region": low}
        case["contact"] = [{"bodies": "all"}]
        name = "tool.floor.force-y"
    case["bodies"] = with_idle(bodies, [6.6, 4.5], [7.5, 5.5]) if by == "vertices" else bodies
    sim = start(case)
    sim.diagnostics()
    line = finish(sim).diagnostics()
    assert abs(line[name]) == pytest.approx(line["body.block.mass"], rel=1e-2)
    assert abs(line["momentum-x"]) < 1e-12


def test_surfaces_beside_a_mirror_have_no_images():
    """Their rows are of vertices before it: it has no share of contact, which no row has."""
    bodies = {
        "block": block([0.0, 1.0], [3.1, 3.03]),
        "floor": {"rigid": {}, "region": {"box": {"min": [-2.0, -3.0], "max": [10.0, 1.0]}}},
    }
    case = scene(2, bodies, cells=[8, 6], end=0.5, step={"courant": 0.3}, wall="mirror",
                 materials={"soft": HARD}, gravity=[0.0, -1.0], boundaries={"x-min": "slip"},
                 contact=[{"bodies": "all"}])  # fmt: skip
    sim, called = start(case), set()
    contact, call = sim.rank.contact, sim.rank.contact.call

    def note(kernel, *arguments):
        called.add(kernel)
        return call(kernel, *arguments)

    contact.call = note
    finish(sim)
    assert solve_groups in called and book_mirrored not in called


def test_tied_bodies_pass_uniform_stress_on():
    """Across a joint anywhere in a cell, both exact to it."""
    bodies = {"low": block([1.37, 1.21], [5.37, 3.13]), "high": block([1.37, 3.13], [5.37, 5.21])}
    top = {"box": {"min": [0.0, 4.0], "max": [9.0, 9.0]}}
    tractions = {
        "top": {"body": "high", "region": top, "traction": [0.0, 0.05], "normal": TOP},
        "bottom": {"body": "low", "face": "y-min", "traction": [0.0, -0.05]},
    }
    bodies = with_idle(bodies, [7.5, 7.5], [8.5, 8.5])
    sim = start(scene(2, bodies, cells=[9, 9], end=3.0, step=0.02, tractions=tractions,
                      damping={"mass": 8.0},
                      contact=[{"bodies": "all", "law": "tied"}]))  # fmt: skip
    finish(sim)
    stress = sim.particles.sigma[sim.live()][sim.particles.body[sim.live()] < 2]
    np.testing.assert_allclose(stress[:, 1], 0.05, rtol=3e-3)
    assert abs(sim.diagnostics()["momentum-y"]) < 1e-10


def test_no_slave_follows_a_cell_of_another_body():
    """Bodies that far apart have no common vertices, but cells of both are within reach."""
    bodies = {
        "thin": block([1.9, 1.3], [2.03, 6.7], velocity=[0.1, 0.0]),
        "thick": block([4.6, 1.0], [7.0, 6.0]),
    }
    bodies = with_idle(bodies, [4.0, 7.2], [7.0, 7.8])
    sim = start(scene(2, bodies, per_cell=4, end=0.1, contact=[{"bodies": "all"}]))
    finish(sim)
    p, rows = sim.particles, sim.live()
    assert isinstance(sim.rank.contact, LagrangianContact)
    np.testing.assert_allclose(p.v[rows, 0], np.where(p.body[rows] == 0, 0.1, 0.0), atol=1e-12)


def test_rings_meet_and_keep_momentum():
    """Cylinders cut anywhere; their mass is not in the middle of their sections."""
    bodies = {
        "a": block([0.0, 1.03], [3.02, 4.4], velocity=[0.0, 0.2]),
        "b": block([0.5, 5.0], [3.47, 8.03], velocity=[0.0, -0.2]),
    }
    meet = [{"bodies": "all", "friction": 0.3}]
    case = scene(2, bodies, cells=[6, 10], end=3.0, step={"courant": 0.3}, contact=meet,
                 materials={"soft": HARD})  # fmt: skip
    sim = start(case | {"geometry": "axisymmetric"})
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    push = first["body.a.momentum-y"]
    assert last["body.a.momentum-y"] < -0.9 * push
    assert abs(last["momentum-y"] - first["momentum-y"]) < 1e-12 * push
    assert 0.9 < energy(last) / energy(first) < 1.0
