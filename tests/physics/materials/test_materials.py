"""Strain paths through every material, as the kernels evaluate it, in each of its dimensions."""

import numpy as np
import pytest
from material_driver import (
    COMPONENTS,
    DENSITY,
    HOOKE,
    LAM,
    LINEAR,
    MU,
    NEO,
    SEED,
    YOUNG,
    deformations,
    material,
    response,
    row,
)
from reference_materials import matrix, tensor, voigt

from pgimp.jit import algebra
from pgimp.jit.kernel import kernel

dimensions = pytest.mark.parametrize("D", [1, 2, 3])


def turned(D, seed=0):
    """Random rotation (D, D)."""
    Q, R = np.linalg.qr(np.random.default_rng(SEED + seed).normal(size=(D, D)))
    Q = Q * np.sign(np.diag(R))
    return Q if np.linalg.det(Q) > 0 else Q[:, ::-1] if D % 2 == 0 else -Q


def turn(angle, D):
    """Rotation by an angle: in the plane, or about (1, 2, 3) by Rodrigues' formula."""
    if D == 2:
        return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    x, y, z = np.array([1, 2, 3]) / np.sqrt(14)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


@kernel
def operations(A, B, Q, S, T):
    return (
        algebra.multiply(A, B), algebra.inverse(A), algebra.one_plus(0.3, A), algebra.skew(A),
        algebra.add(A, B), algebra.symmetric(A), algebra.left_cauchy_green(A),
        algebra.isotropic(2.0, S, 3.0), algebra.add(S, T), algebra.rotate(Q, S),
        (algebra.determinant(A), algebra.contract(S, T)),
    )  # fmt: skip


@dimensions
def test_operations_on_tensors(D):
    """Each as NumPy has it, with symmetric tensors as (3, 3) matrices."""
    rng = np.random.default_rng(SEED + 40)
    A, B, Q = rng.normal(size=(D, D)), rng.normal(size=(D, D)), turned(D)
    n = COMPONENTS[D]
    s, t = rng.normal(size=n), rng.normal(size=n)
    S, T, one = tensor(s), tensor(t), np.eye(3)
    found = operations(row(A), row(B), row(Q), row(s), row(t))
    matrices = [A @ B, np.linalg.inv(A), np.eye(D) + 0.3 * A, (A - A.T) / 2, A + B]
    b, D3, Q3 = matrix(row(A)), np.zeros((3, 3)), matrix(row(Q))
    D3[:D, :D] = (A + A.T) / 2
    tensors = [D3, b @ b.T, 2.0 * S + 3.0 * one, S + T, Q3 @ S @ Q3.T]
    numbers = [np.linalg.det(A), np.sum(S * T)]
    expected = [*(row(M) for M in matrices), *(voigt(M, n) for M in tensors), numbers]
    for ours, right in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours, right, rtol=1e-12, atol=1e-14)


@dimensions
@pytest.mark.parametrize("s", [0.4, 0.95, 1.0, 1.7])
def test_neo_hookean_uniaxial_strain(D, s):
    F = np.diag([s, 1.0, 1.0][:D])
    sigma, energy, _ = response(NEO, F)
    along = MU * (s - 1 / s) + LAM * np.log(s) / s
    across = LAM * np.log(s) / s
    np.testing.assert_allclose(sigma, np.diag([along, across, across]), atol=1e-14 * YOUNG)
    expected = MU / 2 * (s**2 - 1) - MU * np.log(s) + LAM / 2 * np.log(s) ** 2
    assert energy == pytest.approx(expected, abs=1e-14 * YOUNG)


@pytest.mark.parametrize(
    ("D", "plane"), [(2, (0, 1)), (2, (1, 0)), (3, (0, 1)), (3, (1, 2)), (3, (2, 0)), (3, (0, 2))]
)
def test_neo_hookean_simple_shear(D, plane):
    """Shear stress mu g, normal stress mu g^2 along the motion: no volume changes."""
    i, j = plane
    g = 0.8
    F = np.eye(D)
    F[i, j] = g
    sigma, energy, _ = response(NEO, F)
    expected = np.zeros((3, 3))
    expected[i, i] = MU * g**2
    expected[i, j] = expected[j, i] = MU * g
    np.testing.assert_allclose(sigma, expected, atol=1e-14 * YOUNG)
    assert energy == pytest.approx(MU * g**2 / 2)


