"""Gaussian random fields as functions of position: sums of waves, evaluated anywhere.

A homogeneous Gaussian field with mean 0, variance 1 and covariance rho(r) is the limit of

    g(x) = sqrt(2/M) sum_m cos(2 pi (k_m . x + f_m))

with wave vectors drawn from the spectrum of rho and phases f_m uniform in [0, 1) (Shinozuka and
Deodatis, Appl. Mech. Rev. 44, 1991). With r^2 = sum_d (x_d/l_d)^2, l the correlation lengths, the
spectrum of exp(-r) is Cauchy's multivariate distribution, the spectrum of exp(-r^2) a normal one.
Over all seeds mean, variance and covariance are exact with any number M of waves. In one field the
covariance is off by up to some 1/sqrt(2 M), and values are normal except for a kurtosis of
-3/(2 M).

Bits depend only on the position. So only sums, products, divisions, roots and pgimp's own logarithm
and exponential are used, without contraction, and only the raw numbers of NumPy's generators.
"""

from functools import lru_cache
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.functions import exp, log
from pgimp.jit.kernel import exact, kernel

Reals = NDArray[np.float64]


def _sine_series() -> tuple[float, ...]:
    """Coefficients of sin(pi/2 z)/z in z^2, ascending; the remainder is below 2e-18."""
    quarter = 1.5707963267948966
    term, found = quarter, [quarter]
    for k in range(1, 11):
        term *= -quarter * quarter / (2 * k * (2 * k + 1))
        found.append(term)
    return tuple(found)


_C0, _C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10 = _sine_series()
_TWO_PI = 6.283185307179586


@exact
def cosine_of_turns(t):
    """cos(2 pi t), to 1e-15 of its largest value; for |t| up to 1e9 within the rounding of t."""
    z = 1.0 - 4.0 * abs(t - np.floor(t + 0.5))
    s = z * z
    high = ((_C10 * s + _C9) * s + _C8) * s + _C7
    middle = (((high * s + _C6) * s + _C5) * s + _C4) * s + _C3
    return z * (((middle * s + _C2) * s + _C1) * s + _C0)


@exact
def sum_of_waves(x, i, waves, phases):
    """Sum of all waves at the position ``x[i]``, in order."""
    total = 0.0
    for m in range(len(phases)):
        t = phases[m]
        for d in range(x.shape[1]):
            t = t + waves[m, d] * x[i, d]
        total = total + cosine_of_turns(t)
    return total


@exact
def _normal_pair(u, v):
    """Two independent normal numbers from two uniform numbers in [0, 1) (Box and Muller)."""
    r = sqrt(-2.0 * log(1.0 - u))
    return r * cosine_of_turns(v), r * cosine_of_turns(v - 0.25)


@kernel
def _normals(uniform, out):
    for m in range(len(out)):
        for j in range(out.shape[1] // 2):
            a, b = _normal_pair(uniform[m, 2 * j], uniform[m, 2 * j + 1])
            out[m, 2 * j] = a
            out[m, 2 * j + 1] = b


@kernel
def _add_waves(x, waves, phases, out):
    for i in range(len(x)):
        out[i] = sum_of_waves(x, i, waves, phases)


@kernel
def _exponentials(values, out):
    for i in range(len(values)):
        out[i] = exp(values[i])


@kernel
def _logarithms(values, out):
    for i in range(len(values)):
        out[i] = log(values[i])


class Waves(NamedTuple):
    """A field: wave vectors, in turns per length, and phases, in turns."""

    vectors: Reals
    phases: Reals

    def at(self, x: Reals) -> Reals:
        """Values of the field at positions, (n, D), normal with mean 0 and variance 1."""
        out = np.empty(len(x))
        _add_waves(np.ascontiguousarray(x, dtype=float), self.vectors, self.phases, out)
        return sqrt(2.0 / len(self.phases)) * out


@lru_cache(maxsize=16)
def waves(kind: str, lengths: tuple[float, ...], seed: int, number: int) -> Waves:
    """Draw the waves of a field.

    Parameters
    ----------
    kind : str
        "exponential" or "gaussian".
    lengths : tuple of D float
        Correlation lengths.
    seed, number : int
        Seed of the field, and number of its waves.
    """
    columns = 4  # normal numbers per wave, an even number
    source: Any = np.random.Generator(np.random.PCG64(seed))
    uniform = source.random((number, columns + 1))
    normal = np.empty((number, columns))
    _normals(np.ascontiguousarray(uniform[:, :columns]), normal)
    vectors = normal[:, : len(lengths)].copy()
    if kind == "exponential":  # Student's distribution of one degree of freedom
        vectors /= np.maximum(np.abs(normal[:, 3]), 1e-12)[:, None]
    else:
        vectors *= sqrt(2.0)
    vectors /= _TWO_PI * np.array(lengths)
    return Waves(vectors, np.ascontiguousarray(uniform[:, columns]))


def lognormal(g: Reals, mean: float, cov: float) -> Reals:
    """Lognormal values with a mean and a coefficient of variation, from normal values."""
    variance, out = np.empty(1), np.empty(len(g))
    _logarithms(np.array([1.0 + cov * cov]), variance)
    _exponentials(sqrt(variance[0]) * g, out)
    return mean / sqrt(1.0 + cov * cov) * out
