"""What tests let all ranks of one start do: several runs in a row, or one that is disturbed.

rank_probe.py runs FOLDER CASE.yaml ...     runs cases, each into FOLDER/NAME of the case, with
                                            checkpoints; what is there goes on from the newest one
rank_probe.py poison RANK STEP WORDS ...    pgimp WORDS; on one rank a particle's F becomes NaN
rank_probe.py invert IDS STEP WORDS ...     the same; particles are turned inside out, wherever
"""

import sys
from pathlib import Path

import numpy as np

from pgimp.decomposition import halo
from pgimp.jit.compiled.cache import KernelCache
from pgimp.solver.simulation import Simulation


def compile_at_starts():
    """Refuse kernels that are not compiled, or loaded, before a run's first step."""
    start, look = Simulation.__init__, KernelCache.load_overload
    begun = [True]

    def starting(*args, **options):
        begun[0] = False
        start(*args, **options)
        begun[0] = True

    def looking(cache, *args):
        assert not begun[0], f"{cache._name} is first called in the run"
        return look(cache, *args)

    Simulation.__init__, KernelCache.load_overload = starting, looking


def poison(sim, rank):
    """Let the first particle of a rank have a deformation that is no number."""
    if sim.comm.rank == int(rank):
        sim.particles.F[sim.live()[0], 0] = float("nan")


def invert(sim, ids):
    """Turn particles inside out."""
    p, rows = sim.particles, sim.live()
    p.F[rows[np.isin(p.id[rows], [int(i) for i in ids.split(",")])], 0] *= -1.0


def disturb(how, whom, step):
    """Do something to particles before a step; also small slabs are advanced in two halves."""
    halo.PIECE = 1
    advance = Simulation.advance

    def disturbed(sim, complete=True):
        if sim.step == step - 1:
            how(sim, whom)
        advance(sim, complete)

    Simulation.advance = disturbed


if __name__ == "__main__":
    if sys.argv[1] == "runs":
        from pgimp import run

        compile_at_starts()
        folder = Path(sys.argv[2])
        for case in sys.argv[3:]:
            checkpoints = ["checkpoint={every: {steps: 23}, keep: 1000}"]
            output = folder / Path(case).stem
            run(case, output=output, overrides=checkpoints, resume=True, quiet=True)
    else:
        from pgimp.cli import main

        how = {"poison": poison, "invert": invert}[sys.argv[1]]
        disturb(how, sys.argv[2], int(sys.argv[3]))
        sys.exit(main(sys.argv[4:]))
