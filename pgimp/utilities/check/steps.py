"""Report on the number of steps of a case: predicted by a pilot run, and stage by stage."""

from collections.abc import Iterator, Mapping, Sequence
from math import ceil

from pgimp.case.choices.beyond import beyond
from pgimp.case.schema import Case
from pgimp.case.staging.arrange import changes_of, steps_in
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.sanity import LEAST_COURANT, small_step_warning
from pgimp.scene.checks.warned import Warned, warned
from pgimp.scene.scene import Scene
from pgimp.solver.start.validate_stages import stage_rate
from pgimp.solver.time.limiting import limiting
from pgimp.solver.time.stability import stable_courant
from pgimp.utilities.check.settling import Settling
from pgimp.utilities.model.pilot import Pilot

#: Relative error up to which a number of steps is only "about".
_CLOSE = 0.1


def report_steps(case: Case, steps: float, tried: Pilot | None, first: str) -> float:
    """Print and return the number of steps, predicted if they follow the fastest wave.

    `first` describes the first step.
    """
    if case.time.steps is not None:
        print(f"steps            {case.time.steps:,} to t = {case.time.end:g}; {first}")
        return steps
    start = f"{ceil(steps * (1.0 - 1e-9)):,}"
    if tried is None:
        print(
            f"steps            {start} to t = {case.time.end:g} if no wave becomes faster; more if "
            f"the material is compressed: no pilot run can be made of this case; {first}"
        )
        return steps
    print(f"steps            {predicted(case, tried)}; {start} if no wave became faster; {first}")
    return tried.steps


def report_settling(case: Case, settling: Settling) -> None:
    """Say in how many steps the start may come to rest; they are not among those reported."""
    if case.start.equilibrate:
        print(
            f"settling         before, at t = 0, by estimate in {settling.text()} steps, at most "
            f"{case.start.equilibrate.steps:,}; they are not among those above, and write "
            "checkpoints alone"
        )


def report_stages(
    case: Case,
    scenes: Sequence[Scene],
    factor: float,
    varied: Mapping[str, float],
    settling: Sequence[Settling],
) -> float:
    """Describe the changes by the stages after the first; return their approximate steps.

    `factor` is the number of the first stage's steps over the number at rest, if waves set their
    length. `varied` has rates of bodies whose materials vary, see `stage_rate`; `settling` the
    steps to rest of all stages.
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
        if stage.equilibrate:
            print(
                f"stage {one.staged.number + 1:<10} '{stage.name}' settles at t = "
                f"{one.time.end:g}, by estimate in {settling[one.staged.number].text()} steps, "
                f"at most {stage.equilibrate.steps:,}; changes {what}"
            )
            continue
        print(
            f"stage {one.staged.number + 1:<10} '{stage.name}' to t = {stage.end:g}, "
            f"{about}{steps:,} step{'' if steps == 1 else 's'}; changes {what}"
        )
    return total


def short_step_warnings(
    scene: Scene, bodies: Sequence[BodyFacts], dt: float, rate: float
) -> Iterator[Warned]:
    """Yield what makes the first step far shorter than waves need.

    `rate` is the largest (c_p + |v_p|)/L of `bodies`, 1/time.
    """
    case, waves = scene.case, max(body.rest_rate for body in bodies)
    quick = max(rate, scene.interaction.rigid_bodies.first_rate)
    if case.courant is None or case.courant < LEAST_COURANT:
        yield from small_step_warning(dt, quick)
    elif dt * waves < LEAST_COURANT and dt < case.time.end:
        limit = limiting(scene, quick)
        yield warned(
            "short-step",
            f"time.step: the first of {dt:.4g} is short because {limit.what} crosses "
            f"{limit.rate:.3g} cells in a unit of time, where waves cross {waves:.3g}; look at its "
            f"velocity ({limit.key}): is it in the units of young, density and grid?",
        )


def predicted(case: Case, tried: Pilot) -> str:
    """Describe the number of steps predicted by a pilot run, and its assumptions."""
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
    """Describe the size of a pilot run."""
    text = f"{tried.particles:,} particles"
    if tried.factor > 1.0 + 1e-9:
        text += f" in cells {tried.factor:.3g} times as long"
    return text


def pilot_warnings(case: Case, courant: float, tried: Pilot | None) -> Iterator[Warned]:
    """Yield failures of a pilot run that a run may have, too."""
    if tried is None:
        return
    if tried.failure:
        yield warned(
            "pilot-failed",
            f"a pilot run of {_size(tried)} failed at t = {tried.done * case.time.end:.3g}: "
            f"{tried.failure}",
        )
    for name, strain in tried.strains.items():
        if better := beyond(case, name, strain):
            yield warned(
                "chosen-strain",
                f"bodies.{name}: a pilot run of {_size(tried)} strains it by {strain:.2g}, more "
                f"than its method was chosen for: take {better}",
            )
    stable = stable_courant(case)
    if courant <= stable * (1.0 + 1e-9) < tried.courant and not tried.failure:
        yield warned(
            "pilot-step",
            f"time.step: its Courant number grows from {courant:.3g} to {tried.courant:.3g} in a "
            f"pilot run, as waves or particles become faster; above {stable:g} a free surface may "
            "become unstable with this shape",
        )
