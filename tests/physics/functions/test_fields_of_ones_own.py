"""Fields and loads by functions of one's own: against what they say, by NumPy."""

from math import cos, exp, sin

import numpy as np
import pytest
from scenes import box, scene, start
from tiers import wide

import pgimp
from pgimp.errors import CaseError
from pgimp.physics.functions.registry import FUNCTIONS

pytestmark = pytest.mark.slow(40)


@pytest.fixture(scope="module", autouse=True)
def registered():
    """The functions here are registered as long as its tests run."""
    before = dict(FUNCTIONS)
    for kind, *functions in (
        (pgimp.body_force, wind),
        (pgimp.velocity, shear),
        (pgimp.coefficient, push, denser),
        (pgimp.stress, ground, twisted),
    ):
        for function in functions:
            kind(function)
    yield
    FUNCTIONS.clear()
    FUNCTIONS.update(before)


def wind(X, x, v, t, strength, drag=0.0):
    f = strength * exp(-t)
    return f * X[1] - drag * v[0], f * cos(x[0]) - drag * v[1]


def shear(x, rate):
    return rate * x[1], 0.1 * x[0] * x[1]


def push(t, height):
    return height * (1.0 + sin(9.0 * t))


def denser(x, top):
    return 1.0 + 0.1 * (top - x[1])


def ground(x, top, k0=0.6):
    s = x[1] - top
    return k0 * s, s, k0 * s, 0.0


def twisted(x, size):
    return 0.2 * size, -size * x[0], 0.1 * size, 0.3 * size * x[1]


def named(function, **parameters):
    return {"function": function, "parameters": parameters}


def block(**parts):
    body = box([2.0, 1.0], [6.0, 5.0]) | {"velocity": named("shear", rate=0.3)}
    case = scene(2, body, **({"body-force": named("wind", strength=2.0, drag=0.5)} | parts))
    case["materials"]["soft"] = case["materials"]["soft"] | {"density": named("denser", top=5.0)}
    return case


def test_momentum_and_work_are_those_of_the_force():
    sim = start(block(gravity=[named("push", height=0.4), 0.0]))
    p, rows = sim.particles, sim.live()
    x = p.x[rows]
    np.testing.assert_allclose(p.v[rows], np.stack([0.3 * x[:, 1], 0.1 * x[:, 0] * x[:, 1]], 1))
    np.testing.assert_allclose(p.m[rows] / p.V0[rows], 1.0 + 0.1 * (5.0 - x[:, 1]))
    for _ in range(12):
        p, rows, t = sim.particles, sim.live(), sim.time
        x, v, X, m = (np.copy(each[rows]) for each in (p.x, p.v, p.origin, p.m))
        b = 2.0 * np.exp(-t) * np.stack([X[:, 1], np.cos(x[:, 0])], 1) - 0.5 * v
        b[:, 0] += 0.4 * (1.0 + np.sin(9.0 * t))
        before = sim.diagnostics()
        sim.advance()
        line = sim.diagnostics()
        moved = sim.particles.x[sim.live()] - x
        for d, axis in enumerate("xy"):
            gained = line[f"momentum-{axis}"] - before[f"momentum-{axis}"]
            assert gained == pytest.approx(sim.dt * (m * b[:, d]).sum(), rel=1e-11)
        work = line["external-work"] - before["external-work"]
        assert work == pytest.approx((m[:, None] * b * moved).sum(), rel=1e-11)


@pytest.mark.parametrize("law", ["hooke", wide("neo-hookean")])
def test_ground_begins_at_rest_with_its_own_stress(law):
    """Gravity is in balance with it, as with that of the weight above."""
    walls = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}
    case = scene(2, box([0.0, 0.0], [3.0, 5.0]), cells=[3, 7], gravity=[0.0, -1.0],
                 boundaries=walls, start={"stress": named("ground", top=5.0)})  # fmt: skip
    case["materials"]["soft"] = case["materials"]["soft"] | {"model": law, "young": 1000.0}
    sim = start(case)
    y = 5.0 - sim.particles.x[sim.live(), 1]
    np.testing.assert_allclose(sim.particles.sigma[sim.live()][:, :2].T, [-0.6 * y, -y])
    for _ in range(100):
        sim.advance()
    assert np.abs(sim.particles.v[sim.live()]).max() < 1e-12 * 35.0


def test_a_stress_with_shear_has_its_deformation():
    """Of the neo-Hookean solid, whose law is written once more."""
    case = scene(2, box([2.0, 1.0], [6.0, 5.0]), start={"stress": named("twisted", size=1.5)})
    sim = start(case)
    p, rows = sim.particles, sim.live()
    F = p.F[rows].reshape(-1, 2, 2)
    mu, lam, J = 100.0 / 2.6, 30.0 / (1.3 * 0.4), np.linalg.det(F)
    b = F @ F.transpose(0, 2, 1)
    pressure = lam * np.log(J) / J
    x = p.x[rows]
    wanted = [np.full(len(x), 0.3), -1.5 * x[:, 0], 0.45 * x[:, 1]]
    found = [mu / J * (b[:, 0, 0] - 1.0) + pressure, mu / J * (b[:, 1, 1] - 1.0) + pressure,
             mu / J * b[:, 0, 1]]  # fmt: skip
    np.testing.assert_allclose(found, wanted, rtol=1e-8)
    np.testing.assert_allclose(p.sigma[rows][:, [0, 1, 3]].T, wanted, rtol=1e-8)
    np.testing.assert_allclose(p.sigma[rows][:, 2], pressure, rtol=1e-8)
    np.testing.assert_allclose(p.V0[rows] * J, p.V[rows])
    np.testing.assert_allclose(F[:, 0, 1], F[:, 1, 0])


def test_clay_begins_under_no_tension():
    """Its energy of tension is negative: the step that cuts it makes as much of nothing."""
    clay = {
        "model": "cam-clay", "density": 1.0, "m": 1.0, "lambda": 0.2, "kappa": 0.05,
        "void-ratio": 1.0, "shear": 90.0, "preconsolidation": 6.0,
    }  # fmt: skip
    case = scene(2, box([2.0, 1.0], [6.0, 5.0]), start={"stress": named("ground", top=4.0)})
    case["materials"]["soft"] = clay
    text = r"start.stress: 'body' .* 0.55 at \(2.25, 4.75\), tension, of which 'cam-clay' bears"
    with pytest.raises(CaseError, match=text):
        start(case)
