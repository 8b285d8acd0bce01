"""One explicit time step, update stress last: the file to read first."""

from __future__ import annotations

from collections.abc import Callable

from pgimp.solver.completion import send_particles, settle
from pgimp.solver.configurations import groups_by_configuration
from pgimp.solver.rank import Rank
from pgimp.solver.time.clock import Step
from pgimp.solver.transfers import (
    RangeReport,
    finish_sums,
    particle_forcing,
    sum_particles,
    update_particles,
)
from pgimp.solver.vertices import (
    VertexUpdate,
    fold_mirrors,
    hold_constrained,
    keep_vertex_motion,
    reflect_mirrors,
    vertex_forcing,
)


def step(
    rank: Rank, before: Step, begin: Callable[[], Step], controlled: bool | float
) -> tuple[Step, float]:
    """Advance a rank's particles by one step; collective.

    Equation numbers are from Bardenhagen & Kober (2004).

    Parameters
    ----------
    rank : Rank
        The rank; it receives count and list of its particles at fault.
    before : Step
        The step before; its end is the time at the beginning.
    begin : callable
        Completes the reduction of the step before, and returns this step.
    controlled : bool or float
        Whether to find the greatest speed, see `pgimp.kernels.update.pace`.

    Returns
    -------
    Step
        The step.
    float
        Largest (c_p + |v_p|)/L of the rank, if `controlled`.

    Raises
    ------
    RunError
        On every rank, as from `begin`. The particles are unchanged.
    """
    scene, contact, lap = rank.scene, rank.contact, rank.stopwatch()
    loads, groups = (
        scene.interaction.loads.at(before.end),
        groups_by_configuration(scene, rank.population),
    )
    contact.assign_fields(rank)
    lap("contact")
    if rank.following:
        rank.following.find(rank, groups[0].order, before.number)
        lap("P2G")
    if damping := rank.damping:
        damping.rest_at_peak(rank)
    marked = bool(scene.interaction.loads.constraints)
    sum_particles(rank, groups, loads, marked, by_cells=True)  # (16, 17, 18, 21, 22)
    lap("P2G")
    finish_sums(rank, marked)
    t = begin()
    lap("exchange")

    faces = scene.domain.face_parameters(t.start, t.end)
    update = VertexUpdate(t, faces, vertex_forcing(rank, t, loads), rank.ledger)
    contact.detect(rank, t, rank.ledger)
    lap("contact")
    fold_mirrors(rank, update)
    if absorbing := rank.absorbing:
        absorbing.add_forces(rank, update)
    if damping:
        damping.add_forces(rank, update)
    contact.update_momentum(rank, update)  # (14, 17)
    update = hold_constrained(rank, update)
    lap("momentum")
    contact.exchange(rank, update)
    if rank.grips:
        rank.grips.bear(rank)
    lap("contact")
    if damping:
        damping.book(rank, update)
    if absorbing:
        absorbing.book(rank, update)
    reflect_mirrors(rank, update)
    keep_vertex_motion(rank, update)
    lap("momentum")

    forcing = particle_forcing(rank, groups, update, loads, controlled)
    lap("P2G")
    reports: list[RangeReport] = []
    for layers in rank.halo.halves(rank.population.start):  # first the layers neighbours wait for
        reports.append(update_particles(rank, groups, forcing, layers, reports))
        lap("G2P")  # (26, 27, 29, 30)
        send_particles(rank, reports[-1])
        lap("migrate")
    settle(rank, reports, lap)
    return t, max(report.rate for report in reports)
