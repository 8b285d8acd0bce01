"""Materials as the kernels evaluate them, asked from Python."""

import numpy as np
from reference_materials import tensor

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import kernel
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.parameters.evaluate import evaluate

SEED = 20040

YOUNG, POISSON, DENSITY = 7.0, 0.3, 2.5
LAM = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = YOUNG / (2 * (1 + POISSON))

COMPONENTS = {1: 3, 2: 4, 3: 6}


def material(model, young=YOUNG, poisson=POISSON, density=DENSITY):
    """Parameters from an entry of a case."""
    entry = {"model": model, "young": young, "density": density}
    if model != "linear-1d":
        entry["poisson"] = poisson
    return MATERIALS[model].model_validate(entry).parameters()


@kernel
def respond(materials, k, F, sigma, L, dt):
    """Stress, energy and speed of material `k`, through `evaluate` as in a step."""
    J = determinant(F)
    return (
        evaluate("stress", materials, k, (F, J, sigma, L, dt), ()),
        evaluate("energy", materials, k, (F, J, sigma), ()),
        evaluate("speed", materials, k, (F, J), ()),
    )


def row(A):
    return tuple(float(a) for a in np.ravel(A))


def response(materials, F, sigma=None, L=None, dt=0.0, k=0):
    """(3, 3) stress, energy, speed for F (D, D)."""
    D = len(F)
    sigma = np.zeros(COMPONENTS[D]) if sigma is None else sigma
    L = np.zeros((D, D)) if L is None else L
    stress, energy, speed = respond(materials, k, row(F), row(sigma), row(L), dt)
    assert len(stress) == COMPONENTS[D]
    return tensor(stress), energy, speed


NEO = (material("neo-hookean"),)
LINEAR = (material("linear-1d"),)
HOOKE = (material("hooke"),)


def deformations(D, n=12, size=0.3):
    """Random deformation gradients (D, D), none of them inverted."""
    rng = np.random.default_rng(SEED + D)
    for _ in range(n):
        yield np.eye(D) + size * rng.uniform(-1, 1, (D, D))
