"""One explicit time step, update stress last by default: the file to read first."""

from __future__ import annotations

from collections.abc import Callable

from pgimp.solver.completion import advance_particles, complete_step
from pgimp.solver.particle_groups import groups_of
from pgimp.solver.parts import parts_of
from pgimp.solver.rank import Rank
from pgimp.solver.time.clock import Step
from pgimp.solver.transfers import finish_sums, particle_forcing, sum_particles
from pgimp.solver.vertices import (
    fold_mirrors,
    hold_constrained,
    keep_vertex_motion,
    move_slaves,
    reflect_mirrors,
    vertex_update,
)


def step(
    rank: Rank, before: Step, next_step: Callable[[], Step], controlled: bool | float
) -> tuple[Step, float]:
    """Advance a rank's particles by one step; collective.

    Equation numbers are from Bardenhagen & Kober (2004).

    Parameters
    ----------
    rank : Rank
        The rank; it receives count and list of its particles at fault.
    before : Step
        The step before; its end is the time at the beginning.
    next_step : callable
        Completes the reduction of the step before, and returns this step.
    controlled : bool or float
        Whether to find the greatest speed; a number weights |v|, see `pgimp.kernels.update.pace`.

    Returns
    -------
    Step
        The step.
    float
        Largest (c_p + |v_p|)/L of the rank, if `controlled`.

    Raises
    ------
    RunError
        On every rank, as from `next_step`. The particles are unchanged.
    """
    scene, contact, lap = rank.scene, rank.contact, rank.stopwatch()
    loads, parts = scene.interaction.loads.at(before.end), parts_of(rank)
    groups = groups_of(rank, by_cells=True)
    contact.assign_fields(rank)
    lap("contact")
    for part in parts:
        part.begin(rank, groups[0].order, before.number)
    marked = bool(scene.interaction.loads.constraints)
    sum_particles(rank, groups, loads, marked)  # (16, 17, 18, 21, 22)
    lap("P2G")
    finish_sums(rank, groups, marked)  # the neighbours' sums, and both copies at periodic seams
    t = next_step()
    lap("exchange")

    update = vertex_update(rank, t, loads)
    contact.detect(rank, t, rank.ledger)
    lap("contact")
    for part in parts:
        part.strain(rank, groups, update, loads)  # the first half of it, or none
    fold_mirrors(rank, update)
    for part in parts:
        part.add_forces(rank, update)
    contact.update_momentum(rank, update)  # (14, 17)
    update = hold_constrained(rank, update)
    lap("momentum")
    contact.exchange(rank, update)  # in the initial configuration
    lap("contact")
    for part in parts:
        part.slow(rank, update)
    move_slaves(rank)
    for part in parts:
        part.book(rank, update)
    reflect_mirrors(rank, update)
    keep_vertex_motion(rank, update)
    lap("momentum")

    forcing = particle_forcing(rank, update, loads, controlled)
    for part in parts:
        forcing = part.force_particles(rank, groups[0].order, t, forcing)
    lap("P2G")
    reports = advance_particles(rank, groups, forcing, lap)  # (26, 27, 29, 30)
    for part in parts:
        part.complete(rank)
    complete_step(rank, reports, lap)
    for part in parts:
        part.change_particles(rank, t)
    lap("order")
    return t, max(report.rate for report in reports)
