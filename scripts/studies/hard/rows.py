"""The hard cases: their variants, and what is measured of each."""

from collections.abc import Callable, Mapping
from functools import cache
from math import pi
from time import perf_counter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from studies.hard.cantilever import mean_deflection
from studies.hard.courant import energies, free_bodies
from studies.hard.runs import BOUND, Watched, begin, field, watch
from studies.method.bodies import SHAPES

from pgimp.errors import RunError
from pgimp.solver.time.clock import FixedClock

METHODS = {name: {"method.shape": name} for name in SHAPES}
#: The bar that is pulled has torn when it bears less than this part of what it should.
TORN = 0.5


class Row(NamedTuple):
    """A line of the table: a case with changes, its quick variant, and how its error is found.

    `error` takes a `Watched` that has finished; it gives the error and remarks by name. `methods`
    are those that are run, `quick` the further changes of the quick variant, None to leave it out.
    """

    label: str
    case: str
    error: Callable[[Watched], tuple[float, dict[str, Any]]]
    changes: Mapping[str, Any] = MappingProxyType({})
    quick: Mapping[str, Any] | None = None
    methods: tuple[str, ...] = tuple(METHODS)


def exact_error(run):
    return float(run.lines["error"][-1]), {}


def shock_error(run):
    """Error (47) at the end; the greatest stress over the exact one, less 1."""
    most = float(-field(run.sim, "sigma")[:, 0].min())
    return float(run.lines["error"][-1]), {"overshoot": most / 2.0e5 - 1.0}


def lost_spin(run):
    """Part of the angular momentum that is lost; how far the square is from the turned one."""
    spin = run.lines["angular-momentum-z"]
    x = field(run.sim, "x")
    count = round(len(x) ** 0.5)
    edge = 0.5 + (np.arange(count) + 0.5) / count
    first = np.stack(np.meshgrid(edge, edge, indexing="ij"), axis=-1).reshape(-1, 2)
    a, b = ((z - z.mean(axis=0)) @ np.array([1.0, 1.0j]) for z in (first, x))
    turn = np.vdot(a, b)
    distance = np.abs(b - a * turn / abs(turn))
    shape = float(np.sqrt((distance**2).mean()))
    return float(1.0 - spin[-1] / spin[0]), {"shape": shape}


def torn_at(run):
    """Ratio of the gauge length to its first one at which the bar tears; inf if it does not."""
    time, force = run.lines["time"], run.lines["constraint.right-x"]
    stretch = 1.0 + 2.0 * 5.0 * time / 40.0
    weak = np.flatnonzero((force < TORN * 1.0e6 * (stretch - 1.0)) & (stretch > 1.1))
    return float(stretch[weak[0]]) if len(weak) else float("inf")


def pull_error(run):
    """Part of the wanted stretch that is missing when the bar tears."""
    return max(0.0, 1.0 - (torn_at(run) - 1.0) / 2.0), {"clamped": run.sim.rank.clamped}


@cache
def _static(poisson):
    return mean_deflection(1.0, poisson, 2.0, 1.0, -5.0e-4, (24, 12))


def deflection(run, height=1.0):
    """Mean deflection of the beam, whose middle was at `height`, and that of finite elements."""
    time, middle = run.lines["time"], run.lines["body.beam.centre-y"]
    found = float(middle[time >= 56.0].mean() - height)
    return found, _static(run.sim.case.materials["rubber"].poisson)


def deflection_error(run):
    """Mean deflection after the ramp against that of quadratic finite elements."""
    found, exact = deflection(run)
    return abs(found / exact - 1.0), {"deflection": found, "exact": exact}


def rebound(run):
    """Velocity of the left block at the end, over that before."""
    p, rows = run.sim.particles, run.sim.live()
    left = rows[p.body[rows] == 0]
    return float((p.m[left] @ p.v[left, 0]) / p.m[left].sum() / 0.2)


@cache
def _fine_rebound():
    """Reference: finite-gimp with viscosity on cells a quarter as large."""
    return rebound(watch(begin("blocks", {"grid.cell": [0.0125, 0.0125]}), lines=20))


def rebound_error(run):
    """Velocity of the rebound against that of the reference, over that before."""
    found = rebound(run)
    return abs(found - _fine_rebound()), {"rebound": found, "reference": _fine_rebound()}


