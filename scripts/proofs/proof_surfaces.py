"""Random scenes that meet by surfaces: the same files on any ranks; momenta, energy, depth."""

import argparse
import json
import random
import shutil
import time
from collections import Counter

from proofs.jobs import scratch
from proofs.meeting import touching
from proofs.meeting.overlap import check
from proofs.scenes import runs as scene_runs

#: Kinds of `--short`.
SHORT = ("rings", "seam", "mirror")


def main(words):
    """Run as many scenes as asked for; print what became of them."""
    parser = argparse.ArgumentParser(prog="scripts/faults surfaces")
    parser.add_argument("--runs", type=int, default=90)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--kind", choices=[*touching.KINDS], help="only scenes of this kind")
    parser.add_argument("--alone", action="store_true", help="on one rank, without comparisons")
    parser.add_argument("--short", action="store_true", help="few kinds of scenes")
    options = parser.parse_args(words)
    kinds = [options.kind] if options.kind else SHORT if options.short else [*touching.KINDS]
    scene_runs.prepare()
    said, began = Counter(), time.monotonic()
    with scratch("surfaces") as (folder, failures):
        for number in range(options.first, options.first + options.runs):
            kind = kinds[number % len(kinds)]
            rng, since = random.Random(f"{options.seed} {number} {kind}"), time.monotonic()
            case, where = touching.make(rng, kind), folder / str(number)
            where.mkdir()
            path = where / "case.yaml"
            path.write_text(json.dumps(case, indent=1))
            outcome, wrong = check(path)
            if not outcome.startswith("refused") and not options.alone:
                kind_of, more = scene_runs.compare(path, where / "runs", rng, 60, (3,))
                outcome, wrong = kind_of.kind, wrong + [f"{a}: {b}" for a, b in more]
            said[outcome] += 1
            seconds = time.monotonic() - since
            print(f"{number}: {kind}, {outcome}, {seconds:.1f} s" + "".join(
                f"\n  {line}" for line in wrong), flush=True)  # fmt: skip
            failures += [f"scene {number}, {kind}: {each}" for each in wrong]
            if not wrong:
                shutil.rmtree(where)
        print(f"{dict(said)} in {time.monotonic() - began:.0f} s")
    return 1 if failures else 0
