"""Predictions of the model, as text tables and as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from pgimp.solver.start.memory import size_text
from pgimp.solver.start.require_memory import MOST_ROWS
from pgimp.utilities.model.costs import Costs, Network
from pgimp.utilities.model.layout import Layout
from pgimp.utilities.model.predict import EFFICIENT, MOST_RANKS, Step, pays_off, predict

#: Columns of a table of steps.
_HEADINGS = ("ranks", "time a step", "million/s", "efficiency", "messages", "memory a rank")


def rank_counts(marks: Iterable[int], most: int = MOST_RANKS) -> list[int]:
    """Numbers of ranks 1, 2, 4, ..., `most`, with `marks` among them, ascending."""
    powers = {2**k for k in range(most.bit_length())}
    return sorted(n for n in {*powers, most, *marks} if n <= most)


def scaling(
    layout: Layout, costs: Costs, network: Network, memory: Callable[[Step], float]
) -> dict[str, Any]:
    """Strong scaling of a layout: number of ranks that pays off, and the reason for its limit.

    Parameters
    ----------
    memory : callable
        Bytes of a rank in a step.

    Returns
    -------
    dict
        ``particles``, ``slabs`` (the most possible), ``pays_off`` (ranks), ``limit`` (the main loss
        of efficiency beyond, as text) and ``steps``, see `entry`.
    """
    one, best, limit = pays_off(layout, costs, network)
    slabs = layout.most_ranks
    # Beyond the last slab all rows would be the same.
    numbers = [n for n in rank_counts((best.ranks, slabs)) if n <= slabs or n == MOST_RANKS]
    steps = [predict(layout, costs, network, n) for n in numbers]
    return {
        "particles": layout.particles,
        "slabs": slabs,
        "pays_off": best.ranks,
        "limit": limit,
        "steps": [
            entry(step, layout.particles, step.efficiency(one), memory(step)) for step in steps
        ],
    }


def entry(step: Step, particles: int, efficiency: float, memory: float) -> dict[str, Any]:
    """A row of a table: seconds, particle-steps per second, parts of the step, bytes per rank."""
    return {
        "ranks": step.ranks,
        "slabs": step.slabs,
        "seconds": step.seconds,
        "particle_steps_per_second": particles / step.seconds,
        "efficiency": efficiency,
        "messages": step.exchange,
        "most_particles": step.most,
        "memory": memory,
    }


def lines(
    steps: Sequence[dict[str, Any]], remarks: Callable[[dict[str, Any]], str], indent: str = ""
) -> list[str]:
    """The table as text; `remarks` are added to its rows."""
    rows = [
        (
            f"{step['ranks']:,}",
            seconds_text(step["seconds"]),
            f"{step['particle_steps_per_second'] / 1e6:,.3g}"
            if step["particle_steps_per_second"] < 1e9
            else f"{step['particle_steps_per_second'] / 1e6:,.0f}",
            f"{step['efficiency']:.0%}",
            f"{step['messages']:.0%}",
            size_text(step["memory"]),
            remarks(step),
        )
        for step in steps
    ]
    widths = [max(len(row[i]) for row in [_HEADINGS, *rows]) for i in range(len(_HEADINGS))]
    return [
        (
            indent + "  ".join([*map(str.rjust, row[: len(widths)], widths), *row[len(widths) :]])
        ).rstrip()
        for row in [_HEADINGS, *rows]
    ]


def remark(found: dict[str, Any]) -> Callable[[dict[str, Any]], str]:
    """Remarks on the rows of a strong scaling."""

    def text(step: dict[str, Any]) -> str:
        said = []
        if step["ranks"] == found["pays_off"]:
            said.append(f"efficiency is above {EFFICIENT:.0%} up to here")
        if step["ranks"] == found["slabs"]:
            said.append("slabs stop here")
        elif step["slabs"] < step["ranks"]:
            said.append(f"{step['ranks'] - step['slabs']:,} ranks idle")
        if step["most_particles"] > MOST_ROWS:
            said.append("more particles than a rank can number")
        return "; ".join(said)

    return text


def verdict(found: dict[str, Any]) -> str:
    """Number of ranks that pays off, and the reason for its limit, as text."""
    ranks = found["pays_off"]
    text = f"up to {ranks:,} pay off" if ranks > 1 else "1; more do not pay off"
    beyond = f"; beyond, {found['limit']}" if found["limit"] else ""
    return f"{text} (efficiency above {EFFICIENT:.0%}){beyond}"


def assumptions(costs: Costs, network: Network) -> list[str]:
    """Assumptions of the model, as text."""
    few, many = costs.particles[0], costs.particles[-1]
    return [
        f"a step: {seconds_text(costs.fixed)} without particles; {1e9 * few[1]:.3g} ns a particle "
        f"among {few[0]:,.0f} of a rank, {1e9 * many[1]:.3g} ns among {many[0]:,.0f}; "
        f"{1e9 * costs.vertex:.3g} ns a vertex",
        on_node(costs),
        between_nodes(network) + ": --latency, --bandwidth, --ranks-per-node",
    ]


def on_node(costs: Costs) -> str:
    """Cost of messages between ranks of a node, as text."""
    m = costs.messages
    how = "measured" if m.measured else "assumed; `mpirun -n 2 pgimp bench --model` measures"
    return (
        f"messages on a node: {seconds_text(m.neighbour)} a step and neighbour, "
        f"{m.bandwidth / 1e9:.3g} GB/s, reduction {seconds_text(m.reduction)}; work takes "
        f"{costs.busy:.2f} times as long on all ranks at once ({how})"
    )


def between_nodes(network: Network) -> str:
    """Assumed cost of messages between nodes, as text."""
    return (
        f"between nodes: {seconds_text(network.latency)}, {network.bandwidth / 1e9:.3g} GB/s a "
        f"node, {network.ranks_per_node} ranks a node (assumed)"
    )


def seconds_text(seconds: float) -> str:
    """Format a short time."""
    for unit, size in (("us", 1e-6), ("ms", 1e-3)):
        if seconds < 999.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s" if seconds < 999.5 else f"{seconds:,.0f} s"
