"""Random scenes: the same files on any ranks, stopped and resumed, and books that balance."""

import contextlib
import itertools
import json
import multiprocessing
import os
import random
import re
import shutil
import time
from collections import Counter

from proofs import bounds
from proofs.jobs import Job, differences, options_of, scratch
from proofs.scenes import books as scene_books
from proofs.scenes import runs as scene_runs
from proofs.scenes import shrink as scene_shrink
from proofs.scenes.features import FEATURES, SHAPES, make

import pgimp
from pgimp.errors import PgimpError

#: Scenes of one kind: what is compiled is the same.
GROUP = 20
#: Groups of `--short`, which have what tests/proofs/test_proofs.py lists.
SHORT = (210, 1291, 472)
#: One scene in this number is run by mpirun too.
MPIRUN = 25
#: A run that fails at a face.
_LOST = re.compile(r"of body '(\w+)' left the domain through (\S+)")


def main(words):
    """Run as many scenes as asked for; print what became of them, and the smallest that fail."""
    options = options_of(
        "scenes", words, 500, short="few kinds of scenes",
        first={"type": int, "default": 0, "help": "number of the first scene"},
        scene={"type": int, "help": "this one alone"},
        having={"metavar": "FEATURE", "action": "append", "help": "only kinds of scenes with it"},
        each={"type": int, "default": GROUP, "help": "scenes of a kind, with --having"},
        jobs={"type": int, "default": 1, "help": "groups at a time"},
        shrink={"type": float, "default": 300.0, "help": "seconds for a failing scene"},
        bounds="check indices in kernels",
    )  # fmt: skip
    if options.bounds:  # for the processes that run the scenes
        os.environ[bounds.VARIABLE] = "1"
    numbers = range(options.first, options.first + options.runs)
    if options.scene is not None:
        numbers = [options.scene]
    elif options.short:
        each = -(-options.runs // len(SHORT))
        numbers = [GROUP * group + n for group in SHORT for n in range(each)][: options.runs]
    elif options.having:
        numbers = [*itertools.islice(having(options), options.runs)]
    groups = {}
    for number in numbers:
        groups.setdefault(number // GROUP, []).append(number)
    began = time.monotonic()
    with scratch("scenes") as (folder, failures):
        waiting, running = list(groups.values()), []
        context = multiprocessing.get_context("spawn")
        while waiting or running:
            while waiting and len(running) < options.jobs:
                process = context.Process(target=work, args=(folder, waiting.pop(0), options))
                process.start()
                running.append(process)
            running[0].join(0.2)
            running = [process for process in running if process.is_alive()]
        results = read(folder, numbers)
        report(results, options, time.monotonic() - began)
        failures += [f"scene {each['number']}: {what}" for each in results
                     for what, _ in each["failures"]]  # fmt: skip
    return 1 if failures else 0


def having(options):
    """Numbers of scenes of the kinds that have some features, or a shape, without end."""
    known, wanted = [feature.name for feature in FEATURES] + [*SHAPES], {*options.having}
    if not wanted <= {*known}:
        raise SystemExit(f"scripts/faults scenes: --having is one of {', '.join(known)}")
    for group in itertools.count(options.first // GROUP):
        case, _, names = make(options.seed, GROUP * group, group)
        if wanted <= {*names, case["method"]["shape"]}:
            scenes = range(GROUP * group, GROUP * (group + 1))
            found = (n for n in scenes if _meets(options, n) or "contact" not in wanted)
            yield from itertools.islice(found, options.each)


def _meets(options, number):
    """Whether a scene has contact: its feature adds nothing to a body alone."""
    return "contact" in make(options.seed, number, number // GROUP)[0]


def read(folder, numbers):
    """What is known of each scene; of those whose process died, that."""
    results = []
    for number in numbers:
        path = folder / f"{number}.json"
        died = {"number": number, "outcome": "died", "said": "", "features": [], "dimensions": 0,
                "failures": [("the process died", "")], "seconds": 0.0}  # fmt: skip
        results.append(json.loads(path.read_text()) if path.exists() else died)
    return results


def report(results, options, seconds):
    print(f"{len(results)} scenes, seed {options.seed}, in {seconds:.0f} s:")
    outcomes = Counter(each["outcome"] for each in results)
    print(f"  on one rank: {', '.join(f'{n} {what}' for what, n in outcomes.most_common())}")
    spaces = Counter(f"{each['dimensions']}D" for each in results)
    print(f"  {', '.join(f'{n} in {what}' for what, n in spaces.most_common())}")
    words = Counter(re.sub(r"[\d.e+-]+|'\w+'", "..", each["said"].split("\n")[0])
                    for each in results if each["outcome"] != "done")  # fmt: skip
    for text, count in words.most_common(12):
        print(f"    {count}: {text[:110]}")
    wrong = Counter(what for each in results for what, _ in each["failures"])
    print(f"  wrong: {sum(bool(each['failures']) for each in results)}")
    for what, count in wrong.most_common():
        which = [each for each in results if what in dict(each["failures"])]
        print(f"\n{what}: {count} scenes, {', '.join(str(each['number']) for each in which[:20])}")
        print(f"  {dict(which[0]['failures'])[what][:1500]}")
        for each in which:
            if text := each.get("smallest", {}).get(what):
                print(text)
                break


def work(folder, numbers, options):
    """Run scenes of one group in a process of its own."""
    scene_runs.prepare()
    for number in numbers:
        began, where = time.monotonic(), folder / str(number)
        case, files, features = make(options.seed, number, number // GROUP)
        outcome, failures = examine(case, files, where, number)
        smallest = {}
        for what, _ in failures:
            # One of each class is made smaller.
            with contextlib.suppress(FileExistsError):
                (folder / f"seen {re.sub('[^a-z]+', ' ', what.lower())}").touch(exist_ok=False)
                smallest[what] = smaller(case, files, where, number, what, options)
        plain = not (failures or options.short or options.bounds)
        if number % MPIRUN == 7 and outcome.kind == "done" and plain:
            failures += by_mpirun(where, number)
        if not failures:
            shutil.rmtree(where)
        result = {"number": number, "outcome": outcome.kind, "said": outcome.said,
                  "dimensions": case["dimensions"], "features": features, "failures": failures,
                  "smallest": smallest, "seconds": time.monotonic() - began}  # fmt: skip
        temporary = folder / f"{number}.part"
        temporary.write_text(json.dumps(result))
        temporary.rename(folder / f"{number}.json")


def by_mpirun(where, number):
    """What is wrong with a scene on real ranks."""
    ranks = 2 + number // MPIRUN % 4
    words = ["--import", scene_runs.SOFTENING, "--import", scene_runs.FUNCTIONS]
    words += ["case.yaml", "--quiet", "-o"]
    wrong: list[str] = []
    # Where steps are held for less long than usual, see `scene_runs.prepare`, a plain run decides.
    for name, count in ("mpirun", ranks), ("plain", 1):
        job = Job(count, [*words, f"runs/{name}"], where)
        status, _ = job.wait(300.0)
        if status != 0:
            return [("mpirun", f"status {status} on {count} ranks: {job.said}")]
        beside = "1" if name == "mpirun" else name
        wrong = differences(where / "runs" / beside, where / "runs/mpirun", scene_runs.SAME)
        if not wrong:
            break
    return [("bits under mpirun", f"on {ranks} ranks: {', '.join(wrong)}")] if wrong else []


def smaller(case, files, where, number, what, options):
    """The text of a case that is as small as can be and fails in the same way."""

    def fails(other):
        *_, failures = examine(other, files, where / "smaller", number, what)
        return what in dict(failures)

    if options.shrink > 0.0:
        case = scene_shrink.shrink(case, fails, options.shrink)
    used = {name: text for name, text in files.items() if name in json.dumps(case)}
    shown = f"# {what}\n# scripts/faults scenes --seed {options.seed} --scene {number}\n"
    shown += "".join(f"{key}: {json.dumps(value)}\n" for key, value in case.items() if value != {})
    (where / "smallest.yaml").write_text(shown)
    shown += "".join(f"# {name}:\n{text}" for name, text in used.items() if len(text) < 1500)
    return shown


def examine(case, files, where, number, what=""):
    """How a case ends on one rank, and classes and descriptions of what is wrong with it.

    It is run in all ways, and its books are kept; `what` names the only failure of interest.
    """
    shutil.rmtree(where, ignore_errors=True)
    where.mkdir(parents=True)
    for name, text in files.items():
        (where / name).write_text(text)
    path = where / "case.yaml"
    path.write_text(json.dumps(case, indent=1))
    try:
        pgimp.load(path)
    except PgimpError as error:
        return scene_runs.Outcome("refused", str(error)), []
    failures = []
    outcome = scene_runs.Outcome("done")
    books = what.startswith("books")
    if not books:
        step = case["time"]["step"]
        parts = [case["time"], *case["time"].get("stages", [])]
        end = [part["end"] for part in parts if "end" in part][-1]
        steps = 40 if isinstance(step, dict) else round(end / step)
        rng = random.Random(f"ways {number}")
        outcome, failures = scene_runs.compare(path, where / "runs", rng, max(steps, 1))
        lost = _LOST.search(outcome.said)
        if lost and _holds(case, *lost.groups()):
            failures.append(("lost at a wall", outcome.said))
    if outcome.kind != "refused" and (books or not what):
        with contextlib.suppress(PgimpError):
            failures += scene_books.check(lambda more: pgimp.load(path, more)).wrong
    return outcome, failures


def _holds(case, body, face):
    """Whether a face lets nothing of a body out.

    One that is free across, or moves outwards, may; and constraints move particles through it.
    """
    if (
        case["bodies"][body].get("formulation") == "total-lagrangian"
    ):  # a wall holds what lies on it
        return False
    if any(each["body"] == body for each in case.get("constraints", {}).values()):
        return False
    entry = case.get("boundaries", {}).get(face)
    if "absorbing" in (entry or ""):
        return False
    if not isinstance(entry, dict):
        return entry is not None
    across = entry["velocity"]["xyz".index(face[0])]
    outwards = -1.0 if face.endswith("min") else 1.0
    return isinstance(across, int | float) and across * outwards <= 0.0
