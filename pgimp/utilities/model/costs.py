"""Costs of a step's parts, in seconds: on this machine, and between nodes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Network(NamedTuple):
    """The network between nodes, which cannot be measured on a single node.

    Attributes
    ----------
    latency : float
        Seconds of a short message.
    bandwidth : float
        Bytes per second into and, simultaneously, out of a node.
    ranks_per_node : int
        Consecutive ranks on a node.
    """

    latency: float = 2e-6
    bandwidth: float = 10e9
    ranks_per_node: int = 64


class Messages(NamedTuple):
    """Costs of communication between ranks of a node.

    Attributes
    ----------
    neighbour : float
        Seconds per step and neighbour, for messages of any size: calls, latencies, and the search
        for leaving particles.
    bandwidth : float
        Bytes per second from one rank to another.
    reduction : float
        Seconds of a reduction of a few numbers on two ranks.
    migrant : float
        Seconds per particle that migrates to a neighbour.
    measured : bool
        Whether the costs were measured here.
    """

    neighbour: float = 30e-6
    bandwidth: float = 8e9
    reduction: float = 2e-6
    migrant: float = 0.3e-6
    measured: bool = False


class Costs(NamedTuple):
    """Costs of a rank's work, and of its messages.

    Attributes
    ----------
    fixed : float
        Seconds of a step without particles: Python, and the calls of the kernels.
    particles : tuple of (float, float)
        Numbers of particles of a rank, ascending, with seconds per particle-step. These include the
        kernels, changes of layer, and the step's share of the sort. For other numbers, see
        `particle`.
    vertex : float
        Seconds per step and vertex of an active plane.
    interior : float
        Fraction of the cost of particles and their vertices that can overlap with messages.
    messages : Messages
        Messages between ranks of a node.
    busy : float
        Factor of all work if the other cores of a node work too; 1 if not measured. It covers
        shared resources, and waiting for cores that are temporarily slower.
    """

    fixed: float
    particles: tuple[tuple[float, float], ...]
    vertex: float
    interior: float = 0.0
    messages: Messages = Messages()
    busy: float = 1.0

    def particle(self, count: ArrayLike) -> NDArray[np.float64]:
        """Seconds per particle-step on a rank with `count` particles, which may exceed caches."""
        numbers, seconds = zip(*self.particles, strict=True)
        return np.interp(np.log(np.maximum(count, 1.0)), np.log(numbers), seconds)
