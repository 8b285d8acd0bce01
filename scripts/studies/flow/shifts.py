"""Measures what the shifts of what flows cost and keep: the dam break with and without them.

Both runs go on by turns in one process, so that a slow machine slows both; see scripts/flows.
"""

from time import process_time
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
from studies.flow import problems
from studies.harness import CASES, Table, origin, out, put

import pgimp

#: The tank in whole cells of 0.04 m, and the height of the centre of water at rest in it.
LENGTH = 3.24
CENTRE = 0.5 * 0.72 / LENGTH
#: Steps of a turn, and from when on the level counts.
TURN, LATE = 100, 9.0


def simulation(cell, shifts):
    """The dam break, to 10 s, with or without shifts."""
    changes = {"grid.cell": [cell, cell], "grid.size": [LENGTH, 2.4], "time.end": 10.0}
    entry = pgimp.load(CASES / "dam-break.yaml", changes | problems.PLAIN)
    if shifts:
        return pgimp.Simulation(entry)
    still = SimpleNamespace(rates=np.zeros(0))
    with patch("pgimp.scene.scene.SceneFlows", lambda *words: still):
        sim = pgimp.Simulation(entry)
    assert not sim.core.scene.interaction.flows
    return sim


def level(sim):
    """Height of the centre over that at rest, less what waves of its kinetic energy raise it."""
    line = sim.diagnostics()
    waves = line["kinetic-energy"] / (line["mass"] * problems.G)
    return (line["body.dam.centre-y"] - waves) / CENTRE


def measured(cell):
    """CPU time of a step without and with shifts, their ratio by turns, steps, levels in the end.

    Times are medians over turns until one of both has come to its end.
    """
    sims = [simulation(cell, shifts) for shifts in (False, True)]
    spent, levels = [], [[], []]
    while not all(sim.finished for sim in sims):
        turn = []
        for k in (0, 1) if len(spent) % 2 else (1, 0):
            sim = sims[k]
            before, began = sim.steps, process_time()
            while not sim.finished and sim.steps < before + TURN:
                sim.step(1)
            turn.append((k, (process_time() - began) / max(sim.steps - before, 1)))
            if sim.time > LATE and sim.steps > before:
                levels[k].append(level(sim))
        if not any(sim.finished for sim in sims):
            spent.append([time for _, time in sorted(turn)])
    times = np.array(spent[2:])  # the first turns compile
    return (
        *np.median(times, axis=0), float(np.median(times[:, 1] / times[:, 0])),
        *(sim.steps for sim in sims), *(float(np.mean(each)) - 1.0 for each in levels),
    )  # fmt: skip


def main():
    """Measure, and write flows.out/shifts.md and docs/soils-and-fluids.md."""
    table = Table(
        "dam break to 10 s, cells of", "a step without, with shifts [ms]", "ratio, by turns",
        "steps without, with", "level without, with",
    )  # fmt: skip
    for cell in (0.04, 0.02):
        plain, shifted, ratio, first, second, low, kept = measured(cell)
        table.add(
            f"{1e3 * cell:.0f} mm", f"{1e3 * plain:.3f}, {1e3 * shifted:.3f}", f"{ratio:.2f}",
            f"{first:,}, {second:,}", f"{100.0 * low:+.1f} %, {100.0 * kept:+.1f} %",
        )  # fmt: skip
    note = f"medians of CPU times of turns of {TURN} steps, one rank: {origin()}."
    text = table.text(f"By `scripts/flows shifts`, {note}")
    put({"shifts": text}, out("flows") / "shifts.md")
