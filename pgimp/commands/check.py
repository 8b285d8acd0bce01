"""``pgimp check``: validates a case and says what it will cost, before an hour is lost.

Nothing is simulated but a few steps of the same case with coarser or finer cells, to measure what
the parts of a step cost on this machine; the rest is `pgimp.model`.
"""

import argparse
from math import ceil

import numpy as np

from pgimp.case.load import load
from pgimp.case.schema import Case
from pgimp.kernels.cache import announced
from pgimp.kernels.sums import fastest_rate
from pgimp.model.costs import Network
from pgimp.model.layout import layout_now, layout_of
from pgimp.model.measure import costs_of, take_turns
from pgimp.model.predict import Step
from pgimp.model.report import between_nodes, ladder, lines, on_node, remark, scaling, verdict
from pgimp.model.sample import samples_of
from pgimp.output.progress import duration
from pgimp.parallel.comm import Serial, say
from pgimp.parallel.limits import limits
from pgimp.scene.doubts import BodyFacts, doubts, idle_step, strains
from pgimp.scene.extent import extents
from pgimp.scene.geometry import share
from pgimp.scene.lattice import Lattice
from pgimp.scene.scene import Scene, count_particles
from pgimp.solver.memory import Estimate, MemoryShortError, estimate, require, size_text
from pgimp.solver.particles import Particles
from pgimp.solver.stability import doubt, require_end, require_stable

#: Particles of the samples that are timed; the last are more than caches hold.
_SMALLEST, _SMALL, _LARGE = 200, 5_000, 150_000
#: For how long they are timed.
_SECONDS = 1.0
_YEAR = 365.25 * 86400.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("case", metavar="CASE.yaml", help="the case file")
    parser.add_argument(
        "--set",
        metavar="KEY.PATH=VALUE",
        action="append",
        default=[],
        help="change a value of the case; repeatable",
    )


def execute(args: argparse.Namespace) -> int:
    """Run the command."""
    with announced(say):
        report(load(args.case, args.set))
    return 0


def report(case: Case) -> None:
    """Print the report.

    Raises
    ------
    CaseError
        For whatever would stop a run before its first step.
    """
    scene = Scene(case)
    share(case, Serial())
    cells = " x ".join(str(n) for n in scene.frame.cells)
    try:
        require(scene, Serial())
        lattice, counts, notes = count_particles(scene, Serial())
        memory = require(scene, Serial(), int(counts.sum()))
    except MemoryShortError as error:
        print(f"{case.title or 'case'}: valid, but not for the memory that is here")
        print(f"particles        about {error.estimate.particles:.3g}")
        print(f"cells            {cells}, shape {case.method.shape}")
        _report_memory(error.estimate)
        raise
    bodies = [_facts(scene, lattice, counts, body) for body in range(len(scene.body_names))]
    inverse = max(scene.frame.inverse)
    rate = max((body.wave_speed + body.top_speed) * inverse for body in bodies)
    require_end(scene, rate)
    dt = _step(case, rate)
    steps = case.time.steps or ceil(case.time.end / dt * (1.0 - 1e-9))
    count = int(counts.sum())
    print(f"{case.title or 'case'}: valid")
    print(f"particles        {count:,} in {len(bodies)} bod{'y' if len(bodies) == 1 else 'ies'}")
    print(f"cells            {cells}, shape {case.method.shape}")
    for body in bodies:
        _report_body(body, case, steps * dt)
    stable = 1.0 / rate
    print(f"step             {dt:.4g}, Courant {dt * rate:.3g}; Courant 1 is {stable:.4g}")
    print(f"steps            {steps:,} to t = {case.time.end:g}")
    _report_memory(memory)
    _report_cost(scene, lattice, counts, steps)
    for note in notes:
        print(f"note: {note}")
    warnings = [doubt(dt, rate, case.method.stable), idle_step(dt, rate)]
    warnings += [text for body in bodies for text in doubts(case, body, steps * dt)]
    for text in filter(None, warnings):
        print(f"warning: {text}")


