"""Soils along paths against formulas, and against the conditions that define their return."""

from itertools import combinations, permutations
from math import cos, exp, log, radians, sin, sqrt, tan

import numpy as np
import pytest
from one_material import case_of
from reference_materials import tensor
from strain_paths import along, entry_of, invariants, random_walk, shears, stretches

import pgimp
from pgimp.errors import CaseError
from pgimp.physics.materials.parameters.outside import takes_vectors

YOUNG, POISSON = 1.0e3, 0.3
LAM = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
G = YOUNG / (2 * (1 + POISSON))
K = LAM + 2 * G / 3


def soil(model, friction=30.0, dilation=0.0, cohesion=0.0, **more):
    entry = {"model": model, "young": YOUNG, "poisson": POISSON, "cohesion": cohesion}
    return entry | {"friction-angle": friction, "dilation-angle": dilation} | more


CLAY = {
    "model": "cam-clay", "m": 1.2, "lambda": 0.2, "kappa": 0.04, "void-ratio": 1.0, "shear": 2.0e3,
    "preconsolidation": 100.0,
}  # fmt: skip
GRAINS = {
    "model": "mu-i", "young": 1.0e6, "poisson": 0.3, "mu-s": 0.38, "mu-2": 0.64, "i0": 0.279,
    "grain": 1.0e-3, "grain-density": 2500.0, "density": 1500.0,
}  # fmt: skip
EVERY = (soil("drucker-prager"), soil("mohr-coulomb"), CLAY, GRAINS)


def cone(friction, dilation, cohesion):
    """Slopes of strength and flow, and strength, of the cone for plane strain."""
    t, d = tan(radians(friction)), tan(radians(dilation))
    return 3 * t / sqrt(9 + 12 * t * t), 3 * d / sqrt(9 + 12 * d * d), (
        3 * cohesion / sqrt(9 + 12 * t * t)
    )  # fmt: skip


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("steps", [1, 30])
@pytest.mark.parametrize("angles", [(30.0, 10.0, 1.0), (25.0, 0.0, 0.0), (20.0, 20.0, 3.0)])
def test_drucker_prager_in_uniaxial_strain(angles, steps, D):
    """In closed form, in any number of steps."""
    alpha, flow, k = cone(*angles)
    e = log(0.9)
    found = along(soil("drucker-prager", *angles), stretches([e, 0.0, 0.0][:D], steps=steps))
    tau, p, J = 2 * G * abs(e) / sqrt(3), -K * e, 0.9
    slip = max(tau - alpha * p - k * J, 0.0) / (G + K * alpha * flow)
    tau, p = tau - G * slip, p + K * flow * slip
    expected = np.array([-p - 2 / sqrt(3) * tau, *[-p + tau / sqrt(3)] * 2]) / J
    np.testing.assert_allclose(found["stress"][-1, :3], expected, 1e-11)
    assert found["plastic-shear"][-1] == pytest.approx(slip, rel=1e-10, abs=1e-15)
    assert slip > 0.0 or angles[0] == 25.0


def test_the_cone_has_the_strength_of_mohr_and_coulomb_where_it_is_matched():
    """In triaxial compression and extension, and for c alone in plane strain."""
    for match, sign in (("compression", -1.0), ("extension", 1.0)):
        entry = soil("drucker-prager", 30.0, 0.0, 2.0, match=match)
        F = stretches([-0.02] * 3, [-0.02 + 0.1 * sign, *[-0.02 - 0.05 * sign] * 2], steps=10)
        J, s = np.linalg.det(F[-1]), along(entry, F)["stress"][-1]
        high, low = max(s[:3]), min(s[:3])
        f = high - low + (high + low) * 0.5 - 2 * 2.0 * cos(radians(30.0))
        assert f == pytest.approx(0.0, abs=1e-10) and J != 1.0
    F = stretches([0.1, -0.1, 0.0], steps=40)
    s = along(soil("drucker-prager", 0.0, 0.0, 2.0), F)["stress"][-1]
    assert s[0] - s[1] == pytest.approx(4.0, rel=1e-10)


