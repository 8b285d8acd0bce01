"""How even the load stays while bodies move from rank to rank, and what that costs.

Prints Markdown: particles of the fullest rank over the mean at every step, with slab boundaries
that stay and with such that follow, the least that layers allow, and the same for the time that
ranks take, which differs where cores or particles do; then cases whose load hardly moves, by turns
with either: the moves, and the time of a step.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import numpy as np
from report import ROOT, table
from workers.processes import environment

from pgimp.decomposition.slabs import cut

TESTS = ROOT / "tests" / "support"
sys.path.insert(0, str(TESTS / "cases"))

from balance_scenes import column, crossing  # noqa: E402
from scenes import write_case  # noqa: E402

#: Cases of the second table, and what makes them short enough.
STILL = {
    "block3d": [
        "output.every=null", "history.every={steps: 100}",
        "bodies.block.formulation=updated-lagrangian",
    ],
    "disks": [
        "output.every=null", "history.every={steps: 100}", "contact=[]", "method.affine=false",
        "bodies.left.formulation=updated-lagrangian", "bodies.right.formulation=updated-lagrangian",
    ],
    "vortex": ["output.every=null", "history.every={steps: 100}"],
}  # fmt: skip


def mpirun(ranks, words, switch=""):
    """Run Python on some ranks, and fail with what it says if it does."""
    command = ["mpirun", "-q", "--bind-to", "none", "--oversubscribe", "-n", str(ranks)]
    env = environment({"PGIMP_BALANCE": switch})
    done = subprocess.run(
        [*command, sys.executable, *words], env=env, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit(done.stderr)
    return done.stdout


def moving(folder, quick):
    """Rows of the first table."""
    scenes = {"column": column(30, 7.0), "crossing": crossing(30, 9.0)}
    if not quick:
        scenes = {"column": column(96, 20.0), "crossing": crossing(160, 24.0)}
    for name, case in scenes.items():
        write_case(folder / f"{name}.yaml", case)
    cases = [str(folder / f"{name}.yaml") for name in scenes]
    for ranks in (2,) if quick else (2, 3, 4):
        for how in ("off", "on"):
            out = folder / f"{how}-{ranks}"
            mpirun(ranks, [str(TESTS / "programs" / "balance_probe.py"), how, str(out), *cases])
            for name in scenes:
                told = json.loads((out / f"{name}.json").read_text())
                counts = np.array(told["ranks"], float)
                uneven = 100.0 * (counts.max(axis=1) / counts.mean(axis=1) - 1.0)
                parts = [shares(layers, ranks) for layers in told["layers"][::10]]
                least = 100.0 * max(part.max() / part.mean() - 1.0 for part in parts)
                times = 100.0 * np.mean([time for time in told["times"] if time is not None])
                figures = uneven.mean(), np.percentile(uneven, 95), uneven.max(), least, times
                first = name, int(counts[0].sum()), ranks, how, len(told["moves"])
                yield (*first, *(f"{figure:.1f}" for figure in figures))


def shares(layers, ranks):
    """Particles of each rank after the best cut."""
    return np.add.reduceat(np.array(layers, float), cut(layers, ranks, 2)[:-1])


def still(folder, quick):
    """Rows of the second table."""
    for name, words in STILL.items():
        options = [word for change in words for word in ("--set", change)]
        rates, moves = {"0": [], "1": []}, []
        for _ in range(1 if quick else 7):
            for switch, found in rates.items():
                command = [
                    "-m", "pgimp", str(ROOT / "cases" / f"{name}.yaml"), *options, "--overwrite",
                ]  # fmt: skip
                said = mpirun(2, [*command, "-o", str(folder / name)], switch)
                found.append(float(re.search(r"(\S+) particle-steps/s; output", said)[1]))
                log = (folder / name / "log.txt").read_text()
                times = re.search(r"boundaries moved (?:(\d+) times|once)", log)
                if switch == "1":
                    moves.append(int(times[1] or 1) if times else 0)
        ratios = [on / off for on, off in zip(rates["1"], rates["0"], strict=True)]
        steps = json.loads((folder / name / "run.json").read_text())["starts"][-1]["steps"]
        yield name, steps, " ".join(map(str, moves)), f"{median(ratios):.3f}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true", help="small scenes: no figures to keep")
    quick = parser.parse_args().quick
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as name:
        folder = Path(name)
        heads = ("scene", "particles", "ranks", "balance", "moves")
        excess = ("mean, %", "95 of 100, %", "most, %", "least possible, %", "mean of time, %")
        print(table((*heads, *excess), moving(folder, quick)), flush=True)
        heads = ("case", "steps", "moves in each run", "speed with balance over that without")
        print(f"\n{table(heads, still(folder, quick))}\n")
