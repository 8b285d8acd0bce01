"""Heaps of 20 to 100 bodies that touch, stopped and killed, resumed on other ranks: same bits."""

import argparse
import json
import random
import shutil
import time
from collections import Counter

from proofs.jobs import scratch
from proofs.scenes import heaps
from proofs.scenes import runs as scene_runs

import pgimp

#: Kinds and scenes of `--short`.
SHORT = ("drum", "initial")


def main(words):
    """Run as many scenes as asked for; print what became of them."""
    parser = argparse.ArgumentParser(prog="scripts/faults heaps")
    parser.add_argument("--runs", type=int, default=28)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--short", action="store_true", help="few kinds of scenes, few steps")
    options = parser.parse_args(words)
    kinds = SHORT if options.short else [*heaps.KINDS]
    scene_runs.prepare()
    said, began = Counter(), time.monotonic()
    with scratch("heaps") as (folder, failures):
        for number in range(options.first, options.first + options.runs):
            rng, kind = random.Random(f"{options.seed} {number}"), kinds[number % len(kinds)]
            case = heaps.make(rng, kind)
            where = folder / str(number)
            where.mkdir()
            (where / "case.yaml").write_text(json.dumps(case))
            steps, ways, wrong = disturb(where, rng, options.short)
            print(f"{number}: {kind}, {len(case['bodies'])} bodies, {steps} steps: {ways}"
                  f"{wrong and ': ' + wrong}", flush=True)  # fmt: skip
            said["wrong" if wrong else "the same bits"] += 1
            if wrong:
                failures.append(f"scene {number}, {kind}: {ways}: {wrong}")
            else:
                shutil.rmtree(where)
        print(f"{dict(said)} in {time.monotonic() - began:.0f} s")
    return 1 if failures else 0


def disturb(where, rng, short=False):
    """Run a case at once, and again with stops and losses.

    Returns
    -------
    int, str, str
        Steps; how it was disturbed; what is wrong, "" if nothing.
    """
    case, alone, other = where / "case.yaml", where / "alone", where / "other"
    outcome = scene_runs.run(case, alone, 1)
    if outcome.kind != "done":
        return 0, "undisturbed", f"{outcome.kind} {outcome.said}"
    steps = int(pgimp.open(alone).history["step"][-1])
    ways, at, resume = [], 0, False
    for _ in range(2 if short else 4):
        at += 1 + 2 * rng.randint(0, steps // (8 if resume else 4))
        at += 1 - at % 2
        ranks = rng.randint(1, 6)
        if at >= steps:
            break
        found = scene_runs.run(case, other, ranks, resume=resume, stop_at=at)
        if found.kind != "stopped":
            return steps, ", ".join(ways), f"on {ranks} ranks: {found.kind} {found.said}"
        resume = True
        lost = rng.random() < 0.4 and lose(other)
        ways.append(f"on {ranks} {'killed' if lost else 'stopped'} at {at}")
    ranks = rng.randint(1, 6)
    ways.append(f"on {ranks}")
    found = scene_runs.run(case, other, ranks, resume=resume)
    if found.kind != "done":
        return steps, ", ".join(ways), f"{found.kind} {found.said}"
    return steps, ", ".join(ways), ", ".join(scene_runs.differences(alone, other)[:6])


def lose(folder):
    """Delete the last checkpoint, as if the run had been killed; whether there is one before."""
    checkpoints = sorted((folder / "checkpoints").glob("*.h5"))
    if len(checkpoints) < 2:
        return False
    checkpoints[-1].unlink()
    return True