AFFINE = {"method.affine": True}
NO_VISCOSITY = {"materials.bar.viscosity": None}
DRY = {"materials.rubber.viscosity": None}
SHORT = {"time.end": 0.5, "grid.cell": [1.0], "time.step": 2.0e-4}
ROWS = (
    Row("translation", "translation", exact_error, {},
        {"time.end": 40.0, "exact.spinning-block.period": 80.0}),
    Row("translation, relaxation 1", "translation", exact_error, {"method.pic-damping": 1.0}),
    Row("translation, affine", "translation", exact_error, AFFINE),
    Row("column, cell 1", "column", exact_error, {"grid.cell": [1.0], "time.step": 2.0e-4}, SHORT),
    Row("column, cell 0.25", "column", exact_error, {"grid.cell": [0.25], "time.step": 5.0e-5}),
    Row("column, cell 0.05", "column", exact_error),
    Row(
        "column, cell 0.25, a tenth of the step", "column", exact_error,
        {"grid.cell": [0.25], "time.step": 5.0e-6}, None, ("mpm",),
    ),
    Row(
        "column, cell 0.25, relaxation 500", "column", exact_error,
        {"grid.cell": [0.25], "time.step": 5.0e-5, "method.pic-damping": 500.0},
    ),
    Row(
        "column, cell 0.25, affine", "column", exact_error,
        {"grid.cell": [0.25], "time.step": 5.0e-5} | AFFINE,
    ),
    Row("shock", "shock", shock_error, NO_VISCOSITY, {}),
    Row("shock, viscosity", "shock", shock_error, {}, {}),
    Row(
        "shock, relaxation 500", "shock", shock_error, NO_VISCOSITY | {"method.pic-damping": 500.0}
    ),
    Row("spinning", "spinning", lost_spin, {}, {"time.end": 20.0 * pi}),
    Row("spinning, cell 0.05, 5 turns", "spinning", lost_spin,
        {"grid.cell": [0.05, 0.05], "time.end": 100.0 * pi, "output.every": None}, None,
        ("mpm", "gimp", "finite-gimp", "cpdi")),
    Row("spinning, affine", "spinning", lost_spin, AFFINE, AFFINE | {"time.end": 20.0 * pi}),
    Row("stretch", "stretch", pull_error, {}, {}),
    Row("stretch, affine", "stretch", pull_error, AFFINE),
    Row("stretch, 4 a cell", "stretch", pull_error, {"method.particles-per-cell": [4]}),
    Row("bending, 0.3", "bending", deflection_error, {"materials.rubber.poisson": 0.3},
        {"grid.cell": [0.25, 0.25]}),
    Row("bending, 0.499, cell 0.25", "bending", deflection_error, {"grid.cell": [0.25, 0.25]}),
    Row("bending, 0.499, cell 0.125", "bending", deflection_error),
    Row("blocks", "blocks", rebound_error, DRY),
    Row("blocks, viscosity", "blocks", rebound_error),
    Row("blocks, relaxation 1", "blocks", rebound_error, DRY | {"method.pic-damping": 1.0}),
    Row("blocks, affine", "blocks", rebound_error, DRY | AFFINE),
)  # fmt: skip


def measured(row, method, quick=False):
    """Run a row with a method; a record for hard.csv."""
    changes = METHODS[method] | {**row.changes, **(row.quick or {} if quick else {})}
    run = watch(begin(row.case, changes))
    record = {
        "case": row.label, "method": method, "stable": run.stable, "fault": run.fault,
        "done": run.sim.time / run.sim.clock.end, "growth": run.growth, "error": None,
        "steps": run.sim.step, "seconds": run.seconds, "remarks": "",
    }  # fmt: skip
    if row.case == "stretch" and not run.fault:
        torn = torn_at(run)
        if torn < float("inf"):
            record |= {"stable": False, "fault": f"torn at {torn:.1f} times its length"}
    if not run.fault:
        error, remarks = row.error(run)
        record["error"] = error
        record["remarks"] = ", ".join(f"{key} {value:.4g}" for key, value in remarks.items())
    return record


#: Depths by which particles reach past a vertex, in cells.
DEPTHS = tuple(10.0**-n for n in range(3, 13))


def grazing(method, depth, per_cell=2, courant=0.3, steps=3000):
    """Growth of the energy of a free bar whose particles reach a vertex by `depth` of a cell.

    The bar is shaken by less than that depth, so that it stays where it grazes. The growth is the
    greatest energy over the first one, less 1; inf if the run failed.
    """
    sim = free_bodies({"shape": method}, 1, per_cell, 1)
    p, rows = sim.particles, sim.live()
    reach = sim.scene.settings.shape.half[0]
    random = np.random.default_rng(1)
    p.x[rows, 0] += np.mod(reach - 0.5 / per_cell, 1.0) - depth
    p.v[rows, 0] = 0.1 * depth * random.standard_normal(len(rows))
    sim.population.sort()
    sim.clock = FixedClock(courant / sim.rate, 1e12)
    first = most = energies(sim)[0]
    try:
        for _ in range(steps):
            sim.advance()
            most = max(most, energies(sim)[0])
            if most > 1e6 * first:
                break
    except RunError:
        return float("inf")
    return float(most / first - 1.0)


def grazed(method):
    began = perf_counter()
    growth = {depth: grazing(method, depth) for depth in DEPTHS}
    failed = [depth for depth in DEPTHS if growth[depth] > BOUND]
    text = f"blown up from {max(failed):.0e} to {min(failed):.0e} of a cell" if failed else ""
    return {
        "case": "grazing, 1e-12 to 1e-3 of a cell", "method": method, "stable": not failed,
        "fault": text, "done": 1.0, "growth": max(growth.values()), "error": None,
        "steps": 3000 * len(DEPTHS), "seconds": perf_counter() - began, "remarks": "",
    }  # fmt: skip
