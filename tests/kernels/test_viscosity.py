"""Artificial viscosity (45): its value, its place in the step, shocks, energy, the step's limit."""

import numpy as np
import pytest
from reference import Reference
from reference_materials import matrix, tensor
from scenes import BAR, SOFT, box, field, finish, scene, start

VISCOSITY = {"linear": 0.2, "quadratic": 2.0}
#: In one scene: both coefficients, one of them, none.
KINDS = {"both": VISCOSITY, "square": {"linear": 0.0, "quadratic": 3.0}, "none": None}


def three(dimension, **parts):
    """Three bodies side by side, of materials that differ in their viscosity, stirred."""
    soft = BAR if dimension == 1 else SOFT
    materials = {
        name: {**soft, "density": 1.0 + n} | ({"viscosity": entry} if entry else {})
        for n, (name, entry) in enumerate(KINDS.items())
    }
    if parts.pop("bare", False):
        materials = {name: {k: v for k, v in m.items() if k != "viscosity"}
                     for name, m in materials.items()}  # fmt: skip
    high = [3.0] * (dimension - 1)
    bodies = {
        name: box([3.0 * n + 1, *[1.0] * (dimension - 1)], [3.0 * n + 4, *high], material=name)
        for n, name in enumerate(KINDS)
    }
    cell = [1.0, 0.5][:dimension]
    return scene(
        dimension, bodies, cells=[11, 8][:dimension], cell=cell, materials=materials,
        **{"end": 0.2, **parts},
    )  # fmt: skip


def squeeze(sim):
    """Give the particles a velocity that closes some places and opens others."""
    p, rows = sim.particles, sim.live()
    p.v[rows] += 0.5 * np.sin(2.2 * p.x[rows] + 0.5)


def expected(sim, F, before):
    """(45) of all particles from F now and before, in plain NumPy."""
    D, L = sim.scene.dimension, min(sim.case.grid.cell)
    q = np.zeros(len(F))
    for p, body in enumerate(field(sim, "body")):
        name = list(KINDS)[body]
        c1, c2 = (KINDS[name] or {"linear": 0.0, "quadratic": 0.0}).values()
        now, old = matrix(F[p]), matrix(before[p])
        gradient = (now @ np.linalg.inv(old) - np.eye(3)) / sim.dt
        rate, J = np.trace(gradient), np.linalg.det(now)
        rho0 = 1.0 + body
        if D == 1:
            c = J * np.sqrt(100.0 / rho0)
        else:
            mu = 100.0 / 2.6
            lam = 100.0 * 0.3 / (1.3 * 0.4)
            stretch = np.abs(now @ now.T)[:D, :D].sum(axis=1).max()
            c = np.sqrt((mu * stretch + max(mu + lam * (1 - np.log(J)), 0.0)) / rho0)
        if rate < 0:
            q[p] = rho0 / J * (c1 * c * L * -rate + c2 * (L * rate) ** 2)
    return q


@pytest.mark.parametrize("dimension", [1, 2])
def test_pressure_is_that_of_the_equation(dimension):
    sim = start(three(dimension))
    squeeze(sim)
    kinds = {name: 0 for name in KINDS}
    for _ in range(8):
        before = field(sim, "F")
        sim.advance()
        q = field(sim, "q")[:, 0]
        # The gradient comes from a difference of F over a step.
        np.testing.assert_allclose(q, expected(sim, field(sim, "F"), before), rtol=1e-9, atol=1e-11)
        for body, name in enumerate(KINDS):
            kinds[name] += (q[field(sim, "body") == body] > 0).sum()
    assert 8 < kinds["both"] and 8 < kinds["square"] and kinds["none"] == 0
    assert (q == 0.0).sum() > len(q) // 3, "some particles expand"


