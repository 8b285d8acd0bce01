"""Millions of steps: constant memory, mass exact to the bit, drift of momentum and energy."""

import time
from pathlib import Path

import numpy as np
from proofs.jobs import Job, options_of, scratch

import pgimp

#: A bar that hangs and swings for ever: 8 particles.
TINY = """\
format: 1
title: A bar that swings under its weight
dimensions: 1
grid: {origin: [-8.0], size: [9.0], cell: [1.0]}
method: {shape: gimp, particles-per-cell: [2]}
time: {end: END, step: 0.01}
materials:
  bar: {model: linear-1d, young: 100.0, density: 1.0}
bodies:
  bar: {material: bar, region: {box: {min: [-3.0], max: [1.0]}}}
gravity: [-0.5]
boundaries: {x-max: fixed}
history: {every: {steps: LINE}}
checkpoint: {every: {wall-time: 20}, keep: 2}
"""
#: A block that spins freely: 256 particles.
SMALL = """\
format: 1
title: A block that spins freely
dimensions: 2
grid: {origin: [-8.0, -8.0], size: [16.0, 16.0], cell: [1.0, 1.0]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: END, step: 0.01}
materials:
  soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}
bodies:
  block:
    material: soft
    region: {box: {min: [-4.0, -4.0], max: [4.0, 4.0]}}
    velocity: {rotation: {about: [0.0, 0.0], rate: 0.2}}
history: {every: {steps: LINE}}
checkpoint: {every: {wall-time: 20}, keep: 2}
"""
_LINES = 200
#: Growth of the memory from the first tenth of a run to its end, in MB, that still counts as
#: constant: pages of the allocator, not something a step or a line leaves.
_GROWTH = 2.0


def main(words):
    """Run both scenes; print what stayed the same and what drifted."""
    part = 100 if options_of("long", words, quick="a hundredth of the steps").quick else 1
    with scratch("long") as (folder, failures):
        failures += one(folder, "tiny", TINY, 10_000_000 // part)
        failures += one(folder, "small", SMALL, 200_000 // part)
    return 1 if failures else 0


def one(folder, name, case, steps):
    """Run a scene and return what is wrong."""
    text = case.replace("END", repr(steps * 0.01)).replace("LINE", str(steps // _LINES))
    (folder / f"{name}.yaml").write_text(text)
    began = time.monotonic()
    job = Job(1, [f"{name}.yaml", "--quiet"], folder)
    samples = []
    while job.running:
        time.sleep(0.1)
        samples.append((lines(folder / f"{name}.out"), resident(job.process.pid)))
    status, _ = job.wait()
    seconds = time.monotonic() - began
    if status != 0:
        return [f"{name}: status {status}: {job.said}"]
    history = pgimp.open(folder / f"{name}.out").history
    # From the first tenth on: then all kinds of output and re-sorts have been met.
    steady = [memory for line, memory in samples if line > _LINES // 10 and memory]
    growth = steady[-1] - steady[0]
    mass = np.unique(history["mass"])
    time_, drift = history["time"], []
    axes = [n.removeprefix("momentum-") for n in history.dtype.names if n.startswith("momentum-")]
    for axis in axes:
        momentum = history[f"momentum-{axis}"]
        given = np.zeros_like(momentum)
        for column in history.dtype.names:
            if column.startswith("reaction.") and column.endswith(f"-{axis}"):
                given[1:] += np.cumsum(history[column][1:] * np.diff(time_))
        if name == "tiny":
            given += -0.5 * mass[0] * time_
        drift.append(np.abs(momentum - momentum[0] - given).max())
    # What the weight has given, or, where nothing gives, what the motion has.
    moving = np.sqrt(2.0 * mass[0] * history["kinetic-energy"].max())
    scale = max(moving, 0.5 * mass[0] * time_[-1] if name == "tiny" else 0.0)
    energy = history["kinetic-energy"] + history["strain-energy"]
    moved = energy.max() if name == "small" else history["strain-energy"].max()
    lost = history["dissipated-energy"] / moved
    print(f"{name}: {steps} steps in {seconds:.0f} s, {len(history)} lines of history")
    print(f"  memory: {steady[0]:.1f} MB after a tenth, {steady[-1]:.1f} MB at the end")
    print(f"  mass: {len(mass)} value(s) of all lines, {float(mass[0])!r}")
    of = "what the weight gave" if name == "tiny" else "sqrt(2 m E), E the greatest kinetic energy"
    worst = max(drift) / scale
    print(f"  momentum: what neither faces nor weight gave is at most {worst:.1e} of {of}")
    print(f"  energy lost: {lost[len(lost) // 10]:.2e} after a tenth, {lost[-1]:.2e} at the end")
    if "angular-momentum-z" in history.dtype.names:
        spin = history["angular-momentum-z"]
        print(f"  angular momentum: {abs(spin[-1] / spin[0] - 1.0):.1e} lost at the end")
    wrong = []
    if growth > _GROWTH:
        wrong.append(f"{name}: the memory grew by {growth:.1f} MB")
    if len(mass) != 1:
        wrong.append(f"{name}: the mass had {len(mass)} values")
    return wrong


def lines(directory):
    try:
        return (directory / "history.csv").read_bytes().count(b"\n")
    except FileNotFoundError:
        return 0


def resident(pid):
    """Anonymous memory of a process in MB, without pages of libraries; 0 when it has gone."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    kilobytes = [line.split()[1] for line in status.splitlines() if line.startswith("RssAnon")]
    return int(kilobytes[0]) * 1024 / 1e6 if kilobytes else 0.0
