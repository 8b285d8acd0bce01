"""What tests let all ranks of one start do: runs whose slab boundaries move, or are watched.

balance_probe.py HOW FOLDER CASE.yaml ...   runs cases, each into FOLDER/NAME of the case; what is
                                            there goes on from the newest checkpoint

HOW is `off`; `on`, as people run it; `shuffled`: to random places every few steps, with
checkpoints; `counted`: as on, but every particle takes the same time, and moving next to none,
whatever a clock says; `short`: as shuffled, but the second rank runs out of memory.
FOLDER/NAME.json gets the particles of each rank at every step, those of each layer, the imbalance
of time as last reported, and the moves.
"""

import json
import os
import sys
from pathlib import Path

import numpy as np

from pgimp import run
from pgimp.decomposition import balance, redistribute
from pgimp.decomposition.balance import Balance
from pgimp.mpi.comm import abort_on_error, world
from pgimp.solver.simulation import Simulation

how, folder, cases = sys.argv[1], Path(sys.argv[2]), sys.argv[3:]
os.environ[balance.SWITCH] = "0" if how == "off" else "1"

#: Steps between two moves of those that are shuffled.
EVERY = 5


def ask(mine, worked, count, step):
    mine._taken += 1
    mine.rebalance_requested = mine._taken % EVERY == 0


def random_cuts(mine, counts, step):
    """Any that are allowed."""
    layers, width, active = len(counts), mine._vertices - 1, len(mine.cuts) - 1
    ends = max(width, mine._ends)
    least = ends + width * np.arange(active - 1)
    slack = layers - ends - int(least[-1]) if active > 1 else 0
    extra = np.sort(np.random.default_rng(step).integers(0, slack + 1, active - 1))
    cuts = [0, *(int(n) for n in least + extra), layers]
    mine.moves += [(0.0, 0.0)] * (cuts != mine.cuts)
    return cuts


if how in ("shuffled", "short"):
    Balance.note, Balance.decide = ask, random_cuts
    Balance.moved = lambda mine, seconds, step: None
    redistribute._PIECE = 500  # so that what moves is sent in several messages
if how == "counted":
    noted = Balance.note

    def alike(mine, worked, count, step):
        spent = mine._before[0] + 1e-6 * count
        noted(mine, {"P2G": spent, "G2P": 0.0, "order": 0.0, "momentum": 0.0}, count, step)

    moved = Balance.moved
    Balance.note = alike
    Balance.moved = lambda mine, seconds, step: moved(mine, 0.0, step)
    balance._MOVE_COST = 0.01

watched: dict = {}
advance = Simulation.advance


def watch(sim, complete=True):
    advance(sim, complete)
    now = sim.comm.gather((sim.rank.count, np.diff(sim.population.start)))
    if now is not None:
        watched.setdefault("ranks", []).append([part[0] for part in now])
        watched.setdefault("layers", []).append(np.concatenate([part[1] for part in now]).tolist())
        watched.setdefault("times", []).append(sim.balance.imbalance)
        watched["moves"] = sim.balance.moves


Simulation.advance = watch
with abort_on_error(world()):
    if how == "short" and world().rank == 1:
        unpack = redistribute.unpack

        def fail(*args):
            raise MemoryError("Unable to allocate 3 EiB")

        redistribute.unpack = fail
    for case in cases:
        watched.clear()
        name = Path(case).stem
        kept = ["checkpoint={every: {steps: 23}, keep: 1000}"] if how == "shuffled" else []
        run(case, output=folder / name, overrides=kept, resume=True, quiet=True)
        if watched:
            (folder / f"{name}.json").write_text(json.dumps(watched))
