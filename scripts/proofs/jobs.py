"""Runs under mpirun that are disturbed, and what must be true of all that they leave."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from proofs.scenes import heaps
from studies import harness

import pgimp
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.running.checkpoints import present

#: Two soft blocks collide in a box; some seconds, with frames and checkpoints all the time.
CASE = """\
format: 1
title: Two soft blocks
dimensions: 2
grid: {origin: [0.0, 0.0], size: [24.0, 8.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 2.0, step: 0.01}
materials:
  soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}
bodies:
  left: {material: soft, region: {box: {min: [1.0, 1.0], max: [9.0, 7.0]}}, velocity: [2.0, 0.0]}
  right: {material: soft, region: {box: {min: [12.0, 1.0], max: [20.0, 7.0]}}, velocity: [-1, 0]}
boundaries: {x-min: fixed, x-max: fixed, y-min: slip, y-max: slip}
output: {every: {steps: 37}}
history: {every: {steps: 10}}
checkpoint: {every: {steps: 25}, keep: 3}
"""
SHORT = CASE.replace("end: 2.0", "end: 1.2")
#: Blocks with friction on a rough floor, a rigid body that pushes them, and one that moves freely.
#: They come from afar, so that velocity fields and the slabs' boundaries change on the way.
MEET = """\
format: 1
title: Blocks, a tool and a stone
dimensions: 2
grid: {origin: [0.0, 0.0], size: [28.0, 8.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 3.0, step: 0.01}
materials:
  soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}
bodies:
  left: {material: soft, region: {box: {min: [4.0, 0.0], max: [9.0, 3.0]}}, velocity: [2.0, 0.0]}
  right: {material: soft, region: {box: {min: [12.0, 0.0], max: [18.0, 4.0]}}}
  tool: {rigid: {velocity: [2.5, 0.0]}, region: {box: {min: [1.0, -1.0], max: [3.0, 5.0]}}}
  stone:
    rigid: {density: 2.0}
    region: {ball: {centre: [16.0, 6.0], radius: 1.2}}
    velocity: {rotation: {about: [16.0, 6.0], rate: 1.0}, translation: [1.0, -1.0]}
gravity: [0.0, -1.0]
boundaries: {x-min: fixed, x-max: fixed, y-min: {unilateral: {friction: 0.4}}}
contact:
  - {bodies: all, friction: 0.3}
output: {every: {steps: 37}, grid: [contact]}
history: {every: {steps: 10}}
checkpoint: {every: {steps: 25}, keep: 3}
"""
#: Bodies that meet by surfaces across a seam, with frames of these; balls that rebound; a stage.
SURFACES = """\
format: 1
title: Blocks and balls across a seam
dimensions: 2
grid: {origin: [0.0, 0.0], size: [24.0, 10.0], cell: [0.5, 0.5]}
method: {shape: gimp, particles-per-cell: [2, 2]}
time: {end: 1.2, step: 0.01, stages: [{name: later, end: 2.4, remove: [goes]}]}
materials:
  soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}
bodies:
  left: {material: soft, formulation: total-lagrangian, velocity: [-2.0, 0.0],
         region: {box: {min: [0.6, 0.1], max: [6.0, 3.0]}}}
  right: {material: soft, formulation: total-lagrangian, velocity: [1.0, -1.0],
          region: {ball: {centre: [21.0, 2.6], radius: 2.2}}}
  goes: {material: soft, formulation: total-lagrangian,
         region: {box: {min: [8.0, 0.1], max: [11.0, 2.2]}}}
  one: {rigid: {density: 2.0}, velocity: [2.0, -1.0],
        region: {ball: {centre: [12.3, 5.0], radius: 1.2}}}
  other: {rigid: {density: 2.0}, region: {ball: {centre: [16.0, 5.2], radius: 1.2}}}
gravity: [0.0, -1.0]
boundaries:
  x-min: periodic
  x-max: periodic
  y-min: {unilateral: {friction: 0.4, restitution: 0.5}}
contact:
  - {bodies: all, friction: 0.3}
  - {bodies: [one, other], restitution: 0.8}