def _facts(scene: Scene, lattice: Lattice, counts: np.ndarray, body: int) -> BodyFacts:
    """Greatest speeds and size of a body; its particles are made a few planes at a time."""
    point = Particles.empty(1, scene.dimension, False)
    point.body[0] = body
    D = scene.dimension
    identity = tuple(float(i == j) for i in range(D) for j in range(D))
    rate = fastest_rate(
        scene.frame, identity, scene.materials, point, np.zeros(1, np.int32), scene.material_of
    )
    top = 0.0
    low, high = np.full(D, np.inf), np.full(D, -np.inf)
    for made in lattice.make((0, lattice.planes), counts, body):
        v = scene.velocities(body, made.centroids) if made.velocities is None else made.velocities
        with np.errstate(over="ignore"):
            top = max(top, float(np.sqrt((v * v).sum(axis=1)).max()))
        low = np.minimum(low, made.positions.min(axis=0))
        high = np.maximum(high, made.positions.max(axis=0))
    return BodyFacts(
        scene.body_names[body],
        int(counts[body].sum()),
        rate / max(scene.frame.inverse),
        top,
        float((high - low + np.array(scene.frame.cell) / lattice.per_cell).max()),
        scene.materials[scene.body_material[body]].density,
    )


def _step(case: Case, rate: float) -> float:
    """Length of a step, the first one if it is controlled."""
    if not isinstance(case.time.step, float | int):
        return min(case.time.step.courant / rate, case.time.end)
    require_stable(float(case.time.step), rate, case.method.stable)
    return float(case.time.step)


def _report_body(body: BodyFacts, case: Case, duration: float) -> None:
    """Wave speed, transit time, and loads against stiffness: strains that show unit mistakes."""
    c = body.wave_speed
    transit = body.extent / c
    print(
        f"body {body.name:<11} {body.particles:,} particles; wave speed {c:.4g}, transit time "
        f"{transit:.4g} over {body.extent:.4g}; the run lasts {duration / transit:.3g} transits"
    )
    for fact in case.bodies[body.name].region.facts():
        print(f"{'':<16} {fact}")
    texts = (f"{what} {strain:.2g}" for what, strain in strains(case, body).items())
    print(f"{'':<16} strain {', '.join(texts)}")


def _report_cost(scene: Scene, lattice: Lattice, counts: np.ndarray, steps: int) -> None:
    """Time on this machine, the number of ranks that pays off, and why not more do."""
    comm, bodies = Serial(), extents(scene.case)
    count = int(counts.sum())
    sizes = [min(_SMALLEST, count), _SMALL, *([min(_LARGE, count)] if count > 2 * _SMALL else [])]
    samples = samples_of(scene.case, count, comm, sizes)
    take_turns(samples, comm, _SECONDS)
    costs, network = costs_of(samples), Network()
    layout = layout_of(scene, bodies, lattice.coordinates[0], counts.sum(axis=0))
    layout = layout._replace(crossing=layout_now(samples[-1].sim).crossing)

    def memory(step: Step) -> float:
        return estimate(scene, step.ranks, True, bodies, count, step.most / count).size

    found = scaling(layout, costs, network, memory)
    one, ranks = found["steps"][0]["seconds"], found["pays_off"]
    best = next(step for step in found["steps"] if step["ranks"] == ranks)
    print(
        f"time             {_time_text(steps * one)} on one rank of this machine, without output "
        f"({1e-6 * count / one:.3g} million particle-steps/s measured)"
    )
    if steps * one >= _YEAR:
        print("warning: nobody will see the end; is time.end or time.step what it should be?")
    print(f"ranks            {verdict(found)}")
    print(
        f"{'':<16} there {_time_text(steps * best['seconds'])}, {size_text(best['memory'])} a rank"
    )
    shown = [
        step for step in found["steps"] if step["ranks"] in (*ladder((), ranks), found["slabs"])
    ]
    for line in lines(shown, remark(found), f"{'':<17}"):
        print(line)
    print(f"{'':<17}{on_node(costs)}")
    if shown[-1]["ranks"] > network.ranks_per_node:
        print(f"{'':<17}{between_nodes(network)}")


def _time_text(seconds: float) -> str:
    return duration(seconds) if seconds < _YEAR else f"{seconds / _YEAR:.3g} years"


def _report_memory(found: Estimate) -> None:
    """Memory on one rank, and how much of it there is."""
    free = min((limit.free for limit in limits()), default=None)
    here = "" if free is None else f"; {size_text(free)} are free here"
    print(f"memory           about {size_text(found.size)} on one rank{here}")
    for part in found.parts:
        if part.size > 0.01 * found.size:
            print(f"{'':<16} {size_text(part.size)} for {part.what}")
