"""Wave speeds that limit the step, against the acoustic tensor of the kernels' own stresses."""

import numpy as np
import pytest
from material_driver import DENSITY, HOOKE, MU, NEO, SEED, deformations, material, response

from pgimp.kernels.data.arguments import KernelScene
from pgimp.kernels.data.column import Carried
from pgimp.kernels.data.frame import InitialFrame
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.sums.sums import fastest_rate


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


def rate_on_initial_grid(parameters, F):
    """`fastest_rate` on a grid of the initial configuration with cells of 1, of a particle."""
    D = len(F)
    frame = InitialFrame((0.0,) * D, (1.0,) * D, (1.0,) * D, (4,) * D, 2)
    one = Particles.empty(1, Carried(D, origin=True))
    one.F[0], one.v[0] = np.ravel(F), 1e6  # which does not count
    of = np.zeros(1, np.int64)
    setting = KernelScene((), frame, tuple(np.eye(D).ravel().tolist()), parameters, of)
    return fastest_rate(setting, one, np.zeros(1, np.int32), True)


@pytest.mark.parametrize(("model", "D"), [("neo-hookean", 2), ("linear-1d", 1)])
def test_rate_on_a_grid_of_the_initial_configuration(model, D):
    """A wave along n goes c |F^-T N| of initial length, N the initial normal, and none is faster.

    As fast is one along principal stretches, however the body has turned.
    """
    parameters = (material(model),)

    def fastest(F):
        found = []
        for N in normals(D):
            m = np.linalg.inv(F).T @ N
            length = np.linalg.norm(m)
            found.append(length**2 * acoustic(parameters, F, m / length).max())
        return np.sqrt(max(found))

    for F in deformations(D, n=5):
        assert rate_on_initial_grid(parameters, F) >= fastest(F) * (1 - 1e-8)
    Q = np.array([[0.6, -0.8], [0.8, 0.6]]) if D == 2 else np.eye(1)
    for stretches in ([1.4, 0.8], [5.0, 0.6], [0.5, 0.7], [1.0, 1.0]):
        F = Q @ np.diag(stretches[:D])
        assert rate_on_initial_grid(parameters, F) == pytest.approx(fastest(F), rel=1e-7)


def test_rate_of_other_materials_is_bounded_by_the_least_stretch():
    F = np.array([[0.6, -0.8], [0.8, 0.6]]) @ np.diag([1.3, 0.5])
    c = response(HOOKE, F)[2]
    assert rate_on_initial_grid(HOOKE, F) == pytest.approx(c / 0.5, rel=1e-12)


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
