"""One explicit time step, update stress last: the file to read first."""

from collections.abc import Callable
from time import perf_counter, thread_time
from typing import TYPE_CHECKING

import numpy as np

from pgimp.kernels.g2p import grid_to_particles
from pgimp.kernels.grips import hold_marked, mark
from pgimp.kernels.mirror import fold, reflect
from pgimp.kernels.momentum import update_momentum
from pgimp.kernels.p2g import particles_to_grid
from pgimp.solver.escapes import let_go
from pgimp.solver.faults import listed

if TYPE_CHECKING:
    from pgimp.kernels.loads import Loads
    from pgimp.solver.simulation import Simulation

#: Phases of a step, as `Simulation.timings` names them.
PHASES = ("P2G", "exchange", "momentum", "G2P", "migrate", "order")


def step(sim: "Simulation") -> tuple[float, float, int, float]:
    """Advance a rank's particles by one step; collective.

    Returns
    -------
    dt, end : float
        Length of the step and the time at its end.
    failed : int
        Number of the rank's particles at fault; they are listed in `sim.faults`.
    rate : float
        Largest (c_p + |v_p|)/L of the rank, if the step is controlled.

    Raises
    ------
    RunError
        On every rank, if particles of any were at fault in the step before, or if steps have
        become so short that the run would never end. The particles are as they were.
    """
    scene, grid, population, migration = sim.scene, sim.grid, sim.population, sim.migration
    shape, frame, particles, window = scene.shape, scene.frame, population.particles, grid.window
    order, start, movers = population.order, population.start, population.movers
    loads, relaxation = scene.loads.at(sim.time), scene.loads.relaxation
    lap = _stopwatch(sim.timings, sim.worked)

    sum_particles(sim, loads, bool(scene.loads.constraints))
    lap("P2G")

    sim.halo.finish(grid)
    sim.agree()  # on the step before: the greatest speed, and whether all went well
    dt, end = sim.clock.next(sim.rate)
    lap("exchange")

    grips, gravity = scene.loads.grips(sim.time, end), scene.gravity(sim.time)
    marked = (grips, grid.marks) if grips else ()
    for mirror in scene.mirrors:
        fold(
            frame, window, grid.G, grid.active, mirror, relaxation, dt, gravity,
            sim.owned_planes, sim.impulse,
        )  # fmt: skip
    faces, walls = sim.faces, sim.walls
    if scene.varies:
        faces, walls = scene.face_parameters(sim.time, end), scene.walls(end)
    update_momentum(  # (14, 17) and the boundary conditions
        frame, window, grid.G, grid.active, dt, gravity, sim.lightest, faces, marked, relaxation,
        sim.owned_planes, sim.impulse, sim.beyond, sim.work,
    )  # fmt: skip
    if marked:
        hold_marked(
            window, grid.G, grid.active, marked, relaxation, dt, gravity,
            sim.owned_planes, sim.grip_impulse, sim.work,
        )  # fmt: skip
    for mirror in reversed(scene.mirrors):
        reflect(
            frame, window, grid.G, grid.active, mirror, relaxation, dt, gravity,
            sim.owned_planes, sim.impulse, sim.work,
        )  # fmt: skip
    lap("momentum")

    rate, failed, leavers, found = 0.0, [], 0, 0
    for half, layers in enumerate(sim.halo.halves(start)):  # first what neighbours wait for
        wrong, left, moved, fastest, clamped, held = grid_to_particles(  # (26, 27, 29, 30)
            shape, scene.materials, frame, window, particles, loads, grips, order, start, layers,
            scene.material_of, grid.G, dt, scene.tracked, sim.clock.controlled, grid.bounds,
            scene.exits, walls, sim.reach, movers[found:], sim.fault_room[half],
            sim.grip_impulse, sim.impulse, sim.work,
        )  # fmt: skip
        failed.append(wrong)
        rate, leavers = max(rate, fastest), leavers + left
        sim.clamped += clamped
        sim.held += held
        lap("G2P")
        if moved or sim.slab.neighbours:
            migration.proceed(population, movers[found : found + moved])
            found += moved
            lap("migrate")
    sim.particle_steps += len(order)
    if sum(failed):
        sim.faults = listed(sim, failed)

    movers = movers[:found]
    if len(failed) > 1:
        movers.sort()
    if leavers:
        let_go(sim, movers)
    coming = movers
    if found or sim.slab.neighbours:
        coming = migration.receive(population)
    lap("migrate")

    if found or len(coming):
        population.restore_order(movers, coming)
    lap("order")
    return dt, end, sum(failed), rate


def sum_particles(sim: "Simulation", loads: "Loads", marked: bool) -> None:
    """Sum a rank's particles into its planes; `Halo.finish` adds what neighbours have."""
    scene, grid, population = sim.scene, sim.grid, sim.population
    start = population.start
    if sim.failed:  # what others do not know yet; such particles may be anywhere
        start = np.zeros_like(start)
    if marked:
        mark(
            scene.shape, scene.frame, grid.window, population.particles, population.order, start,
            grid.marks,
        )  # fmt: skip
    grid.active.fill(0)
    for part in sim.halo.parts(start):  # first what neighbours wait for
        particles_to_grid(  # (16, 17, 18, 21, 22)
            scene.shape, scene.frame, grid.window, population.particles, loads,
            population.order, start, part, grid.scratch, grid.G, grid.active, grid.aside,
            grid.below,
        )  # fmt: skip
        sim.halo.proceed(grid, marked)


def _stopwatch(timings: dict[str, float], worked: dict[str, float]) -> Callable[[str], None]:
    """Make what adds the time since it was last called to that of a phase.

    `worked`, unless it is the same as `timings`, is by the clock of the rank's own work.
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
