"""``pgimp bench``: the standard block, in particle-steps per second by phase, with its error.

A neo-Hookean block of 32 x 32 x 32 cells, 8 particles a cell at random positions, falls freely. Its
exact motion is rigid, so stresses and velocity differences are errors.
"""

import argparse
import json
import platform
from contextlib import nullcontext
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from pgimp.jit.compiled.cache import announced
from pgimp.mpi.comm import say, world
from pgimp.mpi.communicator import Communicator
from pgimp.solver.decomposition import RESORT
from pgimp.solver.simulation import Simulation
from pgimp.utilities.model.block import GRAVITY, SPEED, YOUNG, Block, block_case

#: Phases of the table, each the sum of some of the simulation's phases.
_TABLE = {
    "P2G": ("P2G",),
    "grid": ("momentum",),
    "G2P": ("G2P",),
    "sort": ("order", "sort"),
    "exchange": ("exchange", "migrate"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--cells", type=int, default=32, help="cells along each edge of the block (default 32)"
    )
    parser.add_argument(
        "--repeats", type=int, default=10, help=f"timed blocks of {RESORT} steps (default 10)"
    )
    parser.add_argument(
        "--lattice", action="store_true", help="particles on a lattice, not at random positions"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def _errors(sim: Simulation) -> dict[str, float]:
    """Deviation from free fall: greatest velocity error over the speed, greatest stress over E."""
    rows = sim.live()
    v = np.array([SPEED, 0.0, GRAVITY * sim.time])
    velocity = np.abs(sim.particles.v[rows] - v).max(initial=0.0) / np.linalg.norm(v)
    stress = np.abs(sim.particles.sigma[rows]).max(initial=0.0) / YOUNG
    every = np.array(sim.comm.allgather((velocity, stress)))
    return {"velocity": float(every[:, 0].max()), "stress": float(every[:, 1].max())}


def measure(comm: Communicator, cells: int, repeats: int, lattice: bool) -> dict[str, object]:
    """Run the benchmark; collective.

    Returns
    -------
    dict
        ``particle_steps_per_second`` (median over the repeats), ``phases`` (the same for each
        single phase, on the slowest rank), ``error`` relative to the exact free fall.
    """
    from pgimp.case.schema import Case

    case = Case.model_validate(block_case(cells, RESORT * (repeats + 1)))
    sim = (Simulation if lattice else Block)(case, comm)
    walls: list[float] = []
    phases: dict[str, list[float]] = {name: [] for name in _TABLE}
    for block in range(repeats + 1):
        before = dict(sim.rank.timings)
        comm.Barrier()
        begin = perf_counter()
        for _ in range(RESORT):
            sim.advance(complete=False)
        sim.complete_reduction()
        comm.Barrier()
        wall = perf_counter() - begin
        if block == 0:
            continue  # first touch of memory
        walls.append(wall)
        for name, parts in _TABLE.items():
            spent = sum(sim.rank.timings[part] - before[part] for part in parts)
            phases[name].append(max(comm.allgather(spent)))
    work = sim.count * RESORT
    return {
        "particle_steps_per_second": work / median(walls),
        "phases": {n: work / median(t) if median(t) > 0 else None for n, t in phases.items()},
        "particles": sim.count,
        "steps": RESORT * repeats,
        "ranks": comm.size,
        "positions": "lattice" if lattice else "random",
        "error": _errors(sim),
        "cpu": platform.processor() or platform.machine(),
    }


def execute(args: argparse.Namespace) -> int:
    """Run the command; also under mpirun."""
    comm = world()
    with announced(say) if comm.rank == 0 else nullcontext():
        return _execute(args, comm)


def _execute(args: argparse.Namespace, comm: Communicator) -> int:
    result = measure(comm, args.cells, args.repeats, args.lattice)
    if comm.rank == 0:
        print(json.dumps(result, indent=2) if args.json else _table(result))
    return 0


def _table(result: dict[str, Any]) -> str:
    """The result as text."""
    lines = [
        f"3D contiguous GIMP, neo-Hookean, {result['particles']:,} particles at "
        f"{result['positions']} positions, {result['ranks']} rank(s), {result['steps']} steps",
        f"{'phase':<10} {'million particle-steps/s':>26}",
    ]
    for name, speed in result["phases"].items():
        lines.append(f"{name:<10} {'-' if speed is None else f'{speed / 1e6:.2f}':>26}")
    lines.append(f"{'total':<10} {result['particle_steps_per_second'] / 1e6:>26.2f}")
    error = result["error"]
    lines.append(
        f"error against free fall: velocity {error['velocity']:.1e} of the speed, "
        f"stress {error['stress']:.1e} of Young's modulus"
    )
    return "\n".join(lines)