output: {every: {steps: 19}, surface: [contact-pressure, traction, gap, slip, wear-work]}
history: {every: {steps: 10}}
checkpoint: {every: {steps: 25}, keep: 3}
"""
#: A job on two ranks that has not ended after this is taken for hung; more share the cores.
PATIENCE = 60.0


def environment(tcp=False):
    """Environment of a job of its own: as root, on cores that others want too, perhaps by TCP."""
    launcher = ("OMPI_", "PMIX_", "PMI_", "SLURM_")
    env = {name: value for name, value in os.environ.items() if not name.startswith(launcher)}
    env |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    env |= {"OMPI_MCA_mpi_yield_when_idle": "1"}
    machines = {"OMPI_MCA_btl": "tcp,self", "OMPI_MCA_btl_tcp_if_include": "lo"}
    return env | (machines if tcp else {})


class Job:
    """A run of ``pgimp WORDS`` in a folder that goes on while it is being disturbed.

    One rank is without mpirun; with `tcp` ranks talk by TCP; Python runs `program` for pgimp.
    """

    def __init__(self, ranks, words, folder, tcp=False, program=("-m", "pgimp")):
        command = [sys.executable, *program, *map(str, words)]
        if ranks > 1:
            options = ["--oversubscribe", "--bind-to", "none", "-n", str(ranks)]
            command = ["mpirun", *options, *command]
        self.count = ranks
        self.began = time.monotonic()
        self._said = tempfile.TemporaryFile("w+", errors="replace")
        self.process = subprocess.Popen(
            command, cwd=folder, env=environment(tcp), stdin=subprocess.DEVNULL, stdout=self._said,
            stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip

    @property
    def running(self):
        return self.process.poll() is None

    def ranks(self):
        """Process ids of the ranks that are there by now."""
        if self.count == 1:
            return [self.process.pid]
        try:
            tasks = Path(f"/proc/{self.process.pid}/task")
            children = {
                int(child)
                for task in tasks.iterdir()
                for child in (task / "children").read_text().split()
            }
        except OSError:
            return []
        return sorted(children)

    def wait(self, patience=PATIENCE):
        """Status and seconds until the end; None as status if it hangs, and it is ended."""
        began = time.monotonic()
        try:
            status = self.process.wait(patience * max(1.0, self.count / 2.0))
        except subprocess.TimeoutExpired:
            status = None
            for pid in (*self.ranks(), self.process.pid):
                os.kill(pid, signal.SIGKILL)
            self.process.wait()
        return status, time.monotonic() - began

    @property
    def said(self):
        self._said.seek(0)
        return self._said.read()


def come_to(frames, job, directory):
    """Wait until a run has written so many frames, or has ended."""
    while job.running and len(list(directory.glob("frames/*.h5"))) < frames:
        time.sleep(0.002)


def whole(folder, name, words, ranks=1, tcp=False):
    """Run to the end without a disturbance, and return what is left; an error if that fails."""
    job = Job(ranks, [*words, "-o", name, "--overwrite"], folder, tcp)
    status, _ = job.wait(10 * PATIENCE)
    if status != 0:
        sys.exit(f"the undisturbed run failed with status {status}:\n{job.said}")
    return pgimp.open(folder / name)


def options_of(name, words, runs=None, **more):
    """What the words of a proof say: runs and seed if it has some, and more; see the harness."""
    number = {"runs": {"type": int, "default": runs}, "seed": {"type": int, "default": 1}}
    return harness.options_of(f"faults {name}", words, **(number if runs else {}) | more)


def disturbed(name, words, runs):
    """Options of a proof whose runs are disturbed."""
    options = options_of(
        name, words, runs, tcp="ranks talk as between machines",
        short="fewer steps, at most 3 ranks", contact="bodies that meet, up to 7 ranks",
        heap="many bodies in a drum, up to 7 ranks",
        surfaces="bodies that meet by surfaces, up to 7 ranks",
    )  # fmt: skip
    options.contact |= options.heap or options.surfaces
    return options


def undisturbed(folder, options):
    """Results of the case that is to be disturbed; seconds of a run on two ranks, compiled."""
    text = SHORT if options.short else MEET if options.contact else CASE
    if options.surfaces:
        text = SURFACES
    if options.heap:
        text = json.dumps(heaps.make(random.Random(options.seed), "drum"))
    (folder / "blocks.yaml").write_text(text)
    began = time.monotonic()
    reference = whole(folder, "whole", ["blocks.yaml", "--quiet"])
    again = time.monotonic()
    whole(folder, "again", ["blocks.yaml", "--quiet"], 2, options.tcp)
    length = time.monotonic() - again
    print(f"an undisturbed run takes {length:.1f} s, with compilation {again - began:.1f} s")
    return reference, length


def resumed(name, ranks, folder, options, reference):
    """Resume a run; lines that it says, and how it is not what it should be, "" if it is."""
    job = Job(ranks, ["blocks.yaml", "-o", name, "--resume"], folder, options.tcp)
    status, _ = job.wait()
    lines = job.said.splitlines()
    wrong = differences(reference.path, folder / name) if status == 0 else []
    if status == 0 and not wrong:
        return lines, ""
    return lines, f", resumed on {ranks}: status {status}, {wrong}, {lines[-5:]}"


def unreadable(directory):
    """Read all that a run has left; return what is wrong with it, one line each."""
    wrong = []
    if not (directory / "run.json").exists():
        return wrong
    run = pgimp.open(directory)
    try:
        steps = [frame.step for frame in run]
        for frame in run:
            if not all(np.isfinite(frame[name]).all() for name in frame.fields):
                wrong.append(f"frame {frame.number} has values that are no numbers")
        if steps != sorted(set(steps)):
            wrong.append(f"frames of the steps {steps}")
        lines = run.history["step"].tolist() if len(run.history) else []
        if lines != sorted(set(lines)):
            wrong.append(f"lines of the steps {lines}")
    except pgimp.errors.PgimpError as error:
        wrong.append(str(error))
    series = directory / "particles.xdmf"
    if series.exists():
        tree = xml.etree.ElementTree.parse(series)
        files = {item.text.split(":")[0] for item in tree.iter("DataItem")}
        wrong += [
            f"{name} is listed, but not there" for name in files if not (directory / name).exists()
        ]
    for path in present(directory / "checkpoints"):
        try:
            CheckpointFile(path).verify(0, 1)
        except pgimp.errors.DamagedError as error:
            wrong.append(f"{path.name}: {error}")
    return wrong


def differences(one, other, names=("history.csv", "particles.*", "frames/*")):
    """Files of some names in which two run directories differ, bit for bit."""
    found = {path.relative_to(run) for run in (one, other) for n in names for path in run.glob(n)}

    def content(run, name):
        return (run / name).read_bytes() if (run / name).is_file() else None

    return sorted(str(name) for name in found if content(one, name) != content(other, name))


@contextmanager
def scratch(name):
    """Give a folder that goes at the end, if the proof succeeded by returning no failure."""
    folder = Path(tempfile.mkdtemp(prefix=f"pgimp-{name}-"))
    failures = []
    yield folder, failures
    if failures:
        print(f"{len(failures)} failures; see {folder}:")
        for line in failures:
            print(f"  {line}")
    else:
        shutil.rmtree(folder)
