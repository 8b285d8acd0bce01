"""What tests let all ranks of one start do: several runs in a row, or one that is disturbed.

rank_probe.py runs FOLDER CASE.yaml ...     runs cases, each into FOLDER/NAME of the case, with
                                            checkpoints; what is there goes on from the newest one
rank_probe.py poison RANK STEP WORDS ...    pgimp WORDS; on one rank a particle's F becomes NaN
"""

import sys
from pathlib import Path

from pgimp.solver.simulation import Simulation


def poison(rank, step):
    """Let the first particle of a rank have a deformation that is no number before a step."""
    advance = Simulation.advance

    def disturbed(sim):
        if sim.comm.rank == rank and sim.step == step - 1:
            sim.particles.F[sim.live()[0], 0] = float("nan")
        advance(sim)

    Simulation.advance = disturbed


if __name__ == "__main__":
    if sys.argv[1] == "runs":
        from pgimp import run

        folder = Path(sys.argv[2])
        for case in sys.argv[3:]:
            checkpoints = ["checkpoint={every: {steps: 11}, keep: 1000}"]
            output = folder / Path(case).stem
            run(case, output=output, overrides=checkpoints, resume=True, quiet=True)
    else:
        from pgimp.cli import main

        poison(int(sys.argv[2]), int(sys.argv[3]))
        sys.exit(main(sys.argv[4:]))
