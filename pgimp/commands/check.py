"""``pgimp check``: validates a case and estimates its cost, before an hour is lost.

All is set up as by a run, particles a block at a time. Simulated are a few steps of the same case
with coarser or finer cells, to measure what the parts of a step cost on this machine, and a pilot
run on coarse cells, from which the number of steps is predicted; see `pgimp.tools.check` for
what is said of them, and `pgimp.tools.model`.
"""

import argparse
from itertools import chain

import numpy as np

from pgimp.case.load import load
from pgimp.case.schema import Case
from pgimp.case.steps import AUTO
from pgimp.jit.cache import announced
from pgimp.mpi.comm import Serial, say
from pgimp.running import forecast
from pgimp.scene import nearness, overstress
from pgimp.scene.advice import advice
from pgimp.scene.facts import BodyFacts, examine
from pgimp.scene.geometry import share
from pgimp.scene.laterconstraints import idle_warnings
from pgimp.scene.lattice import Lattice
from pgimp.scene.locking import locking, stripes
from pgimp.scene.sanity import body_warnings, case_warnings, small_step_warning, strains
from pgimp.scene.scene import MOST_CELLS, Scene, count_particles
from pgimp.scene.toolchecks import require_apart, require_clear, require_slow
from pgimp.scene.toolwarnings import motion_warnings
from pgimp.solver.lookahead import look_ahead, require_stable_stages
from pgimp.solver.memory import MemoryShortError, require, size_text
from pgimp.solver.stability import require_end, require_stable, stability_warning
from pgimp.tools.check.cost import measure, report_cost, report_memory
from pgimp.tools.check.steps import pilot_warnings, report_stages, report_steps
from pgimp.tools.model.pilot import pilot


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
        For what would stop a run before its first step.
    """
    whole, case = case, case.stages[0]
    scenes = [Scene(each) for each in whole.stages]
    if whole.time.stages:
        look_ahead(scenes)
    scene = scenes[0]
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
        report_memory(error.estimate)
        raise
    if scene.tools:
        _look_at_rigid(scene, lattice, counts)
    found = examine(scene, lattice, counts, whole.stages)
    bodies = found.bodies
    varied = {body.name: body.rest_rate for body in bodies if body.varies}
    of_stages = require_stable_stages(scenes, varied)
    inverse = max(scene.frame.inverse)
    # A grid of the initial configuration moves with its bodies.
    crossing_rate = 0.0 if scene.initial else inverse
    rate = _rate(case, bodies, crossing_rate)
    require_end(scene, max(rate, scene.tools.first_rate))
    dt = _step(case, rate, scene.tools.first_rate)
    require_slow(scene.tools, dt)
    count = int(counts.sum())
    print(f"{case.title or 'case'}: valid")
    print(f"particles        {count:,} in {len(bodies)} bod{'y' if len(bodies) == 1 else 'ies'}")
    print(f"cells            {cells}, shape {case.method.shape}")
    for body in bodies:
        _report_body(body, case)
    for name, field in zip(scene.tools.names, scene.tools.fields, strict=True):
        entry = case.tools[name]
        moves = "moves freely" if entry.free else "moves" if entry.moves else "stands"
        print(f"rigid {name:<10} {moves}; {len(field.values):,} distances on its lattice")
    stable = 1.0 / rate
    chosen = ", chosen by pgimp" if case.watched else ""
    print(f"step             {dt:.4g}, Courant {dt * rate:.3g}{chosen}; Courant 1 is {stable:.4g}")
    _report_chosen(case, bodies, crossing_rate, dt)
    steps = float(case.time.steps or case.time.end / dt)
    costs, crossing = measure(scene, count, steps)
    tried = pilot(case, count, steps, costs, _thinnest(case, bodies))
    steps = report_steps(case, steps, tried)
    if whole.time.stages:
        steps += report_stages(whole, scenes, steps * dt / case.time.end, varied)
    report_memory(memory)
    report_cost(scene, lattice, counts, costs, crossing, steps)
    number = forecast.frames(whole, steps)
    size = size_text(number * forecast.frame_size(case, scene.fields, count))
    print(f"output           {number:,} frames of particles, about {size}")
    poisson = {one.name: one.varies["poisson"][2] for one in bodies if "poisson" in one.varies}
    advised = (*advice(case, bodies), *stripes(case, poisson))
    for note in (*notes, *nearness.notes(case), *advised):
        print(f"note: {note}")
    for text in chain(
        filter(None, [] if case.watched else [stability_warning(dt, rate, case.method.stable)]),
        filter(None, [small_step_warning(dt, rate)]),
        of_stages,
        pilot_warnings(case, dt * rate, tried),
        *(body_warnings(case, body, whole.time.last) for body in bodies),
        locking(case, poisson),
        overstress.foresee(scene, lattice, counts),
        case_warnings(case, found),
        idle_warnings(found.later, found.held_later),
        motion_warnings(scenes),
        nearness.bonded(scene, lattice, counts),
        nearness.warnings(case),
        forecast.warnings(whole, steps),
    ):
        print(f"warning: {text}")


def _rate(case: Case, bodies: list[BodyFacts], inverse: float) -> float:
    """Cells in a unit of time that a Courant number of the case refers to."""
    if case.watched:
        assert case.courant is not None
        return pace_of(case.courant, bodies, inverse)
    return max(body.rest_rate + body.top_speed * inverse for body in bodies)


def pace_of(courant: float, bodies: list[BodyFacts], inverse: float) -> float:
    """Rate that a Courant number chosen by pgimp refers to, see `Scene.controlled`."""
    part = courant / MOST_CELLS * inverse
    return max(max(body.rest_rate, part * body.top_speed) for body in bodies)


def _report_chosen(case: Case, bodies: list[BodyFacts], inverse: float, dt: float) -> None:
    """Say how many fewer steps there would be if pgimp chose their length."""
    courant = AUTO * case.method.largest_courant(case.dimensions)
    longest = courant / pace_of(courant, bodies, inverse)
    if not case.watched and longest > 1.05 * dt:
        print(
            f"{'':<16} step: {{courant: auto}} would begin with {longest:.4g} (Courant number of "
            f"waves {courant:.2g}): {100.0 * (1.0 - dt / longest):.0f} % fewer steps"
        )


def _look_at_rigid(scene: Scene, lattice: Lattice, counts: np.ndarray) -> None:
    """Refuse rigid bodies that are too thin or overlap others, as a run does."""
    scene.tools.measure(Serial())
    blocks = (
        (block.positions, np.full(len(block.ids), body, np.int32))
        for body in range(len(lattice.bodies))
        for block in lattice.make((0, lattice.planes), counts, body)
    )
    require_apart(scene.tools, blocks, Serial())
    require_clear(scene.tools, scene.faces, scene.tools.first, 0, 0.0, Serial())


def _step(case: Case, rate: float, rigid: float) -> float:
    """Length of a step, the first one if it is controlled; `rigid` is the rate of rigid bodies."""
    if not isinstance(case.time.step, float | int):
        assert case.courant is not None
        return min(case.courant / max(rate, rigid), case.time.end)
    require_stable(float(case.time.step), rate, case.method.stable)
    return float(case.time.step)


def _report_body(body: BodyFacts, case: Case) -> None:
    """Wave speed, transit time, and loads against stiffness: strains that show unit mistakes."""
    c = body.wave_speed
    transit = body.extent / c
    transits = case.time.end / transit
    print(
        f"body {body.name:<11} {body.particles:,} particles; wave speed {c:.4g}, transit time "
        f"{transit:.4g} over {body.extent:.4g}; the run lasts {transits:.3g} transits"
    )
    for fact in case.bodies[body.name].region.facts():
        print(f"{'':<16} {fact}")
    for key, (least, mean, most) in body.varies.items():
        print(f"{'':<16} {key} varies from {least:.6g} to {most:.6g}, mean {mean:.6g}")
    texts = (f"{what} {strain:.2g}" for what, strain in strains(case, body).items())
    print(f"{'':<16} strain {', '.join(texts)}")


def _thinnest(case: Case, bodies: list[BodyFacts]) -> float:
    """Cells across the thinnest body."""
    return min(
        size / cell for one in bodies for size, cell in zip(one.sizes, case.grid.cell, strict=True)
    )
