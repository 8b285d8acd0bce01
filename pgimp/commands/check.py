"""``pgimp check``: validates a case and estimates its cost, before an hour is lost.

The case is set up as in a run, particles a block at a time. A few steps with coarser or finer cells
measure the costs of a step's parts on this machine. A pilot run on coarse cells predicts the number
of steps. See `pgimp.utilities.check` for the report, and `pgimp.utilities.model`.
"""

import argparse
from collections.abc import Iterable
from itertools import chain
from pathlib import Path

from pgimp.case.choices.choose import lines
from pgimp.case.choices.written import written
from pgimp.case.load import load
from pgimp.case.locations import located, old_words
from pgimp.case.reader import read_case
from pgimp.case.schema import Case
from pgimp.errors import UsageError, explain
from pgimp.jit.compiled.cache import announced
from pgimp.mpi.comm import say
from pgimp.running import forecast
from pgimp.running.accuracy.find import of_case
from pgimp.running.accuracy.rules import line
from pgimp.scene.checks import bonds, nearness, overstress, series
from pgimp.scene.checks.at_start import at_start
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.later_constraints import idle_warnings
from pgimp.scene.checks.locking import stripes
from pgimp.scene.checks.rigid_motion import known_in_part
from pgimp.scene.checks.sanity import body_warnings, case_warnings
from pgimp.scene.checks.validity import impedance, repose, tearing, tool_edges
from pgimp.scene.checks.warned import Warned, warned
from pgimp.scene.mass_scaling import scaling_notes
from pgimp.schema.document import decode, read
from pgimp.schema.words.renew import renewed_text
from pgimp.solver.start.memory import size_text
from pgimp.solver.start.require_memory import MemoryShortError
from pgimp.solver.time.stability import stability_warning, stable_courant
from pgimp.storage import atomic
from pgimp.utilities.accuracy.accompany import foreseen
from pgimp.utilities.check.bodies import (
    MOST_BODIES,
    report_body,
    report_inflow,
    report_materials,
    report_rigid,
    report_walls,
)
from pgimp.utilities.check.cost import measure, report_cost, report_memory
from pgimp.utilities.check.prepare import prepare
from pgimp.utilities.check.program import report_program
from pgimp.utilities.check.savings import ordered_advice
from pgimp.utilities.check.settling import Settling, settling_steps
from pgimp.utilities.check.steps import (
    pilot_warnings,
    report_settling,
    report_stages,
    report_steps,
    short_step_warnings,
)
from pgimp.utilities.check.surfaces import vertex_notes
from pgimp.utilities.model.pilot import pilot


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
    parser.add_argument(
        "--write",
        action="store_true",
        help="write what was chosen of the method into the case file, and new words for older "
        "ones; its comments stay",
    )
    parser.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="all that is known: strains, ranks, memory, what a step does",
    )


def execute(args: argparse.Namespace) -> int:
    """Run the command."""
    if args.write and args.set:
        raise UsageError("--write changes the case file, which does not have what --set says")
    with announced(say):
        case = load(args.case, args.set)
        with located(case):
            report(case, args.verbose)
    if args.write:
        _write(args.case, case)
    return 0


def _write(name: str, case: Case) -> None:
    """Write what was chosen into the case file, whose comments stay."""
    before = decode(read(name), name)
    text = written(renewed_text(before), case)
    if text == before:
        print(f"{name}: nothing was chosen, and no word is old; it stays as it is")
        return
    again = read_case(text, name)
    if again.model_dump() != case.model_dump():
        raise UsageError(f"{name}: its form is not one that --write can change; it stays as it is")
    try:
        atomic.write(Path(name), text)
    except OSError as error:
        raise UsageError(f"cannot write {name}: {explain(error)}") from None
    changes = ["what was chosen"] * bool(lines(case)) + ["new words"] * bool(old_words(case))
    print(f"{name}: has now {' and '.join(changes)}")