@pytest.mark.parametrize("model", ["drucker-prager", "mohr-coulomb"])
def test_loose_soil_that_is_pulled_apart_comes_back_to_where_it_was(model):
    """Opened by a fifth, twice, and compressed: the stress of the compression alone."""
    path = stretches([0.2] * 3, [-0.02] * 3, [0.3] * 3, [-0.03] * 3, steps=25)
    found = along(soil(model), path)
    for step, e in ((49, -0.02), (99, -0.03)):
        np.testing.assert_allclose(found["stress"][step, :3], 3 * K * e / exp(3 * e), 1e-9)
        assert found["gap"][step] == 0.0
    assert found["gap"][24] == pytest.approx(0.6, rel=1e-9)
    assert np.abs(found["stress"][24]).max() < 1e-20


@pytest.mark.parametrize("model", ["drucker-prager", "mohr-coulomb"])
def test_tension_is_cut_off(model):
    """Pulled in all directions it bears the greatest tension, or that of the apex."""
    path = stretches([0.1] * 3)
    for given, expected in ((None, 2.0 / tan(radians(30.0))), (0.7, 0.7), (0.0, 0.0)):
        entry = soil(model, 30.0, 0.0, 2.0) | ({} if given is None else {"tension": given})
        stress = along(entry, path)["stress"]
        np.testing.assert_allclose(stress[-1, :3], expected, 1e-9, 1e-9)
        assert np.abs(stress[:, 3:]).max() < 1e-12
    pulled = along(soil(model, 30.0, 0.0, 2.0, tension=0.5), stretches([0.1, 0.0, 0.0]))["stress"]
    greatest = pulled[:, :3].mean(axis=1) if model == "drucker-prager" else pulled[:, 0]
    assert greatest.max() < 0.5 * (1 + 1e-9)


def closest(trial, angles, J):
    """Principal stresses that return from a trial: of the sets of planes the one that works."""
    friction, dilation, c = angles
    S, s, limit = sin(radians(friction)), sin(radians(dilation)), 2 * c * cos(radians(friction)) * J
    C = LAM * np.ones((3, 3)) + 2 * G * np.eye(3)
    normals, flows = [], []
    for i, j in permutations(range(3), 2):
        for sine, rows in ((S, normals), (s, flows)):
            rows.append(np.zeros(3))
            rows[-1][[i, j]] = 1 + sine, -(1 - sine)
    normals, flows = np.array(normals), np.array(flows)
    size = np.abs(trial).max()
    for count in range(4):
        for some in combinations(range(6), count):
            A, B = normals[list(some)], flows[list(some)]
            M = A @ C @ B.T
            if count and abs(np.linalg.det(M)) < 1e-9 * np.abs(M).max() ** count:
                continue
            g = np.linalg.solve(M, A @ trial - limit) if count else np.zeros(0)
            stress = trial - C @ B.T @ g
            if (g > -1e-12).all() and (normals @ stress < limit + 1e-10 * size).all():
                return stress
    return np.full(3, c / tan(radians(friction)) * J)


@pytest.mark.parametrize(
    "angles", [(30.0, 30.0, 1.0), (30.0, 0.0, 1.0), (25.0, 10.0, 0.0), (0.0, 0.0, 1.0)]
)
def test_mohr_coulomb_returns_to_planes_edges_and_apex(angles):
    """One step of random stretches, nearly equal ones among them, in random directions."""
    rng, places = np.random.default_rng(4), set()
    for k in range(120):
        e = 10 ** rng.uniform(-4.0, -1.3) * rng.normal(size=3)
        if k % 4 == 0:
            e[1] = e[0] * (1 + 1e-9 * rng.normal())
        Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        found = along(soil("mohr-coulomb", *angles), (Q @ np.diag(np.exp(e)) @ Q.T)[None])
        J, trial = exp(e.sum()), LAM * e.sum() + 2 * G * e
        expected = closest(trial, angles, J)
        size = np.abs(trial).max()
        stress = J * tensor(found["stress"][0])
        np.testing.assert_allclose(stress, Q @ np.diag(expected) @ Q.T, 0, 1e-9 * size)
        changed = np.abs(np.sort(expected) - np.sort(trial)) > 1e-9 * size
        equal = np.abs(np.diff(np.sort(expected))) < 1e-9 * size
        places.add((bool(changed.any()), *map(bool, equal)))
    assert (True, False, False) in places and (True, True, False) in places
    assert (True, False, True) in places
    assert angles[0] == 0.0 or (True, True, True) in places


