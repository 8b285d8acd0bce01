"""Wave speeds that limit the step, against the acoustic tensor of the kernels' own stresses."""

import numpy as np
import pytest
from material_driver import (
    DENSITY,
    HOOKE,
    MU,
    NEO,
    SEED,
    deformations,
    material,
    response,
)


def acoustic(parameters, F, n):
    """Squares of the speeds of waves with normal n in the deformed body, from its stresses.

    rho0 c^2 a = (dP/dF : a (x) N) N with N = F^T n and P the first Piola-Kirchhoff stress.
    """
    D = len(F)
    N, h = F.T @ n, 1e-5

    def traction(F):
        P = np.linalg.det(F) * response(parameters, F)[0][:D, :D] @ np.linalg.inv(F).T
        return P @ N

    directions = [np.outer(np.eye(D)[k], N) for k in range(D)]
    A = [(traction(F + h * d) - traction(F - h * d)) / (2 * h) for d in directions]
    return np.linalg.eigvalsh(np.array(A)) / parameters[0].density


def normals(D):
    rng = np.random.default_rng(SEED)
    for n in [*np.eye(D), *rng.normal(size=(25 if D > 1 else 0, D))]:
        yield n / np.linalg.norm(n)


@pytest.mark.parametrize(
    ("model", "D"), [("neo-hookean", d) for d in (1, 2, 3)] + [("linear-1d", 1)]
)
def test_speed_bounds_all_waves(model, D):
    """No wave is faster, and along principal axes one is as fast."""
    parameters = (material(model),)
    for F in deformations(D, n=5):
        fastest = max(acoustic(parameters, F, n).max() for n in normals(D))
        assert response(parameters, F)[2] >= np.sqrt(fastest) * (1 - 1e-8)
    for stretches in ([1.4, 0.8, 1.1], [0.9, 0.5, 0.7], [1.0, 1.0, 1.0]):
        F = np.diag(stretches[:D])
        fastest = max(acoustic(parameters, F, n).max() for n in normals(D))
        assert response(parameters, F)[2] == pytest.approx(np.sqrt(fastest), rel=1e-7)


def test_speed_of_the_shear_wave_where_it_is_the_fastest():
    """Far expanded the longitudinal wave slows down, and does not even exist further on."""
    F = np.diag([2.5, 2.4, 2.3])
    fastest = max(acoustic(NEO, F, n).max() for n in normals(3))
    assert response(NEO, F)[2] == pytest.approx(np.sqrt(fastest), rel=1e-7)
    assert fastest == pytest.approx(MU * 2.5**2 / DENSITY, rel=1e-6)


@pytest.mark.parametrize("D", [1, 2, 3])
def test_hooke_speed(D):
    """The longitudinal wave of small strains, from the stress that a small step adds."""
    h, dt = 1e-6, 0.1
    for stretch in (1.0, 0.8):
        F = np.eye(D)
        F[0, 0] = stretch
        L = np.zeros((D, D))
        L[0, 0] = h / dt
        modulus = response(HOOKE, F, None, L, dt)[0][0, 0] / h
        density = DENSITY / stretch
        assert response(HOOKE, F)[2] == pytest.approx(np.sqrt(modulus / density), rel=1e-5)
