"""A rank killed -9 at a random moment, then --resume on other ranks: the same bits, every time."""

import os
import random
import signal
import time
from collections import Counter
from statistics import median

from proofs.jobs import Job, come_to, disturbed, resumed, scratch, undisturbed, unreadable


def main(words):
    """Kill as many runs as asked for; print what became of them."""
    options = disturbed("kill", words, 100)
    chance = random.Random(options.seed)
    moments, statuses, begun, delays, same = Counter(), Counter(), Counter(), [], 0
    with scratch("kill") as (folder, failures):
        reference, length = undisturbed(folder, options)
        number = -1
        while sum(moments.values()) < options.runs:
            number += 1
            name = f"run-{number}"
            ranks = chance.choice((2, 2, 3, 3 if options.short else 7 if options.contact else 4))
            job = Job(ranks, ["blocks.yaml", "--quiet", "-o", name], folder, options.tcp)
            # A kind until it has come off: one that came too late is tried again.
            kind = ("start-up", "checkpoint", "any")[sum(moments.values()) % 3]
            wait_for(kind, job, folder / name, chance, length, len(reference))
            alive = job.ranks()
            if not (job.running and alive):  # it was done before, or not even started
                job.wait()
                continue
            os.kill(chance.choice(alive), signal.SIGKILL)
            status, seconds = job.wait()
            if status == 0:  # killed when all was done
                continue
            delays.append(seconds)
            moment = stage(folder / name)
            moments[moment] += 1
            statuses[status] += 1
            note = f"{name}, {ranks} ranks, killed: {moment}"
            if status is None:
                failures.append(f"{note}: hung")
                continue
            if "Killed" not in job.said and "signal 9" not in job.said:
                failures.append(f"{note}: no message, but {job.said!r}")
            if "Traceback" in job.said:
                failures.append(f"{note}: {job.said}")
            if (folder / name).exists():
                failures += [f"{note}: {wrong}" for wrong in unreadable(folder / name)]
            others = chance.choice((1, 2, 3, 3 if options.short else 7 if options.contact else 4))
            lines, wrong = resumed(name, others, folder, options, reference)
            at = [line for line in lines if line.startswith(("resuming", "no checkpoint"))]
            begun["from a checkpoint" if at and "resuming" in at[0] else "afresh"] += 1
            failures += [note + wrong] * bool(wrong)
            same += not wrong
        report(options, moments, statuses, begun, delays, same)
    return 1 if failures else 0


def wait_for(kind, job, directory, chance, length, frames):
    """Wait for a random moment of a kind, by what the run has written, not by how fast it is."""
    if kind == "start-up":
        end = time.monotonic() + chance.uniform(0.0, 0.45 * length)
        while job.running and time.monotonic() < end and not (directory / "frames").exists():
            time.sleep(0.001)
    elif kind == "any":
        come_to(chance.randint(1, frames - 1), job, directory)
        time.sleep(chance.uniform(0.0, 0.1 * length))
    else:
        come_to(chance.randint(1, frames - 2), job, directory)
        while job.running and not list(directory.glob("checkpoints/.*.part")):
            time.sleep(0.0005)
        time.sleep(chance.uniform(0.0, 0.004))


def stage(directory):
    """How far a killed run had come, judged by its files."""
    if not (directory / "frames").exists():
        return "start-up"
    if list(directory.glob("checkpoints/.*.part")):
        return "within a checkpoint"
    if list(directory.glob("frames/.*.part")):
        return "within a frame"
    if list(directory.glob("checkpoints/step*")):
        return "in between, with checkpoints"
    return "in between, no checkpoint yet"


def report(options, moments, statuses, begun, delays, same):
    by = ", by TCP" if options.tcp else ""
    most = 7 if options.contact else 4
    print(f"{options.runs} runs on 2 to {most} ranks{by}, one killed -9, resumed on 1 to {most}:")
    print(f"  same bits as the undisturbed run: {same} of {options.runs}")
    print("  killed: " + ", ".join(f"{count} {what}" for what, count in moments.most_common()))
    print(f"  resumed: {dict(begun)}; status of the killed jobs: {dict(statuses)}")
    spread = f"median {median(delays):.1f} s, most {max(delays):.1f} s"
    print(f"  from the kill to the end of the job: {spread}")
