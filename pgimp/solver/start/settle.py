"""Settling: a run comes to rest under the loads of time 0, and only then begins; stages likewise.

Simulated time stands still meanwhile, see `StandingClock`; the damping is `Relaxation`.
"""

from __future__ import annotations

from math import fsum, hypot, inf

import numpy as np

from pgimp.case.start import Settle
from pgimp.errors import NO_REST, NoRestError
from pgimp.schema.time_functions import TimeFunction
from pgimp.solver.damping.damping import bring_to_rest, damping_of
from pgimp.solver.damping.relaxation import EVERY, Relaxation, unbalanced_sums
from pgimp.solver.damping.unrest import what_moves
from pgimp.solver.history.diagnostics import Diagnostics
from pgimp.solver.loads.grips import DISPLACEMENT
from pgimp.solver.particle_groups import fastest
from pgimp.solver.rank import Rank
from pgimp.solver.start.start import Start
from pgimp.solver.time.clock import CourantClock, Step, clock_of, settling_clock
from pgimp.solver.time.energy_watch import EnergyWatch

#: Steps after which the energy is watched. In the first ones damping takes most of the work of the
#: loads, and a part of that, of the order of the step, is not in the books.
CALM = 20

#: Part of the forces of stresses that counts as load where there is less.
STRESS_PART = 0.01

#: Part of the whole way that may be left, over the tolerance of forces.
LEFT = 10.0


def is_due(step: int, since: int) -> bool:
    """Whether forces are compared after this step, the `since`-th of the start or the stage.

    Not after the first one: its forces are those of the stresses before, which follow the stage's
    strength only then.
    """
    return step % EVERY == 0 and since > 1


def unbalanced_part(rank: Rank) -> float:
    """Unbalanced force over that of the loads and of what bears them; collective.

    Sums of magnitudes. What bears loads has their size, as in a column: with bending, or between
    smooth walls, stresses make forces many times as large, which say nothing of the motion. Where
    nothing but stress of the start acts, a hundredth of its forces counts.
    """
    unbalanced, internal = unbalanced_sums(rank)
    loads = _loads(rank)
    scale = max(2.0 * loads, STRESS_PART * internal) if loads is not None else internal
    if not unbalanced > 0.0:
        return 0.0
    return unbalanced / scale if scale > 0.0 else inf


def left_part(rank: Rank) -> float:
    """Part of the whole way that is left until the motion turns; none of what flows without end.

    The sum of forces hardly sees a soft mode beside a stiff one under a greater load.
    """
    assert isinstance(rank.damping, Relaxation)
    return 0.0 if rank.scene.settings.flows else rank.damping.left_part


def is_at_rest(rank: Rank, settle: Settle, steps: int, part: float, left: float) -> bool:
    """Whether forces balance and little of the way is left; forces alone where it does not turn."""
    assert isinstance(rank.damping, Relaxation)
    alone = rank.damping.stagnant or steps >= settle.steps
    return part < settle.tolerance and (alone or left < LEFT * settle.tolerance)


def _loads(rank: Rank) -> float | None:
    """Sum of the magnitudes of weights, tractions and given forces; collective.

    None with body forces, which are known within kernels only.
    """
    scene, t = rank.scene, rank.scene.case.staged.start
    given, loads = scene.interaction.loads, scene.interaction.loads.at(t)
    p, (rows, start) = rank.population.columns, rank.population.ordered
    gravity = np.array(scene.domain.gravity(t))
    force = float(np.sqrt(np.square(gravity).sum())) * p.m[rows]
    if scene.case.body_force is not None:
        return None
    if given.water is not None:
        force -= given.water.lift(p, int(rows.max(initial=-1)) + 1, t)[rows]
    force = np.abs(force)
    for each in loads.tractions:
        size = float(np.sqrt(np.square(each.traction).sum())) + abs(each.pressure)
        force += size * p.patch[rows, each.column]
    for one in loads.surfaces:
        pressure = np.full(len(rows), one.pressure)
        for d in range(p.x.shape[1]):
            pressure += one.gradient[d] * p.x[rows, d]
        if any(one.gradient):
            pressure = np.maximum(pressure, 0.0)
        pressure = np.abs(pressure) + float(np.sqrt(np.square(one.traction).sum()))
        if one.profile:
            pressure *= np.abs(one.profile.factors(p.x[rows]))
        force += pressure * p.surface[rows, one.column]
    own = np.add.reduceat(force, start[:-1][np.diff(start) > 0]) if len(rows) else force
    parts = np.concatenate(rank.comm.allgather(own)).tolist()
    for grip in given.constraints:
        along = [f.value(t) if isinstance(f, TimeFunction) else f or 0.0 for f in grip.forces]
        parts.append(hypot(*along))
    return fsum(parts)


