"""``pgimp bench``: the standard block, in particle-steps per second by phase, with its error.

A neo-Hookean block of 32 x 32 x 32 cells, 8 particles a cell at random positions, falls freely:
its exact motion is rigid, so whatever stress and velocity differences appear are errors.
"""

import argparse
import json
import platform
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from pgimp.kernels.order import locate
from pgimp.parallel.comm import world
from pgimp.scene.lattice import Lattice
from pgimp.solver.particles import Particles
from pgimp.solver.simulation import RESORT, Simulation

_YOUNG, _POISSON, _DENSITY, _GRAVITY, _SPEED = 1.0e6, 0.3, 1000.0, -9.81, 0.1
#: Phases of the table, and the simulation's phases that each sums.
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


class _Block(Simulation):
    """The block, its particles moved to random positions within their cells."""

    def decompose(self, layer_counts: np.ndarray) -> None:
        # Of a cell's positions, the part below the half-width has its support one vertex earlier.
        half = self.scene.shape.half[0]
        moved = np.round(half * layer_counts).astype(np.int64)
        super().decompose(layer_counts - moved + np.append(moved[1:], 0))

    def _create(
        self, lattice: Lattice, counts: np.ndarray, layer: np.ndarray
    ) -> tuple[Particles, int]:
        # A random position may lie in a layer next to its lattice plane's: look two cells further.
        reach = 2 * lattice.per_cell[0]
        own = np.searchsorted(layer, (self.slab.first, self.slab.first + self.slab.layers))
        begin, end = max(0, int(own[0]) - reach), min(lattice.planes, int(own[1]) + reach)
        p = self.scene.populate(lattice, counts, (begin, end))
        count = int(counts[:, begin:end].sum())
        cell = np.array(self.scene.frame.cell)
        corner = np.floor(p.x[:count] / cell) * cell
        p.x[:count] = corner + _uniform(p.id[:count]) * cell
        rows = np.arange(count, dtype=np.int32)
        locate(self.scene.shape, self.scene.frame, p, rows, self.scene.frame.vertices)
        here = self.slab.first <= p.layer[:count]
        here &= p.layer[:count] < self.slab.first + self.slab.layers
        arrays: list[np.ndarray] = list(p)
        del p
        for i in range(len(arrays)):  # so that no more than one array is there twice
            arrays[i] = arrays[i][:count][here]
        return Particles._make(arrays), int(here.sum())


def _uniform(ids: np.ndarray) -> np.ndarray:
    """Three numbers in [0, 1) from each id, the same whatever the ranks (splitmix64)."""
    numbers = []
    for d in range(3):
        z = (ids.astype(np.uint64) * np.uint64(3) + np.uint64(d)) * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        numbers.append((z ^ (z >> np.uint64(31))) >> np.uint64(11))
    return np.stack(numbers, axis=1).astype(float) * 2.0**-53


def block_case(cells: int, steps: int) -> dict[str, Any]:
    """The benchmark as a case: a block of `cells` cubed in a domain with four cells around."""
    h, pad = 1.0 / cells, 4
    lam = _YOUNG * _POISSON / ((1 + _POISSON) * (1 - 2 * _POISSON))
    c = np.sqrt((lam + _YOUNG / (1 + _POISSON)) / _DENSITY)
    dt = 0.2 * h / float(c)
    size = h * (cells + 2 * pad)
    return {
        "format": 1,
        "title": "Benchmark block",
        "dimensions": 3,
        "grid": {"origin": [0.0] * 3, "size": [size] * 3, "cell": [h] * 3},
        "method": {"shape": "gimp", "particles_per_cell": [2, 2, 2]},
        "time": {"end": steps * dt, "step": dt},
        "materials": {
            "solid": {
                "model": "neo-hookean",
                "young": _YOUNG,
                "poisson": _POISSON,
                "density": _DENSITY,
            }
        },
        "bodies": {
            "block": {
                "material": "solid",
                "region": {"box": {"min": [pad * h] * 3, "max": [pad * h + 1.0] * 3}},
                "velocity": [_SPEED, 0.0, 0.0],
            }
        },
        "gravity": [0.0, 0.0, _GRAVITY],
    }


def _errors(sim: Simulation) -> dict[str, float]:
    """Deviation from free fall: greatest velocity error over the speed, greatest stress over E."""
    rows = sim.live()
    v = np.array([_SPEED, 0.0, _GRAVITY * sim.time])
    velocity = np.abs(sim.particles.v[rows] - v).max(initial=0.0) / np.linalg.norm(v)
    stress = np.abs(sim.particles.sigma[rows]).max(initial=0.0) / _YOUNG
    every = np.array(sim.comm.allgather((velocity, stress)))
    return {"velocity": float(every[:, 0].max()), "stress": float(every[:, 1].max())}


def measure(comm: Any, cells: int, repeats: int, lattice: bool) -> dict[str, Any]:
    """Run the benchmark; collective.

    Returns
    -------
    dict
        ``particle_steps_per_second`` (median over the repeats), ``phases`` (the same for each
        phase alone, on the slowest rank), ``error`` relative to the exact free fall.
    """
    from pgimp.case.schema import Case

    case = Case.model_validate(block_case(cells, RESORT * (repeats + 1)))
    sim = (Simulation if lattice else _Block)(case, comm)
    walls: list[float] = []
    phases: dict[str, list[float]] = {name: [] for name in _TABLE}
    for block in range(repeats + 1):
        before = dict(sim.timings)
        comm.Barrier()
        begin = perf_counter()
        for _ in range(RESORT):
            sim.advance()
        comm.Barrier()
        wall = perf_counter() - begin
        if block == 0:
            continue  # first touch of memory
        walls.append(wall)
        for name, parts in _TABLE.items():
            spent = sum(sim.timings[part] - before[part] for part in parts)
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
    result = measure(comm, args.cells, args.repeats, args.lattice)
    if comm.rank == 0:
        print(json.dumps(result, indent=2) if args.json else _table(result))
    return 0


def _table(result: dict[str, Any]) -> str:
    """The result for people."""
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
