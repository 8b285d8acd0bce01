"""Amplitude spectra of curves over time, and their peaks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

Array = np.ndarray

#: Fewest lines of a spectrum.
MIN_LINES = 16
#: Points of the transform over lines; so a peak lies at most a 32nd of the resolution off a point.
_PADDED = 16
#: Relative spread of time steps that counts as none.
_EVEN = 1e-6
#: Lines of the even steps over those of the curve at most.
_DENSER = 4
#: Least amplitude of a peak over the greatest; side lobes of the window are 2.7 % of theirs.
_LEAST_PART = 0.05
#: Amplitude over the greatest value that is rounding.
_ROUNDING = 1e-13
#: Half of the main lobe of the window, and the lowest frequency of a peak, in resolutions.
_APART, _LOWEST = 2.0, 1.5


class Spectrum(NamedTuple):
    """The amplitude spectrum of a curve over time."""

    #: (n,) float64: Frequencies from 0 on, up to half of the mean number of lines per time.
    frequency: Array
    #: (n,) float64: Amplitudes: a sinusoid of amplitude A gives a peak of height A.
    amplitude: Array
    resolution: float  #: One over the curve's length in time.
    gaps: tuple[float, float]  #: Least and greatest time between lines.

    @property
    def even(self) -> bool:
        """Whether the curve has even time steps."""
        return self.gaps[1] - self.gaps[0] <= _EVEN * self.gaps[1]

    def peaks(self, most: int) -> list[tuple[float, float]]:
        """Return frequency and amplitude of the highest peaks, by frequency, at most `most`.

        Peaks are those above 5 % of the greatest. Lower frequencies than one and a half over the
        curve's length are not told from a drift. Between points a parabola is laid through the
        logarithms.
        """
        f, a = self.frequency, self.amplitude
        inner = np.arange(1, len(a) - 1)
        tops = inner[(a[inner] > a[inner - 1]) & (a[inner] >= a[inner + 1])]
        tops = tops[f[tops] >= _LOWEST * self.resolution]
        found: list[tuple[float, float]] = []
        for k in sorted(tops, key=lambda k: -a[k]):
            if a[k] < _LEAST_PART * (found[0][1] if found else 0.0) or len(found) == most:
                break
            low, top, high = np.log(np.maximum(a[k - 1 : k + 2], 1e-300))
            off = 0.5 * (low - high) / (low - 2.0 * top + high)
            at = float(f[k] + off * (f[1] - f[0]))
            if all(abs(at - other) >= _APART * self.resolution for other, _ in found):
                found.append((at, float(np.exp(top - 0.25 * (low - high) * off))))
        return sorted(found)


def spectrum(time: Array, values: Array) -> Spectrum:
    """Return the amplitude spectrum of a curve.

    A straight line is taken off, fitted with the weights of the window, which is that of Hann.
    Uneven time steps are resampled by cubics.

    Parameters
    ----------
    time : (n,) float64
        Times, which increase; at least `MIN_LINES`.
    values : (n,) float64
    """
    gaps, length = np.diff(time), float(time[-1] - time[0])
    step, found = length / len(gaps), np.asarray(values, float)
    limit = 0.5 / step
    if gaps.max() - gaps.min() > _EVEN * gaps.max():
        count = min(int(np.ceil(length / gaps.min())), _DENSER * len(gaps))
        step = length / count
        found = cubic(time, found, time[0] + step * np.arange(count + 1))
    n = len(found)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / (n - 1))
    place = np.linspace(-1.0, 1.0, n)  # the window is even about 0
    found = found - (window @ found) / window.sum()
    found -= place * ((window * place) @ found) / ((window * place) @ place)
    padded = 1 << int(np.ceil(np.log2(_PADDED * n)))
    amplitude = 2.0 * np.abs(np.fft.rfft(window * found, padded)) / window.sum()
    amplitude[amplitude < _ROUNDING * np.abs(values).max()] = 0.0
    frequency = np.arange(len(amplitude)) / (padded * step)
    shown = frequency <= limit
    least, most = float(gaps.min()), float(gaps.max())
    return Spectrum(frequency[shown], amplitude[shown], 1.0 / length, (least, most))


def cubic(x: Array, y: Array, at: Array) -> Array:
    """Interpolate by the cubics through four neighbouring points each.

    Parameters
    ----------
    x, y : (n,) float64
        The points, x increasing; at least four.
    at : (m,) float64
        Where; within the points.
    """
    first = np.clip(np.searchsorted(x, at) - 2, 0, len(x) - 4)
    nodes, found = [x[first + i] for i in range(4)], np.zeros(len(at))
    for i in range(4):
        weight = np.ones(len(at))
        for j in range(4):
            if j != i:
                weight *= (at - nodes[j]) / (nodes[i] - nodes[j])
        found += weight * y[first + i]
    return found
