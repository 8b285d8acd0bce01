"""Mean dilatation of bodies exact to their surface: patches, potential, no locking."""

from itertools import product

import numpy as np
import pytest
from scenes import SOFT, finish, scene, start

import pgimp
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD
from pgimp.solver.lagrangian.masters import Vertices

pytestmark = pytest.mark.slow(40)

PUSH = 0.05


def cut_body(D, region, poisson, **parts):
    """A scene of a body in the initial configuration with mean dilatation."""
    velocity = parts.pop("velocity", None)
    body = {"material": "soft", "region": region, "formulation": "total-lagrangian"}
    body |= {"velocity": velocity} if velocity else {}
    case = scene(D, body, materials={"soft": SOFT | {"poisson": poisson}}, **parts)
    case["method"]["volumetric"] = "b-bar"
    return case


def box(low, size):
    return {"box": {"min": list(low), "max": (np.array(low) + size).tolist()}}


@pytest.mark.parametrize("low", [(1.37, 1.21), (1.999, 2.4)])
def test_uniform_stress_of_a_block(low):
    """Under a traction, with slaves on two sides and cells that hold a thousandth."""
    loads = {
        name: {"body": "body", "face": name, "traction": [0.0, sign * PUSH]}
        for name, sign in (("y-max", 1.0), ("y-min", -1.0))
    }
    case = cut_body(
        2, box(low, 4.0), 0.49, cells=[9, 9], end=4.0, step={"courant": 0.7}, tractions=loads,
        damping={"mass": 8.0},
    )  # fmt: skip
    sim = start(case)
    finish(sim)
    stress = sim.particles.sigma[sim.live()]
    np.testing.assert_allclose(stress[:, 1], PUSH, rtol=2e-3)
    np.testing.assert_allclose(stress[:, [0, 3]], 0.0, atol=2e-3 * PUSH)


@pytest.mark.parametrize("D", [2, pytest.param(3, marks=pytest.mark.wide)])
def test_uniform_pressure_on_a_ball(D):
    centre = [3.13, 2.91, 3.27][:D]
    region = {"ball": {"centre": centre, "radius": 2.2}}
    load = {"all": {"body": "body", "region": box([0.0] * D, 7.0), "pressure": PUSH}}
    case = cut_body(
        D, region, 0.499, cells=[7] * D, end=2.0, step={"courant": 0.7}, tractions=load,
        damping={"mass": 12.0},
    )  # fmt: skip
    sim = start(case)
    finish(sim)
    normal = sim.particles.sigma[sim.live()][:, :D]
    np.testing.assert_allclose(normal, -PUSH, rtol=0.03)


@pytest.mark.wide
def test_uniform_pressure_on_rings():
    """A ball that is cut anywhere, on the axis."""
    balls = [{"ball": {"centre": [0.0, 3.13], "radius": 2.3}}, box([0.0, 0.0], 7.0)]
    load = {"all": {"body": "body", "region": box([0.0, 0.0], 7.0), "pressure": PUSH}}
    case = cut_body(
        2, {"intersection": balls}, 0.499, cells=[7, 7], end=2.0, step={"courant": 0.5},
        tractions=load, damping={"mass": 12.0}, geometry="axisymmetric",
    )  # fmt: skip
    sim = start(case)
    finish(sim)
    np.testing.assert_allclose(sim.particles.sigma[sim.live()][:, :3], -PUSH, rtol=5e-3)


def slopes(sim):
    """Gradients of cells' corners at particles, (n, 2^D, D), and the corners' numbers."""
    p, rows, D = sim.particles, sim.live(), sim.scene.dimension
    x, products = p.origin[rows], p.products[rows]
    first = np.floor(x).astype(int)
    t, found, at = x - first, [], []
    for corner in product((0, 1), repeat=D):
        sign, n = 2.0 * np.array(corner) - 1.0, np.where(corner, t, 1.0 - t)
        each = []
        for d in range(D):
            i, j = (k for k in range(3) if k != d) if D == 3 else (1 - d, 1 - d)
            across = n[:, i] * n[:, j] + sign[i] * sign[j] * products[:, d] if D == 3 else n[:, i]
            each.append(sign[d] * across)
        found.append(np.stack(each, axis=1))
        at.append(first + corner)
    return np.stack(found, axis=1), np.stack(at, axis=1)