@pytest.mark.parametrize("D", [1, 2, 3])
def test_mohr_coulomb_in_plane_strain_is_the_cut_through_three_dimensions(D):
    rng = np.random.default_rng(3)
    path = random_walk(rng, 30, 0.01, D)
    whole = np.tile(np.eye(3), (30, 1, 1))
    whole[:, :D, :D] = path
    low, high = (along(soil("mohr-coulomb", 30.0, 5.0, 1.0), F) for F in (path, whole))
    np.testing.assert_allclose(low["stress"], high["stress"], 1e-8, 1e-9)
    np.testing.assert_allclose(low["lost"], high["lost"], 1e-8, 1e-12)


def test_rankine():
    """Loose soil under pressure, sheared to failure: K_p = 3 and K_a = 1/3, to rounding."""
    found = along(soil("mohr-coulomb"), stretches([-0.01] * 3, [-0.05, -0.01, 0.03]))
    high, _, low = found["stress"][-1, :3]
    assert high / low == pytest.approx(3.0, rel=1e-12)
    assert low / high == pytest.approx(1 / 3, rel=1e-12)


def test_cam_clay_compressed_from_all_sides():
    """First compression follows lambda, swelling kappa; both in any number of steps."""
    found = along(CLAY, stretches([-0.1] * 3, [-0.08] * 3, steps=7))
    p, _ = invariants(found["stress"])
    first = 100.0 * exp(2.0 / 0.2 * 0.3)
    assert p[6] * exp(-0.3) == pytest.approx(first, rel=1e-12)
    assert p[13] * exp(-0.24) == pytest.approx(first * exp(-2.0 / 0.04 * 0.06), rel=1e-12)
    np.testing.assert_allclose(found["preconsolidation"][6:], first, 1e-12)


@pytest.mark.parametrize("D", [2, 3])
def test_cam_clay_undrained(D):
    """At constant volume q ends at p M 2^-(1 - kappa/lambda), .689219 of the initial pressure."""
    end = [-2.0, 1.0, 1.0] if D == 3 else [-2.0, 2.0]
    found = along(CLAY, stretches(end, steps=100))
    p, tau = invariants(found["stress"])
    assert sqrt(3) * tau[-1] / 100.0 == pytest.approx(0.689219, abs=1e-6)
    assert sqrt(3) * tau[-1] / 100.0 == pytest.approx(1.2 * 2 ** -(1 - 0.04 / 0.2), rel=1e-11)
    assert p[-1] == pytest.approx(100.0 * 2 ** -(1 - 0.04 / 0.2), rel=1e-11)
    swelling = along(CLAY | {"pressure": 15.0}, stretches(end, steps=100))
    p, tau = invariants(swelling["stress"])
    assert (swelling["preconsolidation"][-1]) == pytest.approx(2 * p[-1], rel=1e-9)
    assert sqrt(3) * tau[-1] == pytest.approx(1.2 * p[-1], rel=1e-9) and p[-1] > 15.0


@pytest.mark.parametrize("pressure", [100.0, 20.0, 1.0])
def test_cam_clay_stays_within_its_ellipse(pressure):
    """On a random walk, on which it yields on both sides of the critical state."""
    F = random_walk(np.random.default_rng(0), 200, 3e-3)
    found = along(CLAY | {"pressure": pressure}, F)
    J, (p, tau) = np.linalg.det(F), invariants(found["stress"])
    p, q, pc = J * p, J * sqrt(3) * tau, found["preconsolidation"]
    f = ((q / 1.2) ** 2 + p * (p - pc)) / pc**2
    assert f.max() < 1e-12 and (f > -1e-12).sum() > 50
    # Normal flow: p_c grows below the critical state's slope, and falls above it.
    grows = np.diff(pc)
    assert ((grows <= 1e-12 * pc[1:]) | (q < 1.2 * p)[1:]).all()
    assert ((grows >= -1e-12 * pc[1:]) | (q > 1.2 * p)[1:]).all()