@pytest.mark.parametrize("dimension", [1, 2])
def test_it_enters_the_internal_force_of_the_next_step_only(dimension):
    sim, bare = start(three(dimension)), start(three(dimension, bare=True))
    assert bare.particles.q.shape[1] == 0
    for s in (sim, bare):
        squeeze(s)
        s.advance()
    for name in ("x", "v", "F", "sigma"):  # the first step knows no pressure yet
        np.testing.assert_array_equal(field(sim, name), field(bare, name))
    assert field(sim, "q").max() > 0.1
    reference = Reference("gimp", [2] * dimension, sim.scene.domain.frame)
    p, rows = sim.particles, sim.live()
    total = type(p)(*(array[rows] for array in p))
    total.sigma[:, :3] -= total.q
    reference.particles_to_grid(total)
    for s in (sim, bare):
        s.advance()
    # Vertices hold (m, v, -, a) after the step; the forces are m a.
    vertices, (low, extent) = reference.shape[0], sim.rank.grid.window[:2]
    assert low[0] == 0
    G = sim.rank.grid.G.reshape(sim.rank.grid.planes, -1, 8)[:vertices]
    m = reference.m.reshape(vertices, -1)
    f = reference.f.reshape(vertices, -1, dimension)
    columns = np.arange(low[1], low[1] + extent[1]) if dimension == 2 else np.arange(1)
    active = sim.rank.grid.active[:vertices].astype(bool)
    heavy = m[:, columns] > 1e-6
    a = np.where(heavy[..., None], f[:, columns], 0) / np.where(heavy, m[:, columns], 1)[..., None]
    found = np.where(active[:, None, None], G[..., 5 : 5 + dimension], 0) * heavy[..., None]
    np.testing.assert_allclose(found, a, rtol=1e-9, atol=1e-8 * np.abs(a).max())
    assert np.abs(field(sim, "v") - field(bare, "v")).max() > 1e-4
    # Stored is what the material says of F.
    if dimension == 1:
        F = field(sim, "F")[:, 0]
        sigma = field(sim, "sigma")[:, 0]
        np.testing.assert_allclose(sigma, 100.0 * (F - 1), rtol=1e-12, atol=1e-12)
    else:
        mu, lam = 100.0 / 2.6, 100.0 * 0.3 / (1.3 * 0.4)
        for F, s in zip(field(sim, "F"), field(sim, "sigma"), strict=True):
            F, J = matrix(F), np.linalg.det(matrix(F))
            law = (mu * (F @ F.T - np.eye(3)) + lam * np.log(J) * np.eye(3)) / J
            np.testing.assert_allclose(tensor(s), law, rtol=1e-9, atol=1e-9)


def compaction(viscosity, **parts):
    """Dynamic compaction (4.2) in 50 cells."""
    bar = {"model": "linear-1d", "young": 1e6, "density": 1.0}
    return scene(
        1, box([0.0], [50.0], [-20.0]), cells=[54],
        materials={"soft": bar | ({"viscosity": viscosity} if viscosity else {})},
        boundaries={"x-min": "fixed"}, **{"end": 0.0375, "step": 1e-4, **parts},
    )  # fmt: skip


def behind(sim):
    """Stress of the particles in half of the bar, at the wall; the front is at three quarters."""
    return field(sim, "sigma")[:50, 0]


def test_stress_behind_a_shock_is_flat_and_right():
    thick, plain = (behind(finish(start(compaction(v)))) for v in (VISCOSITY, None))
    # (46): F = 1 - |v0|/c.
    assert thick.mean() == pytest.approx(-2e4, rel=1e-2)  # measured -19991
    # A damping ratio of 0.2 leaves some ringing next to the front: measured 306 and 1104.
    assert thick.std() < 0.02 * 2e4 and thick.std() < plain.std() / 3.0


def test_a_shock_dissipates_and_never_gains():
    sim = start(compaction(VISCOSITY))
    lines = [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        lines.append(sim.diagnostics())
    lost, kinetic = (np.array([line[f"{kind}-energy"] for line in lines])
                     for kind in ("dissipated", "kinetic"))  # fmt: skip
    # The balance is off by parts of order dt: 2e-4 of it in the first step, at the wall.
    assert np.diff(lost).min() > -2.5e-4 * kinetic[0]
    assert 0.0 < lost[-1] < 0.1 * kinetic[0]
    assert np.diff(lost)[1:].min() > 0.0


def test_the_step_accounts_for_it():
    sim = start(compaction(VISCOSITY, step={"courant": 0.3}, end=0.004))
    while not sim.finished:
        before = field(sim, "F")[:, 0]
        sim.advance()
        F, v = field(sim, "F")[:, 0], field(sim, "v")[:, 0]
        c = 1e3 * F
        closing = np.maximum(-(F / before - 1.0) / sim.dt, 0.0)  # times L = 1
        z = np.where(closing > 0, 0.2 + 2.0 * closing / c, 0.0)
        rate = (c * np.sqrt(1 + z * z) + c * z + np.abs(v)).max()
        assert sim.rate == pytest.approx(rate, rel=1e-9)
    assert z.max() > 0.2


def test_coefficients_of_zero_change_no_bit():
    zero = {"linear": 0.0, "quadratic": 0.0}
    bare, none = start(compaction(None)), start(compaction(zero))
    assert bare.particles.q.shape[1] == 0 and none.particles.q.shape[1] == 1
    for sim in (bare, none):
        finish(sim)
    for name in ("x", "v", "F", "sigma"):
        np.testing.assert_array_equal(field(bare, name), field(none, name))
