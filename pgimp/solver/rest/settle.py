"""Settling: a run comes to rest under the loads of time 0, and only then begins; stages likewise.

In a stage after the first, simulated time stands still at its beginning, see `StandingClock`.
"""

from __future__ import annotations

from math import inf

import numpy as np

from pgimp.errors import NO_REST, NoRestError
from pgimp.kernels.data.ledger import INTERNAL, UNBALANCED
from pgimp.solver.configurations import fastest
from pgimp.solver.history.diagnostics import Diagnostics
from pgimp.solver.loads.grips import DISPLACEMENT
from pgimp.solver.rank import Rank
from pgimp.solver.rest.damping import EVERY, bring_to_rest, damping_of, damping_to_rest, total_sums
from pgimp.solver.start.start import Start
from pgimp.solver.time.clock import CourantClock, Step, clock_of


def at_time_zero(step: Step) -> Step:
    """Return a step of the run with the loads of time 0, which it does not leave."""
    return step._replace(start=0.0, end=0.0)


def is_due(step: int, since: int) -> bool:
    """Whether forces are compared after this step, the `since`-th of the start or the stage.

    Not after the first one: its forces are those of the stresses before, which follow the stage's
    strength only then.
    """
    return step % EVERY == 0 and since > 1


def unbalanced_part(rank: Rank) -> float:
    """Unbalanced force over the forces of stresses and tractions, sums of magnitudes; collective.

    Where stresses balance a traction, the sum over the vertices has neither: it is added.
    """
    sums = total_sums(rank)
    unbalanced, scale = float(sums[UNBALANCED]), float(sums[INTERNAL]) + _tractions(rank)
    if not unbalanced > 0.0:
        return 0.0
    return unbalanced / scale if scale > 0.0 else inf


def _tractions(rank: Rank) -> float:
    """Sum of the magnitudes of the particles' tractions; collective."""
    loads = rank.scene.interaction.loads.at(rank.scene.case.staged.start)
    if not (loads.tractions or loads.surfaces):
        return 0.0
    p, (rows, start) = rank.population.stored, rank.population.ordered
    sums = np.zeros(len(start) - 1)
    layer = np.repeat(np.arange(len(sums)), np.diff(start))
    for each in loads.tractions:
        force = float(np.sqrt(np.square(each.traction).sum())) + abs(each.pressure)
        np.add.at(sums, layer, force * p.patch[rows, each.column])
    for one in loads.surfaces:
        pressure = np.full(len(rows), one.pressure)
        for d in range(p.x.shape[1]):
            pressure += one.gradient[d] * p.x[rows, d]
        if any(one.gradient):
            pressure = np.maximum(pressure, 0.0)
        pressure = np.abs(pressure) + float(np.sqrt(np.square(one.traction).sum()))
        if one.profile:
            pressure *= np.abs(one.profile.factors(p.x[rows]))
        np.add.at(sums, layer, pressure * p.surface[rows, one.column])
    return float(np.concatenate(rank.comm.allgather(sums)).sum())


def begin_settling(start: Start) -> None:
    """Begin to come to rest, or go on with it."""
    start.settling, start.rank.damping = True, damping_to_rest(start.scene)
    start.scene.domain.settling = True


def require_rest(start: Start, part: float) -> None:
    """Refuse a run that has not come to rest in its number of steps; on every rank.

    Raises
    ------
    NoRestError
        If it has not.
    """
    settle, staged = start.case.start.settle, start.case.staged
    assert settle is not None
    steps = start.done.number - start.clock.before
    if steps >= settle.steps:
        key = f"time.stages.{staged.number - 1}.settle" if staged.number else "start.settle"
        most = f" ({settle.steps} at most, looked at every {EVERY})"
        looked = most if steps > settle.steps else ""
        raise NoRestError(
            f"{key}: {NO_REST} {steps} steps{looked}: the unbalanced force is "
            f"{part:.3g} of the forces of stresses and tractions, not {settle.tolerance:.3g}\n"
            f"  try: more steps ({key}.steps), a larger tolerance, another damping; look "
            "for parts that nothing holds, and for loads that no rest can bear"
        )


def end_at_rest(start: Start) -> Start:
    """End the settling: at time 0 the run begins, a later stage is done; collective."""
    return begin_at_rest(start) if start.stage == 0 else _rest(start)


def _rest(start: Start) -> Start:
    """Take all motion from a stage that has come to rest; collective.

    Stress, deformation, displacements and books stay.
    """
    bring_to_rest(start.rank)
    if start.rank.particles.q.shape[1]:
        start.rank.particles.q[:] = 0.0
    start.scene.domain.settling = start.settling = False
    return start


def begin_at_rest(start: Start) -> Start:
    """Begin the run at time 0 in the state that has been found; collective.

    Stress, deformation and what materials remember stay; velocities, books and displacements
    begin at zero. Bodies in the initial configuration keep their initial places, which their
    weights follow from, so that their displacements count from there.
    """
    rank, scene, comm = start.rank, start.scene, start.comm
    particles = rank.particles
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
    if start.watch:
        start.watch.begin(rank)
        start.watch.shorten(start.clock)
    return start