@dimensions
@pytest.mark.parametrize("s", [0.7, 1.2])
def test_neo_hookean_dilatation(D, s):
    """Equal stretches in the directions of the scene, none in the others."""
    sigma, _, _ = response(NEO, s * np.eye(D))
    volumetric = LAM * D * np.log(s) / s**D
    expected = volumetric + MU * (s**2 - 1) / s**D * (np.arange(3) < D)
    np.testing.assert_allclose(sigma, np.diag(expected), atol=1e-14 * YOUNG)


@dimensions
def test_plane_strain_is_the_cut_through_three_dimensions(D):
    """Stress, its zz too, and energy of a deformation in 1D or 2D are those of it in 3D."""
    for F in deformations(D):
        low, high = response(NEO, F), response(NEO, matrix(F.ravel()))
        n = COMPONENTS[D]
        np.testing.assert_allclose(voigt(low[0], n), voigt(high[0], n), atol=1e-14 * YOUNG)
        assert low[1] == pytest.approx(high[1], rel=1e-13)


@pytest.mark.parametrize(
    ("model", "D"), [("neo-hookean", d) for d in (1, 2, 3)] + [("linear-1d", 1)]
)
def test_stress_is_the_derivative_of_the_energy(model, D):
    """J sigma = dW/dF F^T, by central differences."""
    parameters = (material(model),)
    h = 1e-5
    for F in deformations(D):
        P = np.zeros((D, D))
        for i in range(D):
            for j in range(D):
                ends = []
                for sign in (1, -1):
                    changed = F.copy()
                    changed[i, j] += sign * h
                    ends.append(response(parameters, changed)[1])
                P[i, j] = (ends[0] - ends[1]) / (2 * h)
        kirchhoff = np.linalg.det(F) * response(parameters, F)[0][:D, :D]
        np.testing.assert_allclose(kirchhoff, P @ F.T, atol=1e-8 * YOUNG)


@dimensions
def test_neo_hookean_frame_indifference(D):
    """A rotation before changes nothing (isotropy), one after turns the stress."""
    for seed, F in enumerate(deformations(D)):
        Q = turned(D, seed)
        full = matrix(Q.ravel())
        sigma, energy, _ = response(NEO, F)
        after, before = response(NEO, Q @ F), response(NEO, F @ Q)
        np.testing.assert_allclose(after[0], full @ sigma @ full.T, atol=1e-13 * YOUNG)
        np.testing.assert_allclose(before[0], sigma, atol=1e-13 * YOUNG)
        assert after[1] == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("s", [0.5, 1.0, 1.3])
def test_linear_bar(s):
    """(41), uniaxial stress, energy and speed in closed form."""
    sigma, energy, speed = response(LINEAR, np.array([[s]]))
    np.testing.assert_allclose(sigma, np.diag([YOUNG * (s - 1), 0, 0]), atol=1e-15 * YOUNG)
    assert energy == pytest.approx(YOUNG * (s - 1) ** 2 / 2)
    assert speed == pytest.approx(s * np.sqrt(YOUNG / DENSITY))


@dimensions
@pytest.mark.parametrize("model", ["hooke", "neo-hookean"])
def test_small_strains_are_linearly_elastic(model, D):
    """One small step from rest: lambda tr(e) 1 + 2 mu e, and the energy e : C : e / 2."""
    for A in deformations(D):
        dt, L = 1e-3, 1e-4 * (A - np.eye(D))
        F = np.eye(D) + dt * L
        e = np.zeros((3, 3))
        e[:D, :D] = dt * (L + L.T) / 2
        expected = LAM * np.trace(e) * np.eye(3) + 2 * MU * e
        sigma, _, _ = response((material(model),), F, L=L, dt=dt)
        size = np.abs(expected).max()
        np.testing.assert_allclose(sigma, expected, atol=1e-6 * size + 1e-15 * YOUNG)
        sigma = voigt(expected, COMPONENTS[D])
        energy = response(HOOKE, F, sigma=sigma)[1]
        assert energy == pytest.approx((expected * e).sum() / 2, rel=1e-6, abs=0.0)


@dimensions
def test_hooke_follows_the_logarithmic_strain(D):
    """Stretching in 100 steps: the mid-point rule is second order and sums up ln s."""
    end, errors = 1.5, []
    for steps in (100, 200):
        sigma, F, dt = np.zeros(COMPONENTS[D]), np.eye(D), 0.25
        for n in range(steps):
            s = 1 + (end - 1) * (n + 1) / steps
            L = np.zeros((D, D))
            L[-1, -1] = (s / F[-1, -1] - 1) / dt
            F[-1, -1] = s
            sigma = voigt(response(HOOKE, F, sigma, L, dt)[0], COMPONENTS[D])
        expected = LAM * np.log(end) * np.eye(3)
        expected[D - 1, D - 1] += 2 * MU * np.log(end)
        errors.append(np.abs(tensor(sigma) - expected).max())
    assert errors[0] < 1e-5 * YOUNG
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.01)