def report(case: Case, verbose: bool = False) -> None:
    """Print the report: a line for each quantity, with all details if `verbose`.

    Raises
    ------
    CaseError
        For errors that would stop a run before its first step.
    """
    whole, case = case, case.stages[0]
    written = case
    cells = " x ".join(str(n) for n in case.grid.cells)
    try:
        known = prepare(whole)
    except MemoryShortError as error:
        print(f"{case.title or 'case'}: valid, but not for the memory that is here")
        print(f"particles        about {error.estimate.particles:.3g}")
        print(f"cells            {cells}, shape {case.method.shape}")
        report_memory(error.estimate, True)
        raise
    scene, bodies, rate, dt = known.scenes[0], known.found.bodies, known.rate, known.dt
    case = scene.case  # with the inertia of mass scaling
    count = int(known.counts.sum())
    print(
        f"{case.title or 'case'}: valid; {count:,} particles in {len(bodies)} "
        f"bod{'y' if len(bodies) == 1 else 'ies'}, {cells} cells, shape {case.method.shape}"
    )
    duration, quick = whole.time.last, scene.interaction.rigid_bodies.first_rate
    shown = bodies if verbose else bodies[:MOST_BODIES]
    for body in shown:
        report_body(body, case, whole.stages, verbose)
    if len(bodies) > len(shown):
        print(f"{'':<16} and {len(bodies) - len(shown)} more bodies (-v has them)")
    report_materials(written)
    report_rigid(scene, verbose)
    report_walls(case)
    for text in lines(whole):
        print(f"chosen           {text}")
    if text := old_words(whole):
        print(f"older words      {text}; --write puts in the new ones")
    report_inflow(case, known.entering, duration)
    chosen = ", chosen by pgimp" if case.watched else ""
    longest = f"; Courant 1 is {1.0 / rate:.4g}" if verbose else ""
    which = "each" if case.courant is None else "the first"
    first = f"{which} of {dt:.4g}, Courant {dt * rate:.3g}{chosen}{longest}"
    steps = float(case.time.steps or case.time.end / dt)
    costs = measure(scene, count, steps)
    tried = pilot(written, count, steps, costs, _thinnest(case, bodies)) if costs else None
    steps = report_steps(case, steps, tried, first)
    settling = [settling_steps(each, bodies) for each in whole.stages]
    report_settling(case, settling[0])
    to_rest = sum(settling, Settling())
    if whole.time.stages:
        # A pilot run does not settle.
        factor = 1.0 if case.start.equilibrate else steps * dt / case.time.end
        steps += report_stages(whole, known.scenes, factor, known.varied, settling)
    least, most = (
        forecast.frames(whole, steps, [one[k] for one in settling]) for k in range(len(to_rest))
    )
    size = size_text(most * forecast.frame_size(case, scene.fields, count))
    output = f"about {size}, in {most:,} frames"
    if most > least:
        output = f"up to {size}, in {least:,} to {most:,} frames"
    report_memory(known.memory, verbose, f"; output {output}")
    if costs:
        report_cost(scene, known.lattice, known.counts, costs, steps, to_rest, verbose)
    else:
        print("time             unknown: no step of a sample of the case could be timed")
    if verbose and costs:
        report_program(written, count)
    boxes = {body.name: (body.low, body.high) for body in bodies}
    # A warning has the step.
    if text := line([one for one in of_case(case, boxes) if one.name != "step"]):
        print(f"accuracy         {text}")
    poisson = {one.name: one.varies["poisson"][2] for one in bodies if "poisson" in one.varies}
    sent = impedance.sent(whole.stages, scene, bodies)
    no_result = case.time.mass_scaling != 1.0  # is meant to be slow
    for note in (
        *known.notes,
        *vertex_notes(written, count),
        *scaling_notes(case),
        *(one.text for one in sent if not (no_result and one.lasts)),
        *tool_edges.notes(scene, bodies, duration),
        *known_in_part(scene),
        *repose.notes(case, bodies),
        *nearness.notes(case),
        *bonds.bonded(scene, known.lattice, known.counts, touching=True),
        *stripes(case, poisson),
        *ordered_advice(case, bodies, known.crossing, dt, quick),
        *forecast.notes(whole, steps),
        *foreseen(whole),
    ):
        print(f"note: {note}")
    # Bodies of one material have the same warnings about it.
    every: Iterable[Warned] = chain(
        () if case.watched else stability_warning(dt, rate, stable_courant(case)),
        short_step_warnings(scene, bodies, dt, rate),
        known.of_stages,
        pilot_warnings(case, dt * rate, tried),
        *(body_warnings(case, body, duration, to_rest.high > 0.0) for body in bodies),
        *(tearing.warnings(whole.stages, body) for body in bodies),
        (warned("impedance", one.text) for one in sent if no_result and one.lasts),
        at_start(known.scenes, poisson),
        overstress.foresee(scene, known.lattice, known.counts),
        case_warnings(case, known.found),
        idle_warnings(known.found.later, known.found.held_later),
        (
            warned("bonded", text)
            for text in bonds.bonded(scene, known.lattice, known.counts, touching=False)
        ),
        series.warnings(whole),
        forecast.warnings(whole, steps),
    )
    for warning in dict.fromkeys(every):
        print(warning.line(verbose))


def _thinnest(case: Case, bodies: list[BodyFacts]) -> float:
    """Number of cells across the thinnest body."""
    return min(
        size / cell for one in bodies for size, cell in zip(one.sizes, case.grid.cell, strict=True)
    )
