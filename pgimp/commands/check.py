"""``pgimp check``: validates a case and says what it will cost, before an hour is lost.

All is set up as by a run, particles a block at a time. Simulated are a few steps of the same case
with coarser or finer cells, to measure what the parts of a step cost on this machine, and a pilot
run on coarse cells, from which the number of steps is predicted; the rest is `pgimp.tools.model`.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from math import ceil

import numpy as np

from pgimp.case.check_stages import changes_of, steps_in
from pgimp.case.load import load
from pgimp.case.schema import Case
from pgimp.case.steps import AUTO
from pgimp.jit.cache import announced
from pgimp.mpi.comm import Serial, say
from pgimp.mpi.limits import limits
from pgimp.running import forecast
from pgimp.running.progress import duration
from pgimp.scene import nearness
from pgimp.scene.advice import advice
from pgimp.scene.extent import extents
from pgimp.scene.facts import BodyFacts, examine
from pgimp.scene.geometry import share
from pgimp.scene.lattice import Lattice
from pgimp.scene.sanity import body_warnings, case_warnings, small_step_warning, strains
from pgimp.scene.scene import MOST_CELLS, Scene, count_particles
from pgimp.scene.toolchecks import require_apart, require_clear, require_slow
from pgimp.solver.lookahead import look_ahead, require_stable_stages, stage_rate
from pgimp.solver.memory import Estimate, MemoryShortError, estimate, require, size_text
from pgimp.solver.stability import require_end, require_stable, stability_warning
from pgimp.tools.model.costs import Costs, Network
from pgimp.tools.model.layout import layout_now, layout_of
from pgimp.tools.model.measure import costs_of, run_in_turn
from pgimp.tools.model.pilot import Pilot, pilot
from pgimp.tools.model.predict import Step
from pgimp.tools.model.report import (
    between_nodes,
    lines,
    on_node,
    rank_counts,
    remark,
    scaling,
    verdict,
)
from pgimp.tools.model.sample import samples_of

#: Particles of the samples that are timed; the last are more than caches hold.
_SMALLEST, _SMALL, _LARGE = 200, 5_000, 150_000
#: For how long they are timed.
_SECONDS = 1.0
#: Error of a number of steps that is "about" right.
_CLOSE = 0.1
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
        _report_memory(error.estimate)
        raise
    if scene.tools:
        _look_at_rigid(scene, lattice, counts)
    found = examine(scene, lattice, counts)
    bodies = found.bodies
    varied = {body.name: body.rest_rate for body in bodies if body.varies}
    of_stages = require_stable_stages(scenes, varied)
    inverse = max(scene.frame.inverse)
    # A grid of the initial configuration moves with the bodies.
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
    costs, crossing = _measure(scene, count)
    tried = pilot(case, count, steps, costs, _thinnest(case, bodies))
    steps = _report_steps(case, steps, tried)
    if whole.time.stages:
        steps += report_stages(whole, scenes, steps * dt / case.time.end, varied)
    _report_memory(memory)
    _report_cost(scene, lattice, counts, costs, crossing, steps)
    number = forecast.frames(whole, steps)
    size = size_text(number * forecast.frame_size(case, scene.fields, count))
    print(f"output           {number:,} frames of particles, about {size}")
    for note in (*notes, *nearness.notes(case), *advice(case, bodies)):
        print(f"note: {note}")
    for text in chain(
        filter(None, [] if case.watched else [stability_warning(dt, rate, case.method.stable)]),
        filter(None, [small_step_warning(dt, rate)]),
        of_stages,
        _pilot_warnings(case, dt * rate, tried),
        *(body_warnings(case, body, whole.time.last) for body in bodies),
        case_warnings(case, found),
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
    """Say how many steps fewer there would be if pgimp chose their length."""
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


def _measure(scene: Scene, count: int) -> tuple[Costs, float]:
    """Costs of a step on this machine, and the part of particles that change layer in one."""
    comm = Serial()
    sizes = [min(_SMALLEST, count), _SMALL, *([min(_LARGE, count)] if count > 2 * _SMALL else [])]
    samples = samples_of(scene.case, count, comm, sizes)
    run_in_turn(samples, comm, _SECONDS)
    return costs_of(samples), layout_now(samples[-1].sim).crossing


def _report_cost(
    scene: Scene,
    lattice: Lattice,
    counts: np.ndarray,
    costs: Costs,
    crossing: float,
    steps: float,
) -> None:
    """Time on this machine, the number of ranks that pays off, and why not more do."""
    bodies, count, network = extents(scene.case), int(counts.sum()), Network()
    layout = layout_of(scene, bodies, lattice.coordinates[0], counts.sum(axis=0))
    layout = layout._replace(crossing=crossing)

    def memory(step: Step) -> float:
        return estimate(scene, step.ranks, True, bodies, count, step.most / count).size

    scaled = scaling(layout, costs, network, memory)
    one, ranks = scaled["steps"][0]["seconds"], scaled["pays_off"]
    best = next(step for step in scaled["steps"] if step["ranks"] == ranks)
    print(
        f"time             {_time_text(steps * one)} on one rank of this machine, without output "
        f"({1e-6 * count / one:.3g} million particle-steps/s measured)"
    )
    if steps * one >= _YEAR:
        print("warning: nobody will see the end; is time.end or time.step what it should be?")
    print(f"ranks            {verdict(scaled)}")
    print(
        f"{'':<16} there {_time_text(steps * best['seconds'])}, {size_text(best['memory'])} a rank"
    )
    shown = [
        step
        for step in scaled["steps"]
        if step["ranks"] in (*rank_counts((), ranks), scaled["slabs"])
    ]
    for line in lines(shown, remark(scaled), f"{'':<17}"):
        print(line)
    print(f"{'':<17}{on_node(costs)}")
    if shown[-1]["ranks"] > network.ranks_per_node:
        print(f"{'':<17}{between_nodes(network)}")


def _thinnest(case: Case, bodies: list[BodyFacts]) -> float:
    """Cells across the thinnest body."""
    return min(
        size / cell for one in bodies for size, cell in zip(one.sizes, case.grid.cell, strict=True)
    )


def _report_steps(case: Case, steps: float, tried: Pilot | None) -> float:
    """Number of steps, predicted where they follow the fastest wave; return it."""
    if case.time.steps is not None:
        print(f"steps            {case.time.steps:,} to t = {case.time.end:g}")
        return steps
    start = f"{ceil(steps * (1.0 - 1e-9)):,}"
    if tried is None:
        print(
            f"steps            {start} to t = {case.time.end:g} if no wave becomes faster; more if "
            "the material is compressed: no pilot run can be made of this case"
        )
        return steps
    print(f"steps            {_predicted(case, tried)}; {start} if no wave became faster")
    return tried.steps


def report_stages(
    case: Case, scenes: Sequence[Scene], factor: float, varied: Mapping[str, float]
) -> float:
    """Say what the stages after the first change; return how many steps they take, about.

    `factor` is by how much the first has more steps than at rest, where waves set their length;
    `varied` has rates of bodies whose materials vary, see `stage_rate`.
    """
    total = 0.0
    for stage, scene in zip(case.time.stages, scenes[1:], strict=True):
        one = scene.case
        steps = steps_in(one)
        about = ""
        if steps is None:
            assert one.courant is not None
            rate, length = stage_rate(scene, varied), one.time.end - one.staged.start
            steps, about = ceil(max(factor, 1.0) * length * rate / one.courant), "about "
        total += steps
        what = ", ".join(changes_of(stage)) or "nothing"
        print(
            f"stage {one.staged.number + 1:<10} '{stage.name}' to t = {stage.end:g}, "
            f"{about}{steps:,} step{'' if steps == 1 else 's'}; changes {what}"
        )
    return total


def _predicted(case: Case, tried: Pilot) -> str:
    """Return how many steps a pilot run predicts, and what that supposes."""
    text = f"{tried.steps:,.0f} to t = {case.time.end:g}"
    if tried.done < 1.0:
        ended = "failed" if tried.failure else "ran out of time"
        return (
            f"{text} if waves stay as fast as at t = {tried.done * case.time.end:.3g}, where a "
            f"pilot run of {_size(tried)} {ended}; more if they become faster"
        )
    if tried.error > _CLOSE:
        return (
            f"roughly {text}, predicted by a pilot run of {_size(tried)}, which are too coarse for "
            f"an error below {100.0 * _CLOSE:g} %"
        )
    return f"about {text}, predicted by a pilot run of {_size(tried)}"


def _size(tried: Pilot) -> str:
    """Return how large a pilot run was."""
    text = f"{tried.particles:,} particles"
    if tried.factor > 1.0 + 1e-9:
        text += f" in cells {tried.factor:.3g} times as long"
    return text


def _pilot_warnings(case: Case, courant: float, tried: Pilot | None) -> Iterator[str]:
    """Return what a pilot run came to that a run may come to as well."""
    if tried is None:
        return
    if tried.failure:
        yield (
            f"a pilot run of {_size(tried)} failed at t = {tried.done * case.time.end:.3g}: "
            f"{tried.failure}"
        )
    stable = case.method.stable
    if courant <= stable * (1.0 + 1e-9) < tried.courant and not tried.failure:
        yield (
            f"time.step: its Courant number grows from {courant:.3g} to {tried.courant:.3g} in a "
            f"pilot run, as waves or particles become faster; above {stable:g} a free surface may "
            "become unstable with this shape"
        )


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