def groups_of(sim):
    """Numbers of the cells whose dilatation each particle shares."""
    rank, mean = sim.rank, sim.rank.mean_dilatation
    cells = Vertices.cells_under(rank, sim.live())
    at = np.minimum(np.searchsorted(mean.cells, cells), len(mean.cells) - 1)
    root = np.where(mean.cells[at] == cells, mean.roots[at], cells)
    assert (root != cells).any()
    _, group = np.unique([root, sim.particles.body[sim.live()]], axis=1, return_inverse=True)
    return group.reshape(-1)


@pytest.mark.parametrize("D", [2, pytest.param(3, marks=pytest.mark.wide)])
def test_forces_are_those_of_a_potential(D):
    """Large displacements: momenta of a step are slopes of an energy by NumPy.

    A small body is alone in its cell.
    """
    dt, size, poisson = 1e-4, 0.1, 0.3
    body = {"material": "soft", "formulation": "total-lagrangian"}
    bodies = {
        "body": body | {"region": box([1.2, 0.98, 1.0][:D], [3.1, 3.0, 2.4][:D])},
        "crumb": body | {"region": box([5.25] * D, 0.5)},
    }
    case = scene(D, bodies, materials={"soft": SOFT | {"poisson": poisson}}, step=dt, end=1.0)
    case["method"]["volumetric"] = "b-bar"
    sim = start(case)
    rank, ghost = sim.rank, sim.scene.domain.frame.ghost
    slaves, rng = rank.slaves, np.random.default_rng(3)
    kept = rank.grid.kept.values
    records = kept.reshape(-1, RECORD)
    velocity, place = slice(5, 5 + D), slice(DISPLACEMENT, DISPLACEMENT + D)
    moving = np.flatnonzero(records[:, 0] > 0.0)
    records[moving, velocity] = size * rng.uniform(-1.0, 1.0, (len(moving), D)) / dt
    slaves.spread(rank, kept, 5)
    sim.advance()  # by which it is displaced
    records[:, velocity] = 0.0
    before = records.copy()
    sim.advance()
    force = records[:, velocity] * records[:, :1] / dt
    gradients, at = slopes(sim)
    group, V, lower = groups_of(sim), sim.particles.V0[sim.live()], rank.grid.window.lower
    corner = tuple(np.moveaxis(at + ghost - np.array(lower[:D]), -1, 0))
    mu = 0.5 * SOFT["young"] / (1.0 + poisson)
    lam = 2.0 * mu * poisson / (1.0 - 2.0 * poisson)

    def potential(values):
        """Energy of the displacements of vertices, all particles with their group's dilatation."""
        grid = rank.grid.by_vertex(values.reshape(-1))[:, 0]
        u = grid[(*corner, *[0] * (3 - D), place)]
        F = np.eye(D) + np.einsum("nci,ncj->nij", u, gradients)
        G = np.stack([np.bincount(group, V * each) for each in F.reshape(-1, D * D).T], axis=1)
        G = (G / np.bincount(group, V)[:, None]).reshape(-1, D, D)[group]
        J = np.linalg.det(G)
        r = (J / np.linalg.det(F)) ** (1.0 / D)
        trace = (r * r) * (F * F).sum(axis=(1, 2)) + 3.0 - D
        return (V * (0.5 * mu * (trace - 3.0) - mu * np.log(J) + 0.5 * lam * np.log(J) ** 2)).sum()

    for _ in range(5):
        way, ends = rng.normal(size=(len(moving), D)), []
        for side in (1e-5, -1e-5):
            moved = before.copy()
            moved[moving, place] += side * way
            slaves.spread(rank, moved.reshape(-1), DISPLACEMENT)
            ends.append(potential(moved))
        slope = (ends[0] - ends[1]) / 2e-5
        assert -(force[moving] * way).sum() == pytest.approx(slope, rel=1e-6)


