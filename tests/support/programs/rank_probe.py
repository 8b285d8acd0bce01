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
from pgimp.solver.simulation import Simulation


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
