"""Functions of one's own for random scenes: one of each kind, of any dimension."""

from math import cos, sin

import pgimp
from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import plus_scaled, scaled


@pgimp.body_force
def swaying(X, x, v, t, strength, drag, wave, rate):
    """Force that sways with the initial place, and drags."""
    return plus_scaled(strength * sin(wave * X[0] + rate * t), scaled(0.3, X), scaled(-drag, v))


@pgimp.body_force
def pulling(x, t, strength, rate):
    """Force towards the origin, to and fro."""
    return scaled(-strength * cos(rate * t), x)


@pgimp.velocity
def rippling(x, size, wave):
    """Velocity that varies along x."""
    return scaled(size * sin(wave * x[0]), scaled(0.1, x))


@pgimp.velocity
def drifting(x, t, size, wave, rate):
    """Velocity that varies in space and time, of what is held."""
    return scaled(size * cos(rate * t) * sin(wave * x[0]), scaled(0.1, x))


@pgimp.coefficient
def breathing(t, mean, swing, rate):
    """Load that swings about a mean."""
    return mean + swing * sin(rate * t)


@pgimp.coefficient
def patchy(x, mean, part, wave):
    """Parameter that varies in space by a part of its mean."""
    return mean * (1.0 + part * sin(wave * x[0]))


@inlined
def stress_like(x, p, wave, mean):
    """Stress mean + p sin(wave x), all components in the dimension of `x`."""
    s = mean + p * sin(wave * x[0])
    return (s, s, s, 0.1 * s, 0.0, -0.1 * s)[: (3, 4, 6)[len(x) - 1]]


@pgimp.stress
def squeezing(x, p, wave, mean):
    """Stress that varies along x."""
    return stress_like(x, p, wave, mean)
