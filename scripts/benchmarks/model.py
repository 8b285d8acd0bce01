"""Verification of the performance model: steps measured and predicted on 1 and 2 ranks.

    python scripts/benchmarks/model.py [--seconds S] [--cpu-time] [NAME ...]

Blocks are timed for some steps, cases of cases/ from beginning to end, by turns with the samples
from which their costs follow, in one process on each of two ranks, on a machine that does nothing
else; on a busy one --cpu-time takes the CPU's time, of one rank only. The table is Markdown; the
status is 1 if a prediction is off by more than 15 %.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 0.15
MPM = "method={shape: mpm, particles_per_cell: [2, 2]}"
#: Name, and what is run: a block with this number of cells along an edge at random or lattice
#: positions, or on a lattice with another shape, or a case with changes.
CASES = {
    **{f"block, {n}^3 cells, random": ("random", n) for n in (8, 16, 32, 48, 64)},
    **{f"block, {n}^3 cells, lattice": ("lattice", n) for n in (16, 32)},
    **{f"block, 32^3 cells, {shape}": (shape, 32) for shape in ("mpm", "finite-gimp")},
    "disks, 2D": ("disks", ["grid.cell=[0.01,0.01]", "contact=[]"]),
    "disks, 2D, coarse": ("disks", ["grid.cell=[0.05,0.05]", "contact=[]"]),
    "vortex, 2D, mpm": ("vortex", [MPM, "time.step=1e-3"]),
    "vortex, 2D, finite-gimp": ("vortex", ["grid.cell=[0.025,0.025]", "time.step=2e-3"]),
    "block on a floor, 3D": (
        "block3d", ["grid.cell=[0.05,0.05,0.05]", "bodies.block.configuration=current"]
    ),
    "spinning block, 3D, finite-gimp": ("spinning-block", []),
    "bar, 1D": ("bar-vibration", []),
    "bar, 1D, fine": ("bar-vibration", ["grid.cell=[0.002]", "time.step=2e-5"]),
}  # fmt: skip


def verify(name: str, seconds: float, cpu_time: bool) -> None:
    """Compare one case on the ranks of this run, and print what came out as JSON."""
    sys.path.insert(0, str(ROOT))
    from pgimp import load
    from pgimp.case.schema import Case
    from pgimp.mpi.comm import Serial, world
    from pgimp.solver import rank, simulation
    from pgimp.solver.simulation import Simulation
    from pgimp.utilities.model import sample
    from pgimp.utilities.model.block import Block, block_case
    from pgimp.utilities.model.costs import Network
    from pgimp.utilities.model.sample import Sample, Scattered, samples_of
    from pgimp.utilities.model.sample_cases import resized
    from pgimp.utilities.model.verify import compare

    if cpu_time:
        for module in (sample, simulation, rank):
            module.perf_counter = time.process_time
    kind, what = CASES[name]
    comm, alone = world(), Serial()
    if isinstance(what, int):

        def block(n, on):
            data = block_case(n, 10**6)
            if kind in ("mpm", "finite-gimp"):
                data["method"]["shape"] = kind
            return (Block if kind == "random" else Simulation)(Case.model_validate(data), on)

        def samples():
            return [Sample(partial(block, n, alone), alone) for n in (3, 9, 28)]

        small, large, target = (partial(block, n) for n in (3, 28, what))
    else:
        case = load(ROOT / f"cases/{kind}.yaml", what)
        count = Simulation(case, alone).count
        sizes = [min(200, count), 5_000, *([min(150_000, count)] if count > 10_000 else [])]

        def sized(size, on):
            return Scattered(resized(case, (count / size) ** (1 / case.dimensions)), on)

        samples = partial(samples_of, case, count, alone, sizes)
        small, large = partial(sized, sizes[0]), partial(sized, sizes[-1])
        target = partial(Simulation, case)
    whole = not isinstance(what, int)
    _, found = compare(comm, samples, small, large, {name: target}, Network(), seconds, 5, whole)
    if comm.rank == 0:
        print(json.dumps([one._asdict() | {"deviation": one.deviation} for one in found]))


def main() -> int:
    """Verify the cases named, or all of them, one after the other."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=30.0, help="of each case (default 30)")
    parser.add_argument(
        "--cpu-time", action="store_true", help="the CPU's time, on one rank, for a busy machine"
    )
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("names", nargs="*", metavar="NAME", help="part of the names of some cases")
    args = parser.parse_args()
    if args.inside:
        verify(args.names[0], args.seconds, args.cpu_time)
        return 0
    chosen = [name for name in CASES if not args.names or any(n in name for n in args.names)]
    allow = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    print("| case | particles | ranks | measured [us a step] | predicted | deviation |")
    print("|---" * 6 + "|")
    worst = 0.0
    for name in chosen:
        words = [sys.executable, __file__, "--inside", name, "--seconds", str(args.seconds)]
        words = [*words, "--cpu-time"] if args.cpu_time else ["mpirun", "-q", "-n", "2", *words]
        done = subprocess.run(words, stdout=subprocess.PIPE, text=True, env=os.environ | allow)
        if done.returncode:
            print(f"{name}: no result, status {done.returncode}", file=sys.stderr)
            return 2
        for one in json.loads(done.stdout):
            worst = max(worst, abs(one["deviation"]))
            print(
                f"| {name} | {one['particles']:,} | {one['ranks']} "
                f"| {1e6 * one['measured']:.4g} | {1e6 * one['predicted']:.4g} "
                f"| {one['deviation']:+.0%} |",
                flush=True,
            )
    print(f"\nThe largest deviation is {worst:.0%}; {LIMIT:.0%} are allowed.")
    return int(worst > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
