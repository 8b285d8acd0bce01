"""One explicit time step, update stress last: the file to read first."""

from collections.abc import Callable, Sequence
from functools import partial
from time import perf_counter, thread_time
from typing import Any

import numpy as np

from pgimp.kernels.contact.rigid_newton import find_rigid_impulses
from pgimp.kernels.data.arguments import Forcing, Report
from pgimp.kernels.data.ledger import Ledger
from pgimp.kernels.grid.constrained_vertices import mark_constrained_vertices
from pgimp.kernels.grid.constraints import apply_constraints
from pgimp.kernels.grid.mirror import fold, fold_volumes, reflect
from pgimp.kernels.grid.momentum import BEGINNING, REST, WHOLE, update_momentum
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.transfer.g2p import grid_to_particles
from pgimp.kernels.transfer.p2g import Others, particles_to_grid
from pgimp.solver.clock import Step
from pgimp.solver.parts import ConfigurationGroup, groups_by_configuration
from pgimp.solver.rank import Rank


def step(
    rank: Rank, start: float, begin: Callable[[], Step], controlled: bool | float
) -> tuple[Step, float]:
    """Advance a rank's particles by one step; collective.

    Parameters
    ----------
    rank : Rank
        The rank, which gets the number and a list of particles at fault.
    start : float
        Time at the beginning of the step.
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
        On every rank, as from `begin`. The particles are as they were.
    """
    scene, grid, population, migration = rank.scene, rank.grid, rank.population, rank.migration
    order, changed, parts = (
        population.ordered,
        population.changed,
        groups_by_configuration(scene, population),
    )
    loads, ledger, call = scene.loads.at(start), rank.ledger, rank.call
    lap = _stopwatch(rank.timings, rank.worked)

    if rank.meetings:
        rank.meetings.regroup(rank.grid, population)
        lap("contact")
    elif rank.present:
        rank.present.group(rank.grid, population)
    sum_particles(rank, parts, loads, bool(scene.loads.constraints))
    lap("P2G")

    rank.halo.finish(grid)
    field, t = grid.field, begin()
    lap("exchange")
    contact: Any = ()
    if rank.meetings:
        contact = rank.meetings.find(rank.grid, population, ledger, t.start, t.end)
        lap("contact")

    forcing = acting(rank, t, loads, controlled)
    faces, vertex_forcing = scene.face_parameters(t.start, t.end), on_vertices(forcing)
    fold_mirrors(rank, vertex_forcing, contact, ledger)
    update = partial(
        call, update_momentum, scene.frame, field, faces, vertex_forcing, ledger, contact
    )
    free = rank.meetings.free if rank.meetings else None
    if free is None:
        update(WHOLE)  # (14, 17)
    else:  # impulses and new velocities depend on each other: solve for both
        update(BEGINNING)
        respond = partial(
            call, find_rigid_impulses, contact, faces, scene.frame, field, vertex_forcing
        )
        free.solve_velocities(contact.rigid_bodies, grid, t, forcing.gravity, respond)
        update(REST)
        free.move(contact.rigid_bodies, grid, t.dt)
    if forcing.marked:
        call(apply_constraints, field, vertex_forcing, ledger)
    if rank.present:
        lap("momentum")
        rank.present.exchange(grid, population, ledger, t, vertex_forcing, faces)
        lap("contact")
    for mirror in reversed(scene.mirrors):
        call(reflect, scene.frame, field, mirror, vertex_forcing, ledger)
    lap("momentum")

    rate, outflow, found = 0.0, 0, 0
    failed: list[int] = []
    particle_forcing = on_particles(forcing)
    if rank.flows:
        filling = rank.flows.find(rank, parts[0].order, t)
        particle_forcing = particle_forcing._replace(filling=filling)
        lap("P2G")
    keepers = rank.keeping.at(t, population.particles, order.rows)
    particle_forcing = particle_forcing._replace(keepers=keepers)
    for layers in rank.halo.halves(order.start):  # first what neighbours wait for
        moved = 0
        for part, on_part in zip(parts, rank.calls, strict=True):
            mine = changed[found + moved :]
            report = Report(rank.vertex_bounds, mine, rank.error_buffer[len(failed)])
            wrong, left, away, fastest, clamped, held = on_part(  # (26, 27, 29, 30)
                grid_to_particles, part.setting, part.bounded(scene, field), population.particles,
                part.order, layers, part.forced(particle_forcing), report, ledger,
            )  # fmt: skip
            if away and part.places is not None:
                mine[:away] = part.places[mine[:away]]
            failed.append(wrong)
            rate, outflow, moved = max(rate, fastest), outflow + left, moved + away
            rank.clamped += clamped
            rank.held += held
        lap("G2P")
        if moved or rank.migrates:
            migration.proceed(population, changed[found : found + moved])
            found += moved
            lap("migrate")
    rank.keeping.finish(ledger, int(grid.window.lower[0]))
    rank.particle_steps += len(order.rows)
    if sum(failed):
        rank.list_errors(failed)

    changed = changed[:found]
    if len(failed) > len(parts):
        changed.sort()
    if outflow:
        rank.remove_outflow(changed)
    coming = changed
    if found or rank.migrates:
        coming = migration.receive(population)
    lap("migrate")

    if found or len(coming):
        population.restore_order(changed, coming)
    lap("order")
    return t, rate


