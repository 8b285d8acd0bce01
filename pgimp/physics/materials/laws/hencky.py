"""Hencky's elasticity with plastic flow, stored in the stress: the common law of metals.

The deviator of the Kirchhoff stress is s = 2 G h, h the deviator of the elastic logarithmic strain
ln(b_e)/2. So the stress before a step gives b_e, and the step's deformation updates b_e. Its
logarithm gives the stress if the step is elastic. The law is exactly hyperelastic for any rotation
and any shear, without other state. Flow along s is then the radial return of small strains
(de Souza Neto, Peric, Owen, Computational Methods for Plasticity, 14.4). No eigenvectors are
needed, only series in the small tensors b_e - 1 and h (`pgimp.jit.series`). They are exact to
1e-15 for elastic strains up to 0.2, to 1e-9 at 0.4.
"""

from math import sqrt

from pgimp.jit.algebra import contract, determinant, isotropic, one_plus
from pgimp.jit.functions import log
from pgimp.jit.kernel import inlined
from pgimp.jit.series import carry, series_expm1, series_log1p
from pgimp.jit.tuples import scaled

#: Added to stresses in denominators, to keep quotients finite at zero stress.
TINY = 1e-300


@inlined
def elastic_trial(shear, J, sigma, L, dt):
    """Deviator of the Kirchhoff stress after a step, if it is elastic.

    Parameters
    ----------
    shear : float
        Shear modulus G.
    J, sigma, L, dt
        As in the materials' functions: J after the step, the Cauchy stress before it.
    """
    mean = (sigma[0] + sigma[1] + sigma[2]) * (1.0 / 3.0)
    r = J / determinant(one_plus(dt, L)) * (1.0 / shear)
    before = series_expm1(isotropic(r, sigma, -r * mean))  # b_e - 1 = exp(s/G) - 1
    twice = series_log1p(carry(scaled(dt, L), before))
    third = (twice[0] + twice[1] + twice[2]) * (1.0 / 3.0)
    return isotropic(shear, twice, -shear * third)


@inlined
def equivalent(s):
    """Equivalent stress sqrt(3/2 s : s) of a deviator."""
    return sqrt(1.5 * contract(s, s))


@inlined
def deviator(sigma):
    """Deviator of a stress."""
    return isotropic(1.0, sigma, (sigma[0] + sigma[1] + sigma[2]) * (-1.0 / 3.0))


@inlined
def elastic_energy(material, J, sigma):
    """Elastic energy K/2 (ln J)^2 + G h : h per initial volume."""
    ln = log(J)
    return 0.5 * material.bulk * ln * ln + distortion_energy(material.shear, J, sigma)


@inlined
def elastic_speed(material, J):
    """Speed of longitudinal elastic waves, rho0 c^2 = (K + 4/3 G)(1 - ln J) where compressed."""
    modulus = material.bulk + 4.0 / 3.0 * material.shear
    return sqrt(modulus * max(1.0 - log(J), 1.0) / material.density)


@inlined
def distortion_energy(shear, J, sigma):
    """Elastic energy G h : h of distortion, per initial volume."""
    s = deviator(sigma)
    return 0.25 * J * J / shear * contract(s, s)
