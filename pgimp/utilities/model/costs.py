"""Costs of a step's parts on this machine, in seconds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Costs(NamedTuple):
    """Costs of a rank's work."""

    fixed: float  #: Seconds of a step without particles: Python, and the calls of the kernels.
    #: tuple of (float, float): Numbers of particles of a rank, ascending, with seconds per
    #: particle-step. These include the kernels, changes of layer, and the step's share of the sort.
    #: For other numbers, see `particle`.
    particles: tuple[tuple[float, float], ...]
    vertex: float  #: Seconds per step and vertex of an active plane.

    def particle(self, count: ArrayLike) -> NDArray[np.float64]:
        """Seconds per particle-step on a rank with `count` particles, which may exceed caches."""
        numbers, seconds = zip(*self.particles, strict=True)
        return np.interp(np.log(np.maximum(count, 1.0)), np.log(numbers), seconds)

    def work(self, particles: float, vertices: float) -> float:
        """Seconds of a step that particles and vertices of active planes take."""
        return float(self.particle(particles)) * particles + self.vertex * vertices