def acting(rank: Rank, t: Step, loads: Loads, controlled: bool | float) -> Forcing:
    """Return the forcing of a step; see `step`."""
    scene, grid = rank.scene, rank.grid
    constraints = scene.loads.constraints_at(t.start, t.end)
    marked = (constraints, grid.marks) if constraints else ()
    return Forcing(
        t.dt, scene.gravity(t.start), rank.mass_cutoff, loads, constraints, marked,
        scene.walls(t.start, t.end), controlled, rank.clearances.stored(grid),
    )  # fmt: skip


def fold_mirrors(rank: Rank, forcing: Forcing, contact: Any, ledger: Ledger) -> None:
    """Fold the sums beyond faces that reflect; find the clearances of those that let go."""
    scene, field, call = rank.scene, rank.grid.field, rank.call
    for releases in (False, True):  # those that let go last: they see the sums of both
        for mirror in scene.mirrors:
            if mirror.releases == releases:
                call(fold, scene.frame, field, mirror, forcing, ledger)
                if contact:
                    call(fold_volumes, scene.frame, field, contact.volumes, mirror)
        if not releases:
            rank.clearances.find(rank.grid)


def on_vertices(forcing: Forcing) -> Forcing:
    """The forcing without particle-only loads.

    Kernels that work on vertices are then compiled once for all kinds of loads.
    """
    loads = Loads(relaxation=forcing.loads.relaxation)
    return forcing._replace(loads=loads, constraints=(), controlled=False)


def on_particles(forcing: Forcing) -> Forcing:
    """The forcing without vertex-only loads; see `on_vertices`."""
    return forcing._replace(loads=forcing.loads._replace(walls=()), marked=(), clearances=())


def sum_particles(
    rank: Rank, parts: Sequence[ConfigurationGroup], loads: Loads, marked: bool
) -> None:
    """Sum a rank's particles into its planes; `Halo.finish` adds what neighbours have."""
    grid, particles, every = rank.grid, rank.particles, []
    for part in parts:
        order = part.order
        if rank.failed:  # others do not know of it yet; such particles may be anywhere
            order = order._replace(start=np.zeros_like(order.start))
        every.append((part.setting.without_materials(), part.loaded(loads.summed()), order))
    if marked:
        grid.marks.fill(0)
        for call, (setting, _, order) in zip(rank.calls, every, strict=True):
            call(mark_constrained_vertices, setting, grid.window, particles, order, grid.marks)
    (setting, summed, order), others = every[0], Others(*every[1]) if len(every) > 1 else ()
    grid.active.fill(0)
    for runs in rank.halo.parts(rank.population.start):  # first what neighbours wait for
        rank.call(  # (16, 17, 18, 21, 22)
            particles_to_grid, setting, grid.field, particles, summed, order, runs, others
        )
        rank.halo.proceed(grid, marked)


def _stopwatch(timings: dict[str, float], worked: dict[str, float]) -> Callable[[str], None]:
    """Return a function that adds the time since its last call to that of a phase.

    `worked`, unless it is the same as `timings`, gets the rank's own CPU time.
    """
    last = perf_counter()
    last_own = thread_time() if worked is not timings else 0.0

    def lap(phase: str) -> None:
        nonlocal last, last_own
        now = perf_counter()
        timings[phase] += now - last
        last = now
        if worked is not timings:
            own = thread_time()
            worked[phase] += own - last_own
            last_own = own

    return lap