def begin_settling(start: Start) -> None:
    """Begin to come to rest, or go on with it; the energy is watched, whatever the steps."""
    start.settling, start.rank.damping = True, Relaxation()
    start.scene.domain.settling = True
    if not start.stage:
        rate = start.clock.rest_rate if isinstance(start.clock, CourantClock) else inf
        start.clock = settling_clock(start.case, rate)
    if start.watch is None:
        start.watch = EnergyWatch(
            start.rate * min(start.scene.domain.frame.cell), start.case.method.stress
        )
        if start.rank.slaves:
            start.watch.part = start.rank.slaves.part
            start.watch.shorten(start.clock)


def require_rest(start: Start, part: float) -> None:
    """Refuse a run that does not come to rest; on every rank alike.

    Raises
    ------
    NoRestError
        If it has not in its number of steps, or if the unbalanced part no longer falls.
    """
    settle, staged, relaxation = start.case.start.equilibrate, start.case.staged, start.rank.damping
    assert settle is not None and isinstance(relaxation, Relaxation)
    steps = start.done.number - start.clock.before
    relaxation.note(part)
    if steps < settle.steps and not relaxation.stagnant:
        return
    key = f"time.stages.{staged.number - 1}.equilibrate" if staged.number else "start.equilibrate"
    most = f" ({settle.steps} at most, looked at every {EVERY})" if steps > settle.steps else ""
    text = (
        f"{key}: {NO_REST} {steps} steps{most}: the unbalanced force is {part:.3g} of the loads "
        f"and what bears them, not {settle.tolerance:.3g}"
    )
    if relaxation.stagnant:
        text += f"; it has not fallen in the last {relaxation.steps}, from {relaxation.least:.3g}"
    remedy = f"more steps ({key}.steps), or a larger tolerance"
    if relaxation.stagnant:
        remedy = f"{key}.tolerance: {min(1.5 * relaxation.least, 1.0):.1g}, if that is enough"
    raise NoRestError(f"{text}\n{what_moves(start.rank, relaxation.cycle)}\n  try: {remedy}")


def end_at_rest(start: Start) -> Start:
    """End the settling: at time 0 the run begins, a later stage is done; collective."""
    return begin_at_rest(start) if start.stage == 0 else _rest(start)


def _rest(start: Start) -> Start:
    """Take all motion from a stage that has come to rest; collective.

    Stress, deformation, displacements and books stay.
    """
    bring_to_rest(start.rank)
    if start.rank.up_to_date().q.shape[1]:
        start.rank.up_to_date().q[:] = 0.0
    start.scene.domain.settling = start.settling = False
    start.watch = start.watch if start.case.watched else None
    return start


def begin_at_rest(start: Start) -> Start:
    """Begin the run at time 0 in the state that has been found; collective.

    Stress, deformation and what materials remember stay; velocities, books and displacements
    begin at zero. Bodies in the initial configuration keep their initial places, which their
    weights follow from, so that their displacements count from there.
    """
    rank, scene, comm = start.rank, start.scene, start.comm
    particles = rank.up_to_date()
    bring_to_rest(rank)
    if particles.q.shape[1]:
        particles.q[:] = 0.0
    if particles.origin.shape[1]:
        rows = rank.live()
        rows = rows[~scene.settings.lagrangian[particles.body[rows]]]
        particles.origin[rows] = particles.x[rows]
    for sums in rank.ledger:
        sums[:] = 0.0
    if rank.grips:
        rank.grips.state[:, DISPLACEMENT] = 0.0
    rank.clamped = rank.held = 0
    rank.damping, scene.domain.settling = damping_of(scene), False
    start.diagnostic_sums, start.settling = Diagnostics(), False
    start.done = Step(start.done.number, 0.0, 0.0, 0.0)
    controlled = scene.settings.controlled or True
    rates = comm.allgather(fastest(scene, particles, rank.population.order, controlled))
    start.rate = max(rates)
    before = start.clock
    start.clock = clock_of(start.case, before=start.done.number)
    if isinstance(before, CourantClock) and isinstance(start.clock, CourantClock):
        start.clock.rest_rate = before.rest_rate
    start.watch = start.watch if start.case.watched else None
    if start.watch:
        start.watch.begin(rank)
        start.watch.shorten(start.clock)
    return start
