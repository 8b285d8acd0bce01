"""Mean dilatation of bodies exact to their surface: patches, potential, no locking."""

from itertools import product

import numpy as np
import pytest
from scenes import SOFT, finish, scene, start

from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD
from pgimp.solver.lagrangian.masters import Vertices

pytestmark = pytest.mark.slow(40)

PUSH = 0.05


def cut_body(D, region, poisson, **parts):
    """A scene of a body in the initial configuration with mean dilatation."""
    velocity = parts.pop("velocity", None)
    body = {"material": "soft", "region": region, "configuration": "initial", "surface": "exact"}
    body |= {"velocity": velocity} if velocity else {}
    case = scene(D, body, materials={"soft": SOFT | {"poisson": poisson}}, **parts)
    case["method"]["volumetric"] = "mean"
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


def potential(sim, u):
    """Energy of the displacements u, (*vertices, 2), of hooke's law; by NumPy alone."""
    p, rows, slaves = sim.particles, sim.live(), sim.rank.slaves
    x, c = p.origin[rows], p.products[rows, 0]
    first = np.floor(x).astype(int)
    t, F = x - first, np.zeros((len(rows), 2, 2))
    for i, j in product((0, 1), repeat=2):
        a, b = (t[:, 0] if i else 1 - t[:, 0]), (t[:, 1] if j else 1 - t[:, 1])
        dN = np.stack([(2 * i - 1) * b, (2 * j - 1) * a], axis=1)
        F += u[first[:, 0] + i, first[:, 1] + j][:, :, None] * dN[:, None]
    assert c.any()  # not in gradients, which are linear
    # Cells with slaves follow the cell that most of these follow.
    ghost = sim.scene.domain.frame.ghost
    places = [
        np.stack([n - ghost for n in Vertices.numbers(sim.rank, keys)[:2]], axis=1)
        for keys in (slaves.keys, slaves.masters)
    ]
    roots = {tuple(x): tuple(places[1][slaves.of[s]].min(axis=0)) for s, x in enumerate(places[0])}
    groups = {}
    for k, cell in enumerate(map(tuple, first)):
        own = [(cell[0] + i, cell[1] + j) for i, j in product((0, 1), repeat=2)]
        found = sorted(roots[v] for v in own if v in roots)
        root = max(found, key=found.count) if found else cell
        groups.setdefault(root, []).append(k)
    V, energy = p.V0[rows], 0.0
    nu, young = 0.49, SOFT["young"]
    mu = 0.5 * young / (1.0 + nu)
    bulk = 2.0 * mu * nu / (1.0 - 2.0 * nu) + mu  # of plane strain
    trace = F[:, 0, 0] + F[:, 1, 1]
    for k in groups.values():
        energy += 0.5 * bulk * V[k].sum() * ((V[k] * trace[k]).sum() / V[k].sum()) ** 2
    e = 0.5 * (F + F.transpose(0, 2, 1)) - 0.5 * trace[:, None, None] * np.eye(2)
    return (
        energy + (mu * V * (e * e).sum(axis=(1, 2))).sum(),
        len(groups),
        len({*map(tuple, first)}),
    )


def test_forces_are_those_of_a_potential():
    """Small displacements: the first step's momenta are slopes of an energy by NumPy."""
    dt = 1e-4
    case = cut_body(2, box((1.37, 1.98), 4.0), 0.49, cells=[8, 8], step=dt, end=1.0)
    sim = start(case)
    rank, ghost = sim.rank, sim.scene.domain.frame.ghost
    slaves, size, rng = rank.slaves, 1e-6, np.random.default_rng(3)
    kept = rank.grid.kept.values
    records = kept.reshape(-1, RECORD)
    moving = np.flatnonzero(records[:, 0] > 0.0)
    records[moving, 5:7] = size * rng.uniform(-1.0, 1.0, (len(moving), 2)) / dt
    slaves.spread(rank, kept, 5)
    sim.advance()  # by which it is displaced
    before = records.copy()
    sim.advance()
    force = (records[:, 5:7] - before[:, 5:7]) * records[:, :1] / dt

    def field(values):
        grid = rank.grid.by_vertex(values.reshape(-1))
        assert grid.shape[1] == grid.shape[3] == 1
        found, lower = np.zeros((16, 16, 2)), rank.grid.window.lower
        for i, j in product(range(grid.shape[0]), range(grid.shape[2])):
            vector = grid[i, 0, j, 0, DISPLACEMENT : DISPLACEMENT + 2]
            found[i + lower[0] - ghost, j + lower[1] - ghost] = vector
        return found

    _, groups, cells = potential(sim, field(before))
    assert groups < cells
    for row in moving[:: len(moving) // 7]:
        for d in range(2):
            ends = []
            for side in (1.0, -1.0):
                moved = before.copy()
                moved[row, DISPLACEMENT + d] += side * size
                slaves.spread(rank, moved.reshape(-1), DISPLACEMENT)
                ends.append(potential(sim, field(moved))[0])
            slope = (ends[0] - ends[1]) / (2.0 * size)
            np.testing.assert_allclose(-force[row, d], slope, rtol=1e-3, atol=1e-3 * size * 100.0)


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
    """A beam that lies .3 of a cell off, with slaves on its top, bends as one along the cells."""
    (along, most), (cut, pressure) = (deflection(low) for low in (2.0, 2.3))
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
