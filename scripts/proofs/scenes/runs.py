"""Runs of a scene on ranks whose slab boundaries move, stopped and resumed; and what they leave."""

import contextlib
import re
import shutil
import traceback
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from proofs.jobs import differences
from proofs.scenes import anew, thread_ranks
from proofs.scenes.thread_messages import DesertedError

from pgimp.errors import CaseError, PgimpError

#: The material with a memory that some scenes have.
SOFTENING = Path(__file__).parents[3] / "cases/softening.py"
#: Functions of one's own.
FUNCTIONS = Path(__file__).with_name("own") / "random_functions.py"
#: Steps between two moves of slab boundaries.
EVERY = 4
#: A run with more steps to go is ended: a scene has some 60, or 200 where pgimp chooses them. What
#: is crushed between a tool and a wall may need thousands, each shorter, until pgimp calls that
#: blown up; and every scene is run about seven times.
MOST_STEPS = 3000
#: What a run leaves that no number of ranks may change.
SAME = (
    "case.yaml", "history.csv", "*.xdmf", "*.vtkhdf", "frames/*", "probes/*",
    "failure/particles.h5",
)  # fmt: skip


class Outcome(NamedTuple):
    """How a run ended, and its error.

    It is ``done``, ``stopped``, ``refused``, ``failed``: with an error of pgimp's that all ranks
    raise alike; ``torn``: with different ones; ``crashed``: with another error.
    """

    kind: str
    said: str = ""


def prepare():
    """Let runs be as they are on large machines: messages in pieces, boundaries that move.

    And as long ones are: with looks at the energy, and steps that lengthen.
    """
    thread_ranks.prepare()
    anew.prepare()
    from pgimp.physics.materials.registry import import_file

    import_file(str(SOFTENING))
    import_file(str(FUNCTIONS))
    from pgimp.commands import run
    from pgimp.decomposition import halo, migrate, redistribute
    from pgimp.decomposition.balance import Balance
    from pgimp.jit.bound import Bound
    from pgimp.running import running
    from pgimp.solver import simulation
    from pgimp.solver.reduction import Request
    from pgimp.solver.time import clock, held_rate

    Bound.__call__ = _checked
    run.abort_on_error = lambda comm: contextlib.nullcontext()
    redistribute._PIECE, halo.PIECE, migrate.CAPACITY = 200, 5, 2
    simulation.EVERY = 7
    held_rate.FIRST, held_rate.LONGEST = 4, 32
    clock.MOST_STEPS = clock.BLOWN_UP_STEPS = MOST_STEPS
    usual = running._request

    def request(sim, *others):
        at, last = sim.comm.stop_at, sim.comm.rank == sim.comm.size - 1
        return Request.STOP if at is not None and last and sim.step >= at else usual(sim, *others)

    running._request = request
    Balance.note, Balance.decide = _ask, _anywhere
    Balance.moved = lambda balance, seconds, step: None


def _checked(bound, kernel, *args):
    """Call a kernel only with the types of its first call; see `Bound`."""
    from numba import typeof

    types = tuple(typeof(arg) for arg in args)
    known = bound._entries.setdefault(kernel, types)
    if types != known:
        raise TypeError(f"{kernel.__name__} is called with {types} after {known}")
    return kernel(*args)


def _ask(balance, worked, count, step):
    balance._taken += 1
    balance.rebalance_requested = balance.on and step % EVERY == 0


def _anywhere(balance, counts, step):
    """Random allowed boundaries that depend on the step only."""
    layers, width, active = len(counts), balance._vertices - 1, len(balance.cuts) - 1
    ends = max(width, balance._ends)
    least = ends + width * np.arange(active - 1)
    slack = layers - ends - int(least[-1])
    extra = np.sort(np.random.default_rng(step).integers(0, slack + 1, active - 1))
    return [0, *(int(n) for n in least + extra), layers]


