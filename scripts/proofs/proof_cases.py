"""Mutated cases: each is run, or refused with a few of pgimp's own words; none does harm."""

import os
import random
import shutil
import subprocess
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

from proofs import forks
from proofs.jobs import environment, options_of, scratch
from proofs.mutation.harmful import TRACE
from proofs.mutation.mutants import KINDS, Mutator

#: One mutant in this number is run in a process of its own, and by two ranks under mpirun.
ALONE, RANKS = 25, 40
#: How pgimp is told to handle it: the words before and after the name of the file.
WAYS = {"run": ([], ["-o", "out"]), "check": (["check"], []), "study": (["study"], ["--list"])}


def main(words):
    """Make as many mutants as asked for; print what became of them."""
    only = {"choices": KINDS, "help": "one kind of mutation"}
    early = "good cases stop before they start"
    options = options_of("cases", words, 1000, only=only, short=early)
    began = time.monotonic()
    outcomes, slowest, largest = defaultdict(Counter), {}, (0.0, "")
    with scratch("cases") as (folder, failures):
        with ProcessPoolExecutor(os.cpu_count(), get_context("spawn"), forks.prepare) as pool:
            waiting = {
                pool.submit(one, number, options, folder / f"{number}"): number
                for number in range(options.runs)
            }
            for done in as_completed(waiting):
                name, kind, way, outcome, wrong, result = done.result()
                outcomes[f"{kind}"][outcome] += 1
                outcomes[f"by {way}"][outcome] += 1
                slow = (result.seconds, f"{name}, {kind}, {way}")
                slowest[outcome] = max(slowest.get(outcome, (0.0, "")), slow)
                largest = max(largest, (result.megabytes, f"{name}, {kind}, {way}"))
                failures += [f"{name}, {kind}, {way}: {text}" for text in wrong]
        print(f"{options.runs} mutants of cases, seed {options.seed}:")
        every = Counter()
        for kind, counts in sorted(outcomes.items()):
            every += counts if not kind.startswith("by ") else Counter()
            print(f"  {kind:<12} {', '.join(f'{n} {what}' for what, n in counts.most_common())}")
        print(f"  in all: {', '.join(f'{n} {what}' for what, n in every.most_common())}")
        for outcome, (seconds, which) in sorted(slowest.items()):
            print(f"  slowest {outcome}: {seconds:.1f} s ({which})")
        print(f"  all of them: {time.monotonic() - began:.0f} s")
        print(f"  most memory: {largest[0]:.0f} MB ({largest[1]})")
        print(f"  wrong: {len(failures)}")
    return 1 if failures else 0


def one(number, options, folder):
    """Make a mutant and let pgimp have it."""
    chance = random.Random(f"{options.seed} {number}")
    kind = options.only or KINDS[number % len(KINDS)]
    content, words = Mutator(chance).make(kind)
    way = "study" if kind == "study" else chance.choice(("run", "run", "run", "check"))
    folder.mkdir()
    (folder / "mutant.yaml").write_bytes(content)
    (folder / "words").write_text(repr(words))
    before, after = WAYS[way]
    words = [*before, "mutant.yaml", *after, *words]
    if way == "run" and number % RANKS == 1 and not options.short:
        way, result = "mpirun", process(words, folder, ranks=2)
    elif number % ALONE == 2 and not options.short:
        way, result = f"{way} alone", process(words, folder)
    else:
        result = forks.run(words, folder, stop_early if options.short else None)
    outcome = name_of(result)
    wrong = [text] if (text := forks.complaint(result, (1, 2))) else []
    if result.status == 1 and not outcome.startswith("stopped") and not wrong:
        wrong.append(f"status 1: {result.said[:300]}")
    if result.status == 2 and (folder / "out").exists():
        wrong.append("it left a run directory")
    if (folder / TRACE).exists():
        wrong.append("something in it was executed")
    if not wrong:
        shutil.rmtree(folder)
    return number, kind, way, outcome, wrong, result


def stop_early():
    """Let a good case end before anything is compiled."""
    from pgimp.solver import setup

    def good(*_):
        os._exit(0)

    setup.warm_up = good


def name_of(result):
    """Describe how a command ended."""
    if result.status == 0:
        return "good"
    if result.status == 2:
        return "too large" if "this case is too large" in result.said else "refused"
    if result.status == 1 and (" step " in result.said or "particle" in result.said):
        return "stopped while running"
    return "hung" if result.status is None else f"status {result.status}"


def process(words, folder, ranks=1):
    """Give words to pgimp in a process of its own, or under mpirun; a few steps at most."""
    program = [
        sys.executable,
        "-c",
        f"import sys; sys.path.insert(0, {str(forks.SCRIPTS)!r}); "
        "from proofs import forks; forks.shorten(); from pgimp.cli import main; sys.exit(main())",
        *words,
    ]
    if ranks > 1:
        program = ["mpirun", "-q", "--oversubscribe", "--bind-to", "none", "-n", "2", *program]
    began = time.monotonic()
    with open(folder / "stderr", "w+", errors="replace") as said:
        try:
            status = subprocess.run(
                program, cwd=folder, env=environment() | {"PYTHONIOENCODING": "ascii"},
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=said,
                timeout=forks.PATIENCE,
            ).returncode  # fmt: skip
        except subprocess.TimeoutExpired:
            status = None
        said.seek(0)
        return forks.Result(status, said.read(), time.monotonic() - began, 0.0)
