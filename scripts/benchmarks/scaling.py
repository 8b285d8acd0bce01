"""Strong and weak scaling on the cores that there are; messages and imbalance on many ranks."""

import json
import subprocess
import sys
from statistics import median

from blocks import block, create
from picture import plt, save
from report import ERRORS, count, number, origin, spread, write
from workers.messages import counting, sent
from workers.processes import Worker, environment, launch, wait

from pgimp.solver.simulation import RESORT

#: Ranks that share the cores, for counts alone.
MANY = (4, 8, 16, 32, 64)
#: Steps before and while messages are counted.
BEFORE, COUNTED = 2, 5


def timings(quick):
    """Rows of the table for 1 and 2 ranks.

    Strong: the same block on both; weak: twice as long; apart: two runs of one rank beside each
    other, which share nothing but the machine, so that no code can do better.
    """
    blocks = {"2D": (24, 16)} if quick else {"3D": (32, 32, 32), "2D": (256, 256)}
    rounds, steps = (2, 4) if quick else (6, RESORT)
    jobs = [
        (f"{name}, {kind}", kind, ranks, (cells[0] * (2 if kind == "weak" else 1), *cells[1:]))
        for name, cells in blocks.items()
        for kind, ranks in (("strong", 1), ("apart", 2), ("strong", 2), ("weak", 2))
    ]
    one, second, two = (Worker(launch(ranks, ["workers/pgimp_worker.py"])) for ranks in (1, 1, 2))
    teams = {("strong", 1): [one], ("apart", 2): [one, second]}
    try:
        for name, kind, ranks, cells in jobs:
            words = {"case": block(cells), "random": True, "steps": steps}
            for worker in teams.get((kind, ranks), [two]):
                worker.ask(do="make", name=name, **words)
        for _ in range(rounds):
            for name, kind, ranks, _ in jobs:
                team = teams.get((kind, ranks), [two])
                for worker in team:
                    worker.tell(do="round", name=name)
                for worker in team:
                    worker.hear()
        found = {
            (name, ranks): [
                worker.ask(do="result", name=name) for worker in teams.get((kind, ranks), [two])
            ]
            for name, kind, ranks, _ in jobs
        }
    finally:
        for worker in (one, second, two):
            worker.close()
    rows = []
    for name, kind, ranks, cells in jobs:
        alone = found[name.replace(kind, "strong"), 1][0]["speeds"]
        results = found[name, ranks]
        speeds = [sum(every) for every in zip(*(one["speeds"] for one in results), strict=True)]
        gains = [a / b for a, b in zip(speeds, alone, strict=True)]
        rows.append({
            "scene": name, "kind": kind if ranks > 1 else "one",
            "ranks": "2 runs of 1" if kind == "apart" else str(ranks),
            "cells": " x ".join(map(str, cells)), "speed": median(speeds), "speeds": speeds,
            "gain": median(gains), "gains": gains, "efficiency": median(gains) / ranks,
            "velocity": max(one["velocity"] for one in results),
            "stress": max(one["stress"] for one in results),
        })  # fmt: skip
    return rows, rounds, steps


def counts(folder, ranks, quick):
    """Rows of the table for many ranks, from one job of as many as are asked for at most."""
    word = "quick" if quick else "whole"
    command = launch(ranks[-1], ["scaling.py", word, *map(str, ranks)])
    env = environment(counting(folder))
    done = subprocess.run(command, env=env, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"benchmark: {' '.join(command)} failed:\n{done.stderr[-3000:]}")
    return json.loads(done.stdout.splitlines()[-1])


