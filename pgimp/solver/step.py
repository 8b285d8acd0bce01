"""One explicit time step, update stress last: the file to read first."""

from time import perf_counter
from typing import TYPE_CHECKING

from pgimp.kernels.g2p import grid_to_particles
from pgimp.kernels.grips import hold_marked, mark
from pgimp.kernels.mirror import fold, reflect
from pgimp.kernels.momentum import update_momentum
from pgimp.kernels.p2g import particles_to_grid
from pgimp.solver.escapes import let_go

if TYPE_CHECKING:
    from pgimp.kernels.loads import Loads
    from pgimp.solver.simulation import Simulation

#: Phases of a step, as `Simulation.timings` names them.
PHASES = ("P2G", "exchange", "momentum", "G2P", "migrate", "order")


def step(sim: "Simulation", dt: float, end: float) -> tuple[int, float]:
    """Advance a rank's particles to time `end`, `dt` away.

    Returns
    -------
    failed : int
        Number of the rank's particles at fault; they are listed in `sim.faults`.
    rate : float
        Largest (c_p + |v_p|)/L of the rank, if the step is controlled.
    """
    scene, grid, population = sim.scene, sim.grid, sim.population
    shape, frame, particles, window = scene.shape, scene.frame, population.particles, grid.window
    order, start = population.order, population.start
    loads, grips = scene.loads.at(sim.time), scene.loads.grips(sim.time, end)
    times = [perf_counter()]

    if grips:
        mark(shape, frame, window, particles, order, start, grid.marks)
    sum_particles(sim, loads, bool(grips))
    times.append(perf_counter())

    sim.halo.finish(grid)
    times.append(perf_counter())

    gravity = scene.gravity(sim.time)
    for mirror in scene.mirrors:
        fold(frame, window, grid.G, grid.active, mirror, dt, gravity, sim.owned_planes, sim.impulse)
    faces = sim.faces if not scene.varies else scene.face_parameters(sim.time, end)
    update_momentum(  # (14, 17) and the boundary conditions
        frame, window, grid.G, grid.active, dt, gravity, sim.lightest, faces,
        sim.owned_planes, sim.impulse, sim.beyond, sim.work,
    )  # fmt: skip
    if grips:
        hold_marked(
            window, grid.G, grid.active, grid.marks, grips, dt,
            sim.owned_planes, sim.grip_impulse, sim.work,
        )  # fmt: skip
    for mirror in reversed(scene.mirrors):
        reflect(
            frame, window, grid.G, grid.active, mirror, dt, gravity,
            sim.owned_planes, sim.impulse, sim.work,
        )  # fmt: skip
    times.append(perf_counter())

    failed, leavers, found, rate, clamped = grid_to_particles(  # (26, 27, 29, 30)
        shape, scene.materials, frame, window, particles, loads, grips, order, start,
        scene.material_of, grid.G, dt, scene.tracked, sim.clock.controlled,
        grid.bounds, scene.exits, sim.reach, population.movers, sim.faults, sim.grip_impulse,
        sim.work,
    )  # fmt: skip
    times.append(perf_counter())

    sim.clamped += clamped
    sim.particle_steps += len(order)
    movers = population.movers[:found]
    coming = movers
    if found or sim.slab.neighbours:
        if leavers:
            let_go(sim, movers)
        sim.migration.send(population, movers)
        coming = sim.migration.receive(population)
    times.append(perf_counter())

    if found or len(coming):
        population.restore_order(movers, coming)
    times.append(perf_counter())

    for phase, begin, finish in zip(PHASES, times, times[1:], strict=False):
        sim.timings[phase] += finish - begin
    return failed, rate


def sum_particles(sim: "Simulation", loads: "Loads", marked: bool) -> None:
    """Sum a rank's particles into its planes; `Halo.finish` adds what neighbours have."""
    scene, grid, population = sim.scene, sim.grid, sim.population
    grid.active.fill(0)
    for part in sim.halo.parts(population.start):  # first what neighbours wait for
        particles_to_grid(  # (16, 17, 18, 21, 22)
            scene.shape, scene.frame, grid.window, population.particles, loads,
            population.order, population.start, part,
            grid.scratch, grid.G, grid.active, grid.aside, grid.below,
        )  # fmt: skip
        sim.halo.proceed(grid, marked)
