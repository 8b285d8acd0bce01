"""The model of the standard block, measured on the present ranks, predicted for thousands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.mpi.communicator import Communicator
from pgimp.solver.simulation import Simulation
from pgimp.solver.start.memory import estimate
from pgimp.utilities.model.block import Block, block_case, block_layout
from pgimp.utilities.model.costs import Network
from pgimp.utilities.model.predict import Step, predict
from pgimp.utilities.model.report import (
    assumptions,
    entry,
    lines,
    rank_counts,
    remark,
    scaling,
    seconds_text,
    verdict,
)
from pgimp.utilities.model.sample import Sample
from pgimp.utilities.model.verify import compare

#: Cells of the samples along an edge; the last sample exceeds the caches.
_SAMPLES = (3, 9, 28)
_STEPS = 10**6
#: Most particles for the model.
MOST_PARTICLES = 10**10


def model_block(
    comm: Communicator, cells: int, repeats: int, lattice: bool, particles: int, network: Network
) -> tuple[dict[str, Any], str]:
    """Measure, compare with the block of `cells`, and extrapolate; collective.

    Parameters
    ----------
    cells, repeats : int
        Cells along an edge, and repetitions of the timing.
    lattice : bool
        Whether particles are on a lattice, not at random positions.
    particles : int
        Approximate particles of the block for strong scaling; 0: as many as measured.

    Returns
    -------
    result : dict
        ``costs``, ``network``, ``measured``, ``strong`` and ``weak``; see `scaling`.
    text : str
        The same as text.
    """
    kind = Simulation if lattice else Block
    edge = max(1, round((particles / 8) ** (1.0 / 3.0))) if particles else cells

    def block(n: int, on: Communicator) -> Simulation:
        return kind(Case.model_validate(block_case(n, _STEPS)), on)

    sizes = _SAMPLES[:2] if max(cells, edge) <= _SAMPLES[1] else _SAMPLES

    def samples() -> Iterator[Sample]:
        for n in sizes:
            yield Sample(lambda n=n: block(n, Serial()), Serial())  # type: ignore[misc]

    costs, compared = compare(
        comm,
        samples,
        lambda on: block(sizes[0], on),
        lambda on: block(sizes[-1], on),
        {"block": lambda on: block(cells, on)},
        network,
        0.0,
        repeats,
    )
    scene, bodies, layout = block_layout(edge, 1, not lattice)

    def memory(step: Step) -> float:
        share = step.most / layout.particles
        return estimate(scene, step.ranks, True, bodies, layout.particles, share).size

    strong = scaling(layout, costs, network, memory)
    weak: list[dict[str, Any]] = []
    for ranks in rank_counts(()):
        scene, bodies, layout = block_layout(cells, ranks, not lattice)
        step = predict(layout, costs, network, ranks)
        efficiency = weak[0]["seconds"] / step.seconds if weak else 1.0
        weak.append(entry(step, layout.particles, efficiency, memory(step)))
    result = {
        "ranks": comm.size,
        "positions": "lattice" if lattice else "random",
        "costs": costs._asdict() | {"messages": costs.messages._asdict()},
        "network": network._asdict(),
        "measured": [one._asdict() | {"deviation": one.deviation} for one in compared],
        "strong": strong,
        "weak": weak,
    }
    text = [
        "model of the standard block: 3D contiguous GIMP, neo-Hookean, 8 particles a cell, "
        f"{result['positions']} positions",
        *assumptions(costs, network),
        *(
            f"check: {one.particles:,} particles on {one.ranks} "
            f"rank{'s' * (one.ranks > 1)}: {seconds_text(one.measured)} a step measured, "
            f"{seconds_text(one.predicted)} predicted ({one.deviation:+.0%})"
            for one in compared
        ),
        "",
        f"strong scaling: {strong['particles']:,} particles, a cube",
        *lines(strong["steps"], remark(strong)),
        f"ranks: {verdict(strong)}",
        "",
        f"weak scaling: {weak[0]['most_particles']:,} particles a rank, a bar along x",
        *lines(weak, lambda step: ""),
    ]
    return result, "\n".join(text)