@pytest.mark.parametrize("D", [2, 3])
@pytest.mark.parametrize("strained", [False, True], ids=["prestressed", "strained"])
def test_hooke_twenty_turns(D, strained):
    """A body that turns 20 times in 1000 steps: its stress turns with it, no more."""
    steps, dt = 1000, 0.01
    angle = 2 * np.pi * 20 / steps
    L = (turn(angle, D) - np.eye(D)) / dt
    if strained:
        G = 0.02 * np.random.default_rng(SEED).uniform(-1, 1, (D, D))
        sigma = voigt(response(HOOKE, np.eye(D) + G, None, G / dt, dt)[0], COMPONENTS[D])
    else:
        sigma = np.array([3.0, -2.0, 1.0, 0.7, 0.4, -0.6])[: COMPONENTS[D]]
    first, F = tensor(sigma), np.eye(D)
    size, worst = np.abs(first).max(), 0.0
    for n in range(1, steps + 1):
        F = F + dt * L @ F
        sigma = voigt(response(HOOKE, F, sigma, L, dt)[0], COMPONENTS[D])
        Q = matrix(turn(n * angle, D).ravel())
        worst = max(worst, np.abs(tensor(sigma) - Q @ first @ Q.T).max())
    assert worst < 1e-11 * size
    # The rotation must have been one that shows: halfway through a turn the stress is another.
    Q = matrix(turn(12 * angle, D).ravel())
    assert np.abs(Q @ first @ Q.T - first).max() > 0.1 * size


def test_hooke_stress_turns_with_a_straining_body():
    """Stretched by 1 % along an x that turns by 45 degrees, it is stressed along that x."""
    steps, dt, sigma, F = 400, 0.01, np.zeros(4), np.eye(2)
    for n in range(1, steps + 1):
        next_F = turn(2 * np.pi * 0.125 * n / steps, 2) @ np.diag([1 + 0.01 * n / steps, 1.0])
        L = (next_F @ np.linalg.inv(F) - np.eye(2)) / dt
        F = next_F
        sigma = voigt(response(HOOKE, F, sigma, L, dt)[0], 4)
    Q = matrix(turn(np.pi / 4, 2).ravel())
    e = np.log(1.01)
    expected = Q @ np.diag([(LAM + 2 * MU) * e, LAM * e, LAM * e]) @ Q.T
    # The last half step's rotation is still missing from each increment: first order.
    np.testing.assert_allclose(tensor(sigma), expected, atol=1e-3 * YOUNG * e)


SOFT = material("neo-hookean", 2.0, 0.1, 0.3)
STIFF = material("hooke", 90.0, 0.45, 8.0)


@pytest.mark.parametrize(
    ("materials", "D"),
    [((*NEO, SOFT), 2), ((*NEO, STIFF, SOFT), 1), ((SOFT, *NEO, STIFF, *HOOKE), 3)],
    ids=["one model", "three materials", "four materials"],
)
def test_the_right_material_of_several(materials, D):
    """Each material of a tuple answers as it does alone."""
    F = next(iter(deformations(D)))
    sigma = np.arange(1.0, 1 + COMPONENTS[D])
    L, dt = F - 2 * np.eye(D), 0.01
    answers = [response(materials, F, sigma, L, dt, k) for k in range(len(materials))]
    for k, alone in enumerate(materials):
        stress, energy, speed = response((alone,), F, sigma, L, dt)
        assert (answers[k][0] == stress).all()
        assert answers[k][1:] == (energy, speed)
    speeds = [speed for *_, speed in answers]
    assert len(set(speeds)) == len(materials)


def test_bar_beside_others():
    """The model that exists only in 1D, in one tuple with others."""
    materials = (*NEO, *LINEAR, *HOOKE)
    F = np.array([[1.25]])
    assert response(materials, F, k=1)[0][0, 0] == pytest.approx(YOUNG * 0.25)
    assert response(materials, F, k=0)[0][0, 0] == response(NEO, F)[0][0, 0]
    assert response(materials, F, k=2)[2] == response(HOOKE, F)[2]