def count_here(quick, ranks):
    """Count on the first ranks of this job, for each number; collective. Rows on rank 0."""
    from mpi4py import MPI

    world, rows = MPI.COMM_WORLD, []
    across = (6, 6) if quick else (12, 12)
    for size in ranks:
        some = world.Split(int(world.rank < size), world.rank)
        if world.rank < size:
            for kind, along in (("strong", 2 * ranks[-1] + 32), ("weak", 8 * size)):
                sim = create(block((along, *across)), some, random=True)
                for _ in range(BEFORE):
                    sim.advance(complete=False)
                sim.complete_reduction()
                before = sent()
                for _ in range(COUNTED):
                    sim.advance(complete=False)
                sim.complete_reduction()
                every = some.gather([*((sent() - before) / COUNTED), sim.rank.count])
                if world.rank == 0:
                    messages, volume, reductions, _, particles = zip(*every, strict=True)
                    mean = sum(particles) / size
                    rows.append({
                        "scene": f"3D, {kind}", "ranks": size,
                        "cells": " x ".join(map(str, (along, *across))), "messages": max(messages),
                        "messages of all": sum(messages), "kilobytes": max(volume) / 1e3,
                        "kilobytes of all": sum(volume) / 1e3, "reductions": max(reductions),
                        "particles": mean, "imbalance": max(particles) / mean - 1.0,
                    })  # fmt: skip
                del sim
        some.Free()
        wait(world)
    return rows


def main(folder, quick):
    """Measure, and write scaling.md, scaling-messages.md, their CSV and scaling.png."""
    rows, rounds, steps = timings(quick)
    columns = {
        "scene": lambda row: row["scene"],
        "ranks": lambda row: row["ranks"],
        "block [cells]": lambda row: row["cells"],
        "million particle-steps/s": lambda row: spread(row["speeds"]),
        "over one rank": lambda row: number(row["gain"], 2),
        "efficiency": lambda row: f"{100 * row['efficiency']:.0f} %",
    } | ERRORS
    note = (
        "Blocks in free fall, gimp, neo-Hookean, random positions: strong, the same block on all "
        "ranks; weak, one that is longer by as much; apart, two runs of one rank beside each "
        "other, which share nothing but the machine. Medians (least to greatest) of "
        f"{rounds} rounds of {steps} steps, all by turns. {origin()}"
    )
    write(folder, "scaling", "Scaling", columns, rows, note)
    many = counts(folder, (2, 3) if quick else MANY, quick)
    columns = {
        "scene": lambda row: row["scene"],
        "ranks": lambda row: str(row["ranks"]),
        "block [cells]": lambda row: row["cells"],
        "particles a rank": lambda row: count(row["particles"]),
        "messages a step and rank": lambda row: number(row["messages"]),
        "kB a step and rank": lambda row: number(row["kilobytes"]),
        "messages a step": lambda row: number(row["messages of all"]),
        "kB a step": lambda row: number(row["kilobytes of all"]),
        "reductions a step": lambda row: number(row["reductions"]),
        "imbalance": lambda row: f"{100 * row['imbalance']:.1f} %",
    }
    note = (
        "Many ranks that share the cores: counted, not timed. Messages and kilobytes are those "
        "that the busiest rank sends, and all ranks; the imbalance is the most particles of a rank "
        f"over their mean, less 1. {COUNTED} steps after {BEFORE}. {origin()}"
    )
    write(folder, "scaling-messages", "Messages on many ranks", columns, many, note)
    if not quick:
        draw(folder, many)
    return rows, many


def draw(folder, rows):
    """Kilobytes and imbalance over ranks."""
    figure, axes = plt.subplots(1, 2, figsize=(7.0, 2.8))
    for name, colour in (("3D, strong", "#1f5fa8"), ("3D, weak", "#d98e04")):
        shown = [row for row in rows if row["scene"] == name]
        ranks = [row["ranks"] for row in shown]
        for axis, key in zip(axes, ("kilobytes", "imbalance"), strict=True):
            factor = 100 if key == "imbalance" else 1
            axis.plot(ranks, [factor * row[key] for row in shown], "o-", color=colour, label=name)
            axis.set_xscale("log", base=2)
            axis.set_xlabel("ranks")
    axes[0].set_ylabel("kB that a rank sends in a step")
    axes[0].set_ylim(bottom=0.0)
    axes[1].set_ylabel("imbalance [%]")
    axes[0].legend()
    save(figure, folder / "scaling.png")


if __name__ == "__main__":
    found = count_here(sys.argv[1] == "quick", [int(word) for word in sys.argv[2:]])
    if found:
        print(json.dumps(found), flush=True)
