"""What tests let all ranks of one start do: runs whose slab boundaries move, or are watched.

balance_probe.py HOW FOLDER CASE.yaml ...   runs cases, each into FOLDER/NAME of the case, with
                                            checkpoints; what is there goes on from the newest one

HOW is `off`; `on`, as people run it; `shuffled`: to random places every few steps; `counted`: as on,
but every particle takes the same time, and moving next to none, whatever a clock says.
FOLDER/NAME.json gets the particles of each rank at every step, those of each layer, and the number
of moves.
"""

import json
import os
import sys
from pathlib import Path

import numpy as np

how, folder, cases = sys.argv[1], Path(sys.argv[2]), sys.argv[3:]
os.environ["PGIMP_BALANCE"] = "0" if how == "off" else "1"

from pgimp import run  # noqa: E402
from pgimp.solver.balance import Balance  # noqa: E402
from pgimp.solver.simulation import Simulation  # noqa: E402

EVERY = 5


def random_cuts(balance, counts, step):
    """Any that are allowed."""
    layers, width, active = len(counts), balance._vertices - 1, len(balance.cuts) - 1
    ends = max(width, balance._ends)
    least = ends + width * np.arange(active - 1)
    slack = layers - ends - least[-1] if active > 1 else 0
    extra = np.sort(np.random.default_rng(step).integers(0, slack + 1, active - 1))
    balance.moves.append((0.0, 0.0))
    return [0, *(int(n) for n in least + extra), layers]


def ask(balance, timings, count):
    balance._taken += 1
    balance.asks = balance._taken % EVERY == 0


def alike(balance, timings, count):
    """A step of which each particle took a microsecond."""
    noted(
        balance,
        {"P2G": balance._taken * 1e-6 * count, "G2P": 0.0, "order": 0.0, "momentum": 0.0},
        count,
    )


noted = Balance.note
if how == "shuffled":
    Balance.decide, Balance.note = random_cuts, ask

    def moved(balance, seconds):
        pass

    Balance.moved = moved

watched: dict = {}
advance = Simulation.advance


def watch(sim):
    advance(sim)
    if sim.comm.size > 1:
        now = sim.comm.gather((sim.local_count, np.diff(sim.population.start)))
        if now is not None:
            watched.setdefault("ranks", []).append([part[0] for part in now])
            watched.setdefault("layers", []).append(
                np.concatenate([part[1] for part in now]).tolist()
            )
            watched["moves"] = len(sim.balance.moves)
            watched["told"] = sim.balance.moves


Simulation.advance = watch
for case in cases:
    watched.clear()
    name = Path(case).stem
    checkpoints = ["checkpoint={every: {steps: 23}, keep: 1000}"]
    result = run(case, output=folder / name, overrides=checkpoints, resume=True, quiet=True)
    if watched:
        (folder / f"{name}.json").write_text(json.dumps(watched))