def deflection(low):
    """Deflection of the end of a short beam, nearly incompressible, at rest."""
    load = {"end": {"body": "body", "face": "x-max", "traction": [0.0, -0.01]}}
    region = {"box": {"min": [0.0, low], "max": [8.0, low + 4.0]}}
    case = cut_body(
        2, region, 0.4999, cells=[10, 8], end=20.0, step={"courant": 0.7}, tractions=load,
        damping={"mass": 0.9}, boundaries={"x-min": "fixed"},
    )  # fmt: skip
    sim = start(case)
    finish(sim)
    p, rows = sim.particles, sim.live()
    end = p.origin[rows, 0] > 7.4
    u = p.x[rows] - p.origin[rows]
    pressure = p.sigma[rows][:, :2].sum(axis=1)
    return np.average(u[end, 1], weights=p.V0[rows][end]), np.abs(pressure).max()


def test_no_locking_where_cells_hold_little():
    """A beam that lies off the cells bends as one along them: by .3, with slaves on its top.

    By half a cell no particle is cut, but cells are half full.
    """
    (along, most), *others = (deflection(low) for low in (2.0, 2.3, 2.5))
    for cut, pressure in others:
        assert cut == pytest.approx(along, rel=0.03)
        assert pressure < 1.3 * most


def test_spin_momentum_and_energy():
    spin = {"rotation": {"about": [4.0, 4.0], "rate": 0.8}, "translation": [0.1, 0.0]}
    region = box((1.98, 2.02), 4.0)
    sim = start(cut_body(2, region, 0.49, cells=[9, 9], end=1.0, step=0.005, velocity=spin))
    first = sim.diagnostics()
    finish(sim)
    last = sim.diagnostics()
    for name in ("momentum-x", "momentum-y", "angular-momentum-z"):
        np.testing.assert_allclose(last[name], first[name], rtol=1e-12)
    energy = [line["kinetic-energy"] + line["strain-energy"] for line in (first, last)]
    np.testing.assert_allclose(*energy, rtol=2e-3)


@pytest.mark.parametrize(
    ("volumetric", "low", "high"), [("pointwise", 0.92, 0.96), ("b-bar", 0.98, 1.02)]
)
def test_a_beam_of_rubber_on_few_cells(volumetric, low, high, tmp_path):
    """Poisson's ratio 0.4, four cells over its height, beside Timoshenko's beam in plane strain."""
    young, poisson, length, load = 1.0e6, 0.4, 10.0, 10.0
    case = {
        "format": 2, "dimensions": 2, "time": {"end": 1.0e-6},
        "grid": {"size": [12.0, 4.0], "cell": [0.25, 0.25]},
        "materials": {"rubber": {"model": "neo-hookean", "young": young, "poisson": poisson,
                                 "density": 1000.0}},
        "bodies": {"beam": {"material": "rubber", "region": box((0.0, 1.5), (length, 1.0)),
                            "volumetric": volumetric}},
        "boundaries": {"x-min": "fixed"}, "start": {"equilibrate": {"tolerance": 1.0e-5}},
        "tractions": {"end": {"body": "beam", "face": "x-max", "traction": [0.0, -load]}},
        "probes": {"tip": {"body": "beam", "at": [length - 0.01, 2.0]}},
    }  # fmt: skip
    found = -pgimp.run(case, output=tmp_path / "run", quiet=True).probes["tip"]["displacement-y"][
        -1
    ]
    bends = load * length**3 / 3.0 / (young / (1.0 - poisson**2) / 12.0)
    shears = load * length / (5.0 / 6.0 * young / 2.0 / (1.0 + poisson))
    assert low < found / (bends + shears) < high