def run(case, folder, ranks, resume=False, stop_at=None, anew=False):
    """Outcome of a run of a case file into a folder, or with `resume` from where it stopped.

    After the step `stop_at` the last rank asks to stop. With `anew` contact keeps nothing.
    """
    import pgimp

    def task(comm):
        comm.stop_at, comm.anew = stop_at, anew
        return pgimp.run(case, comm, folder, resume=resume, overwrite=not resume, quiet=True)

    results = thread_ranks.together(ranks, task)
    errors = [each for each in results if isinstance(each, BaseException)]
    if not errors:
        return Outcome(str(results[0].info["state"]))
    first = [each for each in errors if not isinstance(each, DesertedError)][:1]
    worst = [each for each in errors if not isinstance(each, PgimpError)]
    worst = [each for each in worst if not isinstance(each, DesertedError)][:1]
    if worst:
        return Outcome("crashed", "".join(traceback.format_exception(worst[0])))
    if len({str(each) for each in results}) > 1:
        who = ", ".join(str(n) for n, each in enumerate(results) if each in first)
        return Outcome("torn", f"rank {who} of {ranks}: {(first or errors)[0]}")
    kind = "refused" if isinstance(errors[0], CaseError) else "failed"
    # What failed, and in which step; on which rank, and what was kept, differ from run to run.
    lines = re.sub(r", on rank \d+", "", str(errors[0])).split("\n")
    return Outcome(kind, "\n".join(lines[:2]))


def other_state(one, other):
    """Data in which the last checkpoints of two runs differ, if they are of the same step."""
    paths = [max((run / "checkpoints").glob("*.h5"), default=None) for run in (one, other)]
    if None in paths or paths[0].name != paths[1].name:
        return []
    with h5py.File(paths[0]) as mine, h5py.File(paths[1]) as theirs:
        return [
            f"checkpoints/{name}" for name in sorted({*mine} | {*theirs})
            if (name in mine) != (name in theirs) or mine[name].dtype != theirs[name].dtype
            or mine[name][()].tobytes() != theirs[name][()].tobytes()
        ]  # fmt: skip


def go_back(folder):
    """Delete all checkpoints but the oldest, as if the run had been killed after that."""
    checkpoints = sorted((folder / "checkpoints").glob("*.h5"))
    for path in checkpoints[1:]:
        path.unlink()
    info = folder / "run.json"
    info.write_text(info.read_text().replace('"state": "done"', '"state": "running"'))
    return len(checkpoints)


def compare(case, folder, rng, steps, ranks=(2, 3)):
    """Run a case in many ways, all of which must leave the same files.

    On one rank, on `ranks` and on 5 to 9; `rng` chooses these and the steps, of some `steps`, after
    which runs stop. Returns the outcome on one rank, and class and description of what is wrong.
    """
    alone = folder / "1"
    outcome = run(case, alone, 1)
    if outcome.kind == "crashed":
        return outcome, [(f"crash: {outcome.said.strip().splitlines()[-1][:70]}", outcome.said)]
    if outcome.kind == "refused":
        return outcome, []
    failures = []

    def check(where, name, found):
        if found.kind == "crashed":
            line = found.said.strip().splitlines()[-1][:70]
            failures.append((f"crash on ranks: {line}", f"{name}: {found.said}"))
        elif found != outcome:
            text = f"{name}: {found.kind} {found.said}; on one rank {outcome.kind} {outcome.said}"
            failures.append((f"ended otherwise: {found.kind}", text))
        elif wrong := differences(alone, where, SAME) + other_state(alone, where):
            kinds = sorted({Path(each).parts[0] for each in wrong})
            failures.append((f"bits: {', '.join(kinds)}", f"{name}: {', '.join(wrong)}"))

    if any(f'"{key}"' in case.read_text() for key in ("contact", "rigid", "unilateral")):
        where = folder / "anew"
        check(where, "with contact made anew in each step", run(case, where, 1, anew=True))
        shutil.rmtree(where, ignore_errors=True)
        if failures:
            return outcome, failures
    for count in (*ranks, rng.randint(5, 9)):
        where, other = folder / f"{count}", rng.choice((1, 2, 3, 4, rng.randint(5, 9)))
        stop = rng.randint(1, steps) if rng.random() < 0.6 else None
        name, found = f"on {count} ranks", run(case, where, count, stop_at=stop)
        if found.kind == "stopped":
            name += f", stopped after step {stop}, resumed on {other}"
            found = run(case, where, other, resume=True)
        check(where, name, found)
        if found.kind == "done" and not failures and rng.random() < 0.7:
            if go_back(where):
                other = rng.choice((1, 2, 3, 4, rng.randint(5, 9)))
                name += f"; from the oldest checkpoint on {other}"
                check(where, name, run(case, where, other, resume=True))
        shutil.rmtree(where, ignore_errors=True)
        if failures:
            break
    return outcome, failures
