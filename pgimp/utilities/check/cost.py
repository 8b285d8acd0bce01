"""Report on the cost of a case: time on this machine, ranks that pay off, and memory."""

import numpy as np

from pgimp.decomposition.slabs import most_slabs
from pgimp.kernels.order.order import layers_of
from pgimp.mpi.limits import limits
from pgimp.running.progress import duration
from pgimp.scene.bodies.extent import extents
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.checks.warned import warned
from pgimp.scene.scene import Scene
from pgimp.solver.start.memory import Estimate, estimate, size_text, window
from pgimp.utilities.check.settling import Settling
from pgimp.utilities.model.costs import Costs
from pgimp.utilities.model.measure import costs_of, run_in_turn
from pgimp.utilities.model.sample import samples_of

#: Particles of the timed samples; the last exceeds the caches.
_SMALLEST, _SMALL, _LARGE = 200, 5_000, 150_000
#: Seconds of timing.
_SECONDS = 1.0
_YEAR = 365.25 * 86400.0
#: Least efficiency at which more ranks pay off.
_EFFICIENT = 0.7
#: Seconds a step that messages with both neighbours on a node are taken to cost.
_MESSAGES = 60e-6


def measure(scene: Scene, count: int, steps: float) -> Costs | None:
    """Costs of a step on this machine; None if no sample of the case can do one.

    `steps` is the case's approximate number.
    """
    sizes = [min(_SMALLEST, count), _SMALL, *([min(_LARGE, count)] if count > 2 * _SMALL else [])]
    samples = samples_of(scene.case, count, sizes, steps)
    run_in_turn(samples, _SECONDS)
    return costs_of(samples) if all(sample.timed for sample in samples) else None


def report_cost(
    scene: Scene,
    lattice: Lattice,
    counts: np.ndarray,
    costs: Costs,
    steps: float,
    settling: Settling,
    verbose: bool,
) -> None:
    """Print the time on this machine, and the number of ranks that pays off."""
    bodies, count = extents(scene.case), int(counts.sum())
    plane = float(np.prod(window(scene, bodies, 1)[1:], dtype=np.int64))
    work = costs.work(count, plane * _active_planes(scene, lattice, counts))
    one = costs.fixed + work
    slabs = most_slabs(scene.domain.frame.vertices[0], scene.settings.vertices - 1, scene.ends)
    ranks = ranks_that_pay(costs.fixed, work, slabs)
    alone = "; more ranks do not pay off" if ranks == 1 and not verbose else ""
    print(
        f"time             {_time_text(steps * one)} on one rank of this machine, without output "
        f"({1e-6 * count / one:.3g} million particle-steps/s measured){alone}"
    )
    if settling.high:
        low, high = (_time_text(number * one) for number in settling)
        print(f"{'':<16} and {low} to {high} more until all is at rest, by estimate")
    if steps * one >= _YEAR:
        text = "nobody will see the end; is time.end or time.step what it should be?"
        print(warned("endless", text).line(verbose))
    if ranks > 1:
        beyond = "the fixed cost of a step"
        if ranks == slabs:
            beyond = f"the grid has layers for {slabs:,} ranks"
        best = costs.fixed + _MESSAGES + work / ranks
        size = estimate(scene, ranks, True, bodies, count, 1.0 / ranks).size
        print(
            f"ranks            up to {ranks:,} pay off (efficiency above {_EFFICIENT:.0%}); "
            f"beyond, {beyond}; there {_time_text(steps * best)}, {size_text(size)} a rank"
        )
    elif verbose:
        print(f"ranks            1; more do not pay off (efficiency above {_EFFICIENT:.0%})")
    if verbose:
        each = ", ".join(f"{1e9 * t:.3g} ns among {n:,.0f}" for n, t in costs.particles)
        print(
            f"{'':<16} a step: {1e6 * costs.fixed:.3g} us without particles; a particle of a rank: "
            f"{each}; {1e9 * costs.vertex:.3g} ns a vertex"
        )
        print(f"{'':<16} layers of the grid are for {slabs:,} ranks at most")


def ranks_that_pay(fixed: float, work: float, most: int) -> int:
    """Greatest number of ranks, up to `most`, with an efficiency above 70 %.

    Each rank has the fixed cost of a step, and messages to its neighbours on a node; the work is
    shared. `fixed` and `work` are seconds of a step on one rank.
    """
    ranks = ((fixed + work) / _EFFICIENT - work) / (fixed + _MESSAGES)
    return max(1, min(most, int(ranks)))


def _active_planes(scene: Scene, lattice: Lattice, counts: np.ndarray) -> int:
    """Number of planes of vertices to which particles contribute."""
    x = lattice.coordinates[0]
    layer = np.empty(len(x), np.int64)
    layers_of(scene.settings.shape, scene.order_frame, scene.setting.identity, x, layer)
    there = np.zeros(scene.domain.frame.vertices[0], bool)
    there[layer[counts.sum(axis=0) > 0]] = True
    return int(np.count_nonzero(np.convolve(there, np.ones(scene.settings.vertices))))


def _time_text(seconds: float) -> str:
    return duration(seconds) if seconds < _YEAR else f"{seconds / _YEAR:.3g} years"


def report_memory(found: Estimate, verbose: bool, output: str = "") -> None:
    """Print memory on one rank, needed and available, and output; parts of memory if `verbose`."""
    free = min((limit.free for limit in limits()), default=None)
    here = "" if free is None else f"; {size_text(free)} are free here"
    print(f"memory           about {size_text(found.size)} on one rank{here}{output}")
    for part in found.parts if verbose else ():
        if part.size > 0.01 * found.size:
            print(f"{'':<16} {size_text(part.size)} for {part.what}")
