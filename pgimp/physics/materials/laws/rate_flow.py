"""Plastic flow dependent on rate and temperature, and failure (Johnson and Cook).

The formulas are in `pgimp.physics.materials.johnson_cook`.
"""

from typing import NamedTuple

from pgimp.jit.algebra import determinant, isotropic, one_plus
from pgimp.jit.choose import choose
from pgimp.jit.functions import exp, log, power
from pgimp.jit.kernel import inlined
from pgimp.physics.materials.laws.hencky import TINY, deviator, elastic_trial, equivalent


class Strength(NamedTuple):
    """Elastic and plastic constants; `heating` is 1/(rho0 c), `span` 1/(Tm - T0)."""

    bulk: float
    shear: float
    density: float
    a: float
    b: float
    n: float
    c: float
    m: float
    rate: float
    start: float
    span: float
    heating: float
    share: float


class Damage(NamedTuple):
    """Constants of the strain at failure."""

    d1: float
    d2: float
    d3: float
    d4: float
    d5: float


@inlined
def softening(k, T):
    """Homologous temperature T*, and 1 - T*^m."""
    hot = min(max((T - k.start) * k.span, 0.0), 1.0)
    return hot, 1.0 - power(hot, k.m)


@inlined
def rate_flow(k, q, alpha, soft, dt):
    """Plastic strain x of a step: q - 3 G x = sigma_y(alpha + x, x/dt), 0 if elastic.

    The left side minus the right decreases and is convex in x. Newton's method begins beyond the
    root, where 3 G x equals the excess over A. From its first step on it approaches from below,
    where a step to zero or less is replaced by a step to a tenth.
    """
    stiffness = 3.0 * k.shear
    per_rate = 1.0 / (dt * k.rate)
    beyond = q - (k.a + k.b * exp(k.n * log(max(alpha, TINY)))) * soft
    x = max((q - k.a * soft) * (1.0 / stiffness), 1e-30)
    for _ in range(5):
        total = alpha + x
        hard = k.b * exp(k.n * log(total))
        ratio = x * per_rate
        fast = 1.0 + k.c * log(max(ratio, 1.0))
        still = soft * (k.a + hard)
        slope = soft * k.n * hard / total * fast + choose(ratio > 1.0, still * k.c / x, 0.0)
        new = x + (q - still * fast - stiffness * x) / (stiffness + slope)
        x = max(new, 0.1 * x)
    return choose(beyond > 0.0, x, 0.0)


@inlined
def damaged(d, k, x, hot, mean, q, dt, before):
    """Damage after a step."""
    triaxiality = min(max(mean / (q + TINY), -10.0), 10.0)
    fast = log(max(x / (dt * k.rate), 1.0))
    shape = d.d1 + d.d2 * exp(d.d3 * triaxiality)
    strain = shape * (1.0 + d.d4 * fast) * (1.0 + d.d5 * hot)
    return min(before + x / max(strain, 1e-9), 1.0)


@inlined
def plastic_step(k, J, sigma, L, dt, state):
    """Deviator of the Kirchhoff stress, its q, plastic strain x, its work and T* in a step."""
    s = elastic_trial(k.shear, J, sigma, L, dt)
    trial = equivalent(s)
    hot, soft = softening(k, state[1])
    x = rate_flow(k, trial, state[0], soft, dt)
    q = trial - 3.0 * k.shear * x
    first = equivalent(deviator(sigma)) * J / determinant(one_plus(dt, L))
    kept = q / (trial + TINY)
    return isotropic(kept, s, 0.0), q, x, 0.5 * (first + q) * x, hot
