"""Runs of the paper's bar on one rank, several at once, and what the figures need of them."""

import json
import math
import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from time import process_time
from typing import NamedTuple

import numpy as np
from column import LENGTH, RATE, YOUNG, column_stress
from common import ROOT
from rich.progress import Progress

from figures.methods import METHODS

#: Speed of the bar in the shock, c/50, and the stress behind the front (46).
IMPACT, SHOCK = -20.0, -20000.0
TRANSIT = 0.05


class Run(NamedTuple):
    """A run of the bar: the column under its growing weight, or thrown at the wall.

    `times` are the instants that are looked at, `speed` is that of the ramp in parts of the
    paper's; with `profile` the stresses of all particles are kept.
    """

    problem: str
    method: str
    cell: float
    per_cell: int
    step: float
    times: tuple[float, ...]
    speed: float = 1.0
    profile: bool = False

    @property
    def cost(self):
        """Rough number of seconds."""
        return self.times[-1] / self.step * (4e-5 + 1e-7 * LENGTH / self.cell * self.per_cell)

    @property
    def words(self):
        """What differs from cases/compaction.yaml."""
        method = f"{METHODS[self.method].entry}, particles-per-cell: [{self.per_cell}]"
        # At least a tenth more than the column, in whole cells.
        size = self.cell * math.ceil(1.1 * LENGTH / self.cell - 1e-9)
        words = [
            f"method={{{method}}}",
            f"grid={{origin: [0.0], size: [{size!r}], cell: [{self.cell!r}]}}",
            f"time={{end: {self.times[-1]!r}, step: {self.step!r}}}",
        ]
        if self.problem == "column":
            ramp = f"[[0.0, [0.0]], [{2.1 / self.speed!r}, [{-2.1 * RATE!r}]]]"
            return [*words, f"gravity={{table: {ramp}}}", "exact={compaction: {dynamic: true}}"]
        return [
            *words, "gravity=null", f"bodies.column.velocity=[{IMPACT}]",
            "materials.bar.viscosity={linear: 0.2, quadratic: 2.0}", "exact=shock",
        ]  # fmt: skip


def perform(run):
    """Do a run; returns a record for each of its instants, those not reached with the reason."""
    import pgimp
    from pgimp.errors import RunError
    from pgimp.mpi.comm import Serial
    from pgimp.solver.simulation import Simulation

    sim = Simulation(pgimp.load(ROOT / "cases/compaction.yaml", run.words), Serial())
    records, stopped, began = [], None, process_time()
    for time in run.times:
        try:
            while not stopped and sim.step < round(time / run.step):
                sim.advance()
        except RunError as failure:
            stopped = f"stopped at t = {sim.time:.4g}: {str(failure).splitlines()[0]}"
        done = {"time": time, "particles": sim.count, "steps": sim.step}
        done["seconds"] = process_time() - began
        records.append(done | ({"stopped": stopped} if stopped else observe(sim, run, time)))
    return records


def observe(sim, run, time):
    """Errors at an instant, and the profile."""
    rows = sim.live()
    x, stress = sim.particles.x[rows, 0], sim.particles.sigma[rows, 0]
    size = (sim.particles.V if sim.scene.settings.follows else sim.particles.V0)[rows]
    dynamic = sim.diagnostics()["error"]
    if run.problem == "column":
        scale = RATE * time * run.speed * LENGTH
        difference = np.abs(stress - column_stress(x, time * run.speed)[0])
        error = float((difference * size).sum() / (scale * LENGTH))  # (47)
        found = {"error": error, "dynamic": dynamic, "worst": float(difference.max() / scale)}
    else:
        # The front is smeared over about six cells; what lies behind it is at rest.
        behind = stress[sim.particles.origin[rows, 0] < 1000.0 * time - 6.0 * run.cell]
        found = {
            "error": dynamic,
            "mean": float(behind.mean()),
            "jump": float(np.abs(np.diff(behind)).max()),
        }
    if run.profile:
        found |= {"x": x.tolist(), "stress": stress.tolist()}
    return found


def perform_all(runs, jobs):
    """Do runs, `jobs` at a time, the longest first; returns their records."""
    pending = sorted(set(runs), key=lambda run: -run.cost)
    # numba's threads and MPI do not survive a fork.
    workers = ProcessPoolExecutor(jobs, get_context("spawn"))
    results = {}
    with workers, Progress(disable=None) as progress:
        task = progress.add_task("runs", total=sum(run.cost for run in pending))
        futures = {workers.submit(perform, run): run for run in pending}
        for future in as_completed(futures):
            run = futures[future]
            results[run] = future.result()
            progress.advance(task, run.cost)
    return {run: results[run] for run in runs}


def keep(results, origin, path):
    """Write runs and their records, in place of what was there."""
    runs = [{"run": run._asdict(), "records": records} for run, records in results.items()]
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps({"origin": origin, "runs": runs}))
    os.replace(temporary, path)


def recall(path):
    """Read what `keep` wrote; returns the records by run, and the origin."""
    data = json.loads(path.read_text())
    results = {}
    for entry in data["runs"]:
        run = Run(**entry["run"] | {"times": tuple(entry["run"]["times"])})
        results[run] = entry["records"]
    return results, data["origin"]


def shock_stress(time):
    """Corners of the exact stress of the shock over position, (x, stress)."""
    speed = math.sqrt(YOUNG)
    front, end = (speed + IMPACT) * time, LENGTH + IMPACT * time
    return [0.0, front, front, end], [SHOCK, SHOCK, 0.0, 0.0]