def test_mu_of_I_in_steady_shear():
    """tau = mu(I) p, at rates that cover both ends of mu."""
    J = 0.999
    for rate in (0.2, 20.0, 2000.0):
        steps = 400
        dt = 0.05 / rate / steps
        start = J**0.5 * np.eye(2)[None]
        found = along(GRAINS, np.concatenate([start, shears(rate, dt, steps, 2, J)]), dt)
        p, tau = (each[-1] for each in invariants(found["stress"]))
        inertia = rate * 1e-3 * sqrt(2500.0 / p)
        mu = 0.38 + 0.26 / (0.279 / inertia + 1.0)
        # Hencky's stress turns with the body; its normal stresses are of the size of the strain.
        assert tau / p == pytest.approx(mu, rel=1e-6)


def test_grains_apart_have_no_stress_and_come_back():
    found = along(GRAINS, stretches([0.1, 0.0], [-0.001, 0.0], [0.2, 0.1], [-0.001, 0.0]))
    assert not found["stress"][19].any() and not found["stress"][59].any()
    p, _ = invariants(found["stress"])
    assert p[79] == pytest.approx(p[39], rel=1e-9)


@pytest.mark.parametrize("entry", EVERY, ids=lambda entry: entry["model"])
def test_objectivity(entry):
    """Turned all the way, the stress turns, and nothing else changes."""
    path = random_walk(np.random.default_rng(11), 12, 4e-3)
    angles = np.linspace(0.0, 2.0, 12)
    turns = np.array([[[cos(a), -sin(a), 0], [sin(a), cos(a), 0], [0, 0, 1.0]] for a in angles])
    still, turned = along(entry, path), along(entry, turns @ path)
    size = np.abs(still["stress"]).max()
    for k, Q in enumerate(turns):
        expected = Q @ tensor(still["stress"][k]) @ Q.T
        np.testing.assert_allclose(tensor(turned["stress"][k]), expected, 0, 1e-9 * size)
    np.testing.assert_allclose(turned["lost"], still["lost"], 1e-6, 1e-12 * size)


@pytest.mark.parametrize("entry", EVERY, ids=lambda entry: entry["model"])
def test_work_is_stored_or_lost(entry):
    """Along a smooth path the energy and what flow takes are the work, to first order at least."""
    start, count = [-0.01] * 3, 200
    if entry["model"] == "mu-i":  # stiff: a step of 1e-4 strains it to yield
        start, count = [-0.0001] * 3, 4000
    end = [start[0] - 0.06, start[1] + 0.06, start[2] + 0.01]
    errors = []
    for steps in (count, 2 * count):
        found = along(entry, stretches(start, end, steps=steps), 0.2 / steps)
        gained = found["energy"] + found["lost"]
        errors.append(abs(gained[-1] - gained[0] - (found["work"][-1] - found["work"][0])))
    assert found["lost"][-1] > 0.0 and (np.diff(found["lost"]) > -1e-12).all()
    assert errors[1] < 0.02 * found["work"][-1]
    assert errors[1] < 0.6 * errors[0] or errors[1] < 1e-9 * found["work"][-1]


@pytest.mark.parametrize("entry", EVERY, ids=lambda entry: entry["model"])
def test_four_at_once(entry):
    assert takes_vectors(entry_of(entry), 2)


WRONG = {
    "friction": (soil("drucker-prager", 90.0), "friction-angle", "must be below 90"),
    "dilation": (soil("mohr-coulomb", 20.0, 25.0), "dilation-angle", "above the friction-angle"),
    "no strength": (soil("drucker-prager", 0.0), "cohesion", "no other strength"),
    "loose": (soil("mohr-coulomb", tension=5.0), "tension", "without cohesion bears none"),
    "tension": (
        soil("drucker-prager", 45.0, cohesion=2.0, tension=2.5), "tension", "above cohesion/tan",
    ),
    "poisson": (soil("mohr-coulomb", poisson=0.5), "poisson", "must be below 0.5"),
    "kappa": (CLAY | {"kappa": 0.2}, "kappa", "must be below lambda"),
    "pressure": (CLAY | {"pressure": 200.0}, "pressure", "above preconsolidation"),
    "mu": (GRAINS | {"mu-2": 0.2}, "mu-2", "below the coefficient at rest"),
    "grains": (GRAINS | {"grain-density": 1000.0}, "grain-density", "below the density of the"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_refused(name):
    entry, key, words = WRONG[name]
    with pytest.raises(CaseError, match=rf"materials\.law\.{key}.*{words}"):
        pgimp.load(case_of(entry))
