"""Signals to mpirun and to ranks at random moments: status, checkpoint, the same bits after it."""

import os
import random
import signal
import time
from collections import Counter

from proofs.jobs import Job, come_to, disturbed, resumed, scratch, undisturbed, unreadable

from pgimp.running.checkpoints import present

#: Signal and addressee, and whether the run can stop in its own time.
KINDS = [
    (signal.SIGUSR1, "mpirun", True), (signal.SIGUSR1, "a rank", True),
    (signal.SIGTERM, "a rank", True), (signal.SIGINT, "a rank", True),
    (signal.SIGTERM, "mpirun", False), (signal.SIGINT, "mpirun", False),
]  # fmt: skip
#: pgimp with checkpoints that take seconds before they get their name.
SLOW = """\
import sys, time
from pgimp import signals
signals.install()
from pgimp.storage.framefile import FrameFile
close = FrameFile.close
def slow(self):
    if "step-" in self.path.name:
        time.sleep(4.0)
    return close(self)
FrameFile.close = slow
from pgimp.cli import main
sys.exit(main())
"""


def main(words):
    """Send as many signals as asked for; print what became of the runs."""
    options = disturbed("signals", words, 60)
    chance = random.Random(options.seed)
    with scratch("signals") as (folder, failures):
        (folder / "slow.py").write_text(SLOW)
        reference, length = undisturbed(folder, options)
        table, number = {kind: Counter() for kind in KINDS}, 0
        while (done := sum(sum(row.values()) for row in table.values())) < options.runs:
            # A kind until it has come off: one that came too late is tried again.
            kind = KINDS[done % len(KINDS)]
            # Of those who give the ranks two seconds, every second one meets a slow checkpoint.
            slow = not kind[2] and (options.short or done // len(KINDS) % 2 == 1)
            name = f"run-{number}"
            number += 1
            what = strike(name, kind, slow, chance, length, folder, options, failures, reference)
            if what:
                table[kind][what] += 1
        by = ", by TCP" if options.tcp else ""
        most = 7 if options.contact else 4
        print(f"{options.runs} signals at random moments, 2 to {most} ranks{by}; then --resume:")
        for (number, to, _), row in table.items():
            text = ", ".join(f"{count} {what}" for what, count in row.most_common())
            print(f"  {signal.Signals(number).name} to {to}: {text}")
    return 1 if failures else 0


def strike(name, kind, slow, chance, length, folder, options, failures, reference):
    """Let one run get a signal; return what became of it, empty if it came too late."""
    number, to, gentle = kind
    ranks = chance.choice((2, 3) if options.short else (2, 3, 7 if options.contact else 4))
    program = ("slow.py",) if slow else ("-m", "pgimp")
    job = Job(ranks, ["blocks.yaml", "--quiet", "-o", name], folder, options.tcp, program)
    note = f"{name}, {signal.Signals(number).name} to {to} on {ranks} ranks"
    if slow:
        while job.running and not list(folder.glob(f"{name}/checkpoints/.*.part")):
            time.sleep(0.005)
        time.sleep(chance.uniform(0.5, 1.5))
    elif chance.random() < 0.25:  # perhaps before a handler stands
        time.sleep(chance.uniform(0.05, 0.4) * length)
    else:
        come_to(chance.randint(1, len(reference) - 1), job, folder / name)
        time.sleep(chance.uniform(0.0, 0.1) * length)
    alive = job.ranks()
    if not (job.running and alive):
        job.wait()
        return ""
    os.kill(job.process.pid if to == "mpirun" else chance.choice(alive), number)
    status, seconds = job.wait()
    if status == 0:
        return ""
    directory, what = folder / name, f"status {status}"
    if status is None or "Traceback" in job.said:
        failures.append(f"{note}: status {status}: {job.said}")
        return "hung or with a traceback"
    if gentle and status != 75:
        if directory.exists() or status not in (128 + number, 1, 255):
            failures.append(f"{note}: status {status}: {job.said}")
        what = f"status {status} (before a handler stood)"
    if status == 75 and not present(directory / "checkpoints"):
        failures.append(f"{note}: status 75 without a checkpoint")
    if not gentle and seconds > 10.0:
        failures.append(f"{note}: {seconds:.1f} s to the end")
    if slow:
        what += ", within a checkpoint of 4 s"
    if directory.exists():
        failures += [f"{note}: {wrong}" for wrong in unreadable(directory)]
    others = chance.choice((1, 2, 3) if options.short else (1, 2, 3, 7 if options.contact else 4))
    _, wrong = resumed(name, others, folder, options, reference)
    if wrong:
        failures.append(note + wrong)
        return f"{what}, not the same bits"
    return f"{what}, same bits"
