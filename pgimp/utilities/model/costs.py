"""Costs of the parts of a step, in seconds: on this machine, and between nodes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Network(NamedTuple):
    """The fabric between nodes, which cannot be measured on one.

    Attributes
    ----------
    latency : float
        Seconds of a short message.
    bandwidth : float
        Bytes per second in and, at once, out of a node.
    ranks_per_node : int
        Ranks on a node, neighbours together.
    """

    latency: float = 2e-6
    bandwidth: float = 10e9
    ranks_per_node: int = 64


class Messages(NamedTuple):
    """Costs of communication between ranks of a node.

    Attributes
    ----------
    neighbour : float
        Seconds of a step for each neighbour, for messages of any size: calls, latencies, and the
        search for particles that leave.
    bandwidth : float
        Bytes per second from one rank to another.
    reduction : float
        Seconds of a reduction of a few numbers on two ranks.
    migrant : float
        Seconds for each particle that goes to a neighbour.
    measured : bool
        Whether they were measured here.
    """

    neighbour: float = 30e-6
    bandwidth: float = 8e9
    reduction: float = 2e-6
    migrant: float = 0.3e-6
    measured: bool = False


class Costs(NamedTuple):
    """Costs of a rank's work, and of its neighbours.

    Attributes
    ----------
    fixed : float
        Seconds of a step without particles: Python, and the calls of the kernels.
    particles : tuple of (float, float)
        Numbers of particles of a rank, ascending, and seconds of a particle-step for each: the
        kernels, changes of layer, and the step's share of the sort. In between and beyond, see
        `particle`.
    vertex : float
        Seconds of a step for a vertex of a plane that takes part.
    interior : float
        Part of the cost of particles and their vertices that messages can hide behind.
    messages : Messages
        Between ranks of a node.
    busy : float
        Factor of all work where the other cores of a node work too: shared resources, and waiting
        for cores that are slower for a while. 1 if not measured.
    """

    fixed: float
    particles: tuple[tuple[float, float], ...]
    vertex: float
    interior: float = 0.0
    messages: Messages = Messages()
    busy: float = 1.0

    def particle(self, count: ArrayLike) -> NDArray[np.float64]:
        """Seconds of a particle-step on a rank with `count` particles: caches hold few or many."""
        numbers, seconds = zip(*self.particles, strict=True)
        return np.interp(np.log(np.maximum(count, 1.0)), np.log(numbers), seconds)
