"""Report on the cost of a case: time on this machine and on others, and memory."""

import numpy as np

from pgimp.mpi.comm import Serial
from pgimp.mpi.limits import limits
from pgimp.running.progress import duration
from pgimp.scene.bodies.extent import extents
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.scene import Scene
from pgimp.solver.start.memory import Estimate, estimate, size_text
from pgimp.utilities.check.settling import Settling
from pgimp.utilities.model.costs import Costs, Network
from pgimp.utilities.model.layout import layout_now, layout_of
from pgimp.utilities.model.measure import costs_of, run_in_turn
from pgimp.utilities.model.predict import Step
from pgimp.utilities.model.report import (
    between_nodes,
    lines,
    on_node,
    rank_counts,
    remark,
    scaling,
    verdict,
)
from pgimp.utilities.model.sample import samples_of

#: Particles of the timed samples; the last exceeds the caches.
_SMALLEST, _SMALL, _LARGE = 200, 5_000, 150_000
#: Seconds of timing.
_SECONDS = 1.0
_YEAR = 365.25 * 86400.0


def measure(scene: Scene, count: int, steps: float) -> tuple[Costs | None, float]:
    """Costs of a step on this machine, and the fraction of particles that change layer in it.

    `steps` is the case's approximate number. Costs are None if no sample can do a step.
    """
    comm = Serial()
    sizes = [min(_SMALLEST, count), _SMALL, *([min(_LARGE, count)] if count > 2 * _SMALL else [])]
    samples = samples_of(scene.case, count, comm, sizes, steps)
    run_in_turn(samples, comm, _SECONDS)
    if not all(sample.timed for sample in samples):
        return None, 0.0
    return costs_of(samples), layout_now(samples[-1].sim).crossing


def report_cost(
    scene: Scene,
    lattice: Lattice,
    counts: np.ndarray,
    costs: Costs,
    crossing: float,
    steps: float,
    settling: Settling,
    verbose: bool,
) -> None:
    """Print the time on this machine, the number of ranks that pays off, and its limit's reason."""
    bodies, count, network = extents(scene.case), int(counts.sum()), Network()
    layout = layout_of(scene, bodies, lattice.coordinates[0], counts.sum(axis=0))
    layout = layout._replace(crossing=crossing)

    def memory(step: Step) -> float:
        return estimate(scene, step.ranks, True, bodies, count, step.most / count).size

    scaled = scaling(layout, costs, network, memory)
    one, ranks = scaled["steps"][0]["seconds"], scaled["pays_off"]
    best = next(step for step in scaled["steps"] if step["ranks"] == ranks)
    alone = "; more ranks do not pay off" if ranks == 1 and not verbose else ""
    print(
        f"time             {_time_text(steps * one)} on one rank of this machine, without output "
        f"({1e-6 * count / one:.3g} million particle-steps/s measured){alone}"
    )
    if settling.high:
        low, high = (_time_text(number * one) for number in settling)
        print(f"{'':<16} and {low} to {high} more until all is at rest, by estimate")
    if steps * one >= _YEAR:
        print("warning: nobody will see the end; is time.end or time.step what it should be?")
    there = f"there {_time_text(steps * best['seconds'])}, {size_text(best['memory'])} a rank"
    if not verbose:
        if ranks > 1:
            print(f"ranks            {verdict(scaled)}; {there}")
        return
    print(f"ranks            {verdict(scaled)}")
    print(f"{'':<16} {there}")
    shown = [
        step
        for step in scaled["steps"]
        if step["ranks"] in (*rank_counts((), ranks), scaled["slabs"])
    ]
    for line in lines(shown, remark(scaled), f"{'':<17}"):
        print(line)
    print(f"{'':<17}{on_node(costs)}")
    if shown[-1]["ranks"] > network.ranks_per_node:
        print(f"{'':<17}{between_nodes(network)}")


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
