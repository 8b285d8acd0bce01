"""A rank killed -9 at a random moment, then --resume on other ranks: the same bits, every time."""

import argparse
import os
import random
import signal
import time
from collections import Counter
from statistics import median

from proofs.jobs import CASE, MEET, SHORT, Job, come_to, differences, scratch, unreadable, whole


def main(words):
    """Kill as many runs as asked for; print what became of them."""
    parser = argparse.ArgumentParser(prog="scripts/faults kill")
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tcp", action="store_true")
    parser.add_argument("--short", action="store_true", help="fewer steps, at most 3 ranks")
    parser.add_argument("--contact", action="store_true", help="bodies that meet, up to 7 ranks")
    options = parser.parse_args(words)
    chance = random.Random(options.seed)
    moments, statuses, resumed, delays, same = Counter(), Counter(), Counter(), [], 0
    with scratch("kill") as (folder, failures):
        (folder / "blocks.yaml").write_text(
            SHORT if options.short else MEET if options.contact else CASE
        )
        began = time.monotonic()
        reference = whole(folder, "whole", ["blocks.yaml", "--quiet"])
        # Compiled now; so this is how long a run takes.
        again = time.monotonic()
        whole(folder, "again", ["blocks.yaml", "--quiet"], 2, options.tcp)
        length = time.monotonic() - again
        print(f"an undisturbed run takes {length:.1f} s, with compilation {again - began:.1f} s")
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
            job = Job(others, ["blocks.yaml", "-o", name, "--resume"], folder, options.tcp)
            status, _ = job.wait()
            lines = job.said.splitlines()
            at = [line for line in lines if line.startswith(("resuming", "no checkpoint"))]
            resumed["from a checkpoint" if at and "resuming" in at[0] else "afresh"] += 1
            wrong = differences(reference.path, folder / name) if status == 0 else []
            if status != 0 or wrong:
                failures.append(
                    f"{note}, resumed on {others}: status {status}, {wrong}, {lines[-5:]}"
                )
            else:
                same += 1
        report(options, moments, statuses, resumed, delays, same)
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


def report(options, moments, statuses, resumed, delays, same):
    """Print the figures."""
    by = ", by TCP" if options.tcp else ""
    most = 7 if options.contact else 4
    print(f"{options.runs} runs on 2 to {most} ranks{by}, one killed -9, resumed on 1 to {most}:")
    print(f"  same bits as the undisturbed run: {same} of {options.runs}")
    print("  killed: " + ", ".join(f"{count} {what}" for what, count in moments.most_common()))
    print(f"  resumed: {dict(resumed)}; status of the killed jobs: {dict(statuses)}")
    spread = f"median {median(delays):.1f} s, most {max(delays):.1f} s"
    print(f"  from the kill to the end of the job: {spread}")
