"""Time of a step on any number of ranks, from the costs of its parts."""

from __future__ import annotations

from math import ceil, log2
from typing import NamedTuple

import numpy as np

from pgimp.decomposition.halo import PIECE, PIECES
from pgimp.utilities.model.costs import Costs, Network
from pgimp.utilities.model.layout import Layout

#: Least efficiency at which more ranks pay off.
EFFICIENT = 0.7
#: Most ranks that are tried.
MOST_RANKS = 10_000
#: Bytes of a vertex's record.
_RECORD = 64
#: Numbers of ranks that are tried between two powers of two.
_TRIES = 16


class Step(NamedTuple):
    """A step on a number of ranks; all times are in seconds, on the slowest rank.

    Attributes
    ----------
    ranks, slabs : int
        Ranks, and ranks with layers.
    seconds : float
        Time of the step.
    fixed, mean, excess : float
        Cost of a step without particles. Mean cost of particles and planes over the slabs. Excess
        of the slowest rank over this mean, because layers are not divided.
    planes, calls, reduction : float
        Exposed exchange of shared planes. Latencies and calls of messages to neighbours, with
        migrating particles. Exposed reduction.
    most : int
        Particles of the fullest slab.
    """

    ranks: int
    slabs: int
    seconds: float
    fixed: float
    mean: float
    excess: float
    planes: float
    calls: float
    reduction: float
    most: int

    @property
    def exchange(self) -> float:
        """Part of the step for messages of all kinds."""
        return (self.planes + self.calls + self.reduction) / self.seconds

    def efficiency(self, one: Step) -> float:
        """Speed over the ideal speed of as many ranks; `one` is the step on one rank."""
        return one.seconds / (self.ranks * self.seconds)

    def loss(self, one: Step) -> str:
        """Main loss of efficiency, as text."""
        if self.slabs < self.ranks:
            return out_of_layers(self.slabs)
        losses = {
            "the fixed cost of a step": self.fixed - one.fixed / self.ranks,
            "slabs of whole layers differ": self.excess,
            "the planes that slabs share": self.planes + self.mean - one.mean / self.ranks,
            "the latency of messages": self.calls + self.reduction,
        }
        return max(losses, key=lambda name: losses[name])


def out_of_layers(slabs: int) -> str:
    """Message: there are only this many slabs."""
    return f"the grid has layers for {slabs:,} {'rank' if slabs == 1 else 'ranks'}"


def predict(layout: Layout, costs: Costs, network: Network, ranks: int) -> Step:
    """Predict a step.

    Parameters
    ----------
    layout : Layout
        The work.
    costs : Costs
        Its costs on a node.
    network : Network
        Messages between nodes.
    ranks : int
        Number of ranks.

    Returns
    -------
    Step
        The prediction.
    """
    cuts = np.array(layout.cuts(ranks))
    first, end = cuts[:-1], cuts[1:]
    slabs, s, messages = len(first), layout.vertices, costs.messages
    plane = layout.plane_on(ranks)
    below = np.concatenate([[0], np.cumsum(layout.counts)])
    n = below[end] - below[first]
    # A layer's particles contribute to s planes.
    touched = np.convolve(layout.counts > 0, np.ones(s)) > 0.5
    planes = np.concatenate([[0], np.cumsum(touched)])
    vertices = (planes[end + s - 1] - planes[first]) * float(plane)
    work = costs.particle(n) * n + costs.vertex * vertices
    if ranks > 1:
        work *= costs.busy

    # At each boundary between slabs: running sums go up, partial sums down.
    pairs = s * (s - 1) // 2
    up, down = (k * _RECORD * plane for k in (s - 1, pairs))
    crosses = np.arange(1, slabs) % network.ranks_per_node == 0
    fast = (up + down) / network.bandwidth
    wire, leaves = np.zeros(slabs), np.zeros(slabs)
    wire[1:] += np.where(crosses, fast, up / messages.bandwidth)
    wire[:-1] += np.where(crosses, fast, down / messages.bandwidth)
    # Sums and particles are two messages, one after the other.
    late, latency = np.zeros(slabs), np.where(crosses, network.latency, 0.0)
    late[1:] += latency
    late[:-1] += latency
    leaves[1:] += layout.counts[first[1:]]
    leaves[:-1] += layout.counts[end[:-1] - 1]
    neighbours = np.zeros(slabs)
    neighbours[1:] += 1.0
    neighbours[:-1] += 1.0

    def behind(layers: int, part: float, least: int) -> np.ndarray:
        """Seconds of work on all but the outer `layers`; 0 with fewer particles than `least`."""
        inside = np.maximum(0.0, 1.0 - neighbours * layers / (end - first))
        return np.where(inside * n < least, 0.0, part * work * inside)

    wire += late
    wire -= np.minimum(wire, behind(s - 1, costs.interior, PIECE))
    exchange = neighbours * pairs * costs.vertex * plane + wire
    calls = neighbours * messages.neighbour + leaves * layout.crossing * messages.migrant
    calls += late - np.minimum(late, behind(1, 1.0 - costs.interior, PIECES * PIECE))

    slowest = int((work + exchange + calls).argmax())
    reduction = 0.0
    if ranks > 1:
        nodes = ceil(ranks / network.ranks_per_node)
        reduction = ceil(log2(min(ranks, network.ranks_per_node))) * messages.reduction
        # It overlaps with the sums of the next step's particles.
        far = ceil(log2(nodes)) * network.latency
        reduction += max(0.0, far - costs.interior * float(work[slowest]))
    parts = (
        costs.fixed,
        float(work.mean()),
        float(work[slowest] - work.mean()),
        float(exchange[slowest]),
        float(calls[slowest]),
        reduction,
    )
    return Step(ranks, slabs, sum(parts), *parts, int(n.max()))


def pays_off(
    layout: Layout, costs: Costs, network: Network, most: int = MOST_RANKS
) -> tuple[Step, Step, str]:
    """Greatest number of ranks, up to `most`, that pays off.

    Returns
    -------
    one, best : Step
        A step on one rank, and on the number of ranks that pays off.
    limit : str
        Main loss of efficiency beyond it, as text; empty if it is `most`.
    """
    one = predict(layout, costs, network, 1)
    most = min(most, MOST_RANKS)
    end = min(most, layout.most_ranks)
    tries = [one]
    while tries[-1].ranks < end:
        tries.append(predict(layout, costs, network, min(2 * tries[-1].ranks, end)))
        if tries[-1].efficiency(one) < EFFICIENT / 2.0:
            break
    good = max(k for k, step in enumerate(tries) if step.efficiency(one) >= EFFICIENT)
    best = tries[good]
    if good + 1 < len(tries):
        low, high = best.ranks, tries[good + 1].ranks
        beyond = tries[good + 1]
        for ranks in range(high, low, -max(1, (high - low) // _TRIES)):
            step = predict(layout, costs, network, ranks)
            if step.efficiency(one) >= EFFICIENT:
                best = step
                break
            beyond = step
        return one, best, beyond.loss(one)
    if best.ranks == most:
        return one, best, ""
    return one, best, out_of_layers(end)
