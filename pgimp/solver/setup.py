"""Set-up of a simulation up to its first step: from its case, or from a checkpoint.

Errors are reported as early as possible, above all before kernels are compiled. Errors of the case
come first, then of its particles, then of the first step given their wave speeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.locations import located
from pgimp.decomposition.slabs import Slab
from pgimp.jit.compiled.cache import messages, problems
from pgimp.jit.kernel import FOLDER
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.once.prestress import remember_stress
from pgimp.mpi.communicator import Communicator
from pgimp.scene.bodies.initial_stress import set_initial_stress
from pgimp.scene.bodies.populate import prestressed
from pgimp.scene.checks import overstress
from pgimp.scene.checks.at_start import at_start
from pgimp.scene.checks.later_constraints import held, idle_warnings, later_constraints
from pgimp.scene.checks.locking import stripes
from pgimp.scene.geometry import release, take_as_empty
from pgimp.scene.rigid.checks import require_apart, require_clear, require_same, require_slow
from pgimp.scene.scene import Scene
from pgimp.scene.wave_speeds import rest_rate
from pgimp.solver.damping.relaxation import Relaxation
from pgimp.solver.decomposition import bring_home, open_window
from pgimp.solver.particle_groups import fastest
from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction
from pgimp.solver.start.continued import continue_motion
from pgimp.solver.start.created import create_start, decompose
from pgimp.solver.start.creation import LIGHT, Creation
from pgimp.solver.start.require_memory import require
from pgimp.solver.start.settle import begin_settling
from pgimp.solver.start.sound import require_light, require_particles
from pgimp.solver.start.start import Start
from pgimp.solver.start.validate_stages import rates_at_rest, require_stable_stages
from pgimp.solver.start.warmup import warm_up
from pgimp.solver.state.restore import outline, read_books, read_motion, read_particles
from pgimp.solver.state.state import State
from pgimp.solver.state.vertex_motion import begin_motion
from pgimp.solver.time.clock import CourantClock, clock_of
from pgimp.solver.time.energy_watch import EnergyWatch
from pgimp.solver.time.stability import check_first_step, require_end

if TYPE_CHECKING:
    from pgimp.io.checkpoints.checkpointfile import CheckpointFile


def begin(
    scenes: Sequence[Scene], comm: Communicator, reduction: StepReduction, creation: Creation
) -> Start:
    """Create the particles of the case, and check its first step; collective.

    Parameters
    ----------
    scenes : sequence of Scene
        The scenes of all stages.
    reduction : StepReduction
        The reduction of the run.
    creation : Creation
        Creates the particles.

    Raises
    ------
    CaseError
        On every rank, for errors that show only in the particles.
    """
    scene = scenes[0]
    start = Start(scene, comm, reduction)
    slab, particles, count, numbered = create_start(start, scenes, creation)

    # What the particles show, before kernels are compiled.
    require_particles(scene, particles, count, comm)
    start.warnings += _idle_constraints(scenes, comm, particles, count)
    _require_clear_bodies(scene, comm, particles, count)
    _compile(start, scenes[1:], 0)

    # The state at the start: of particles, then of the vertices and grips that go on from theirs.
    if scene.case.start.stress is not None:
        set_initial_stress(scene, particles, count, comm, scene.case.start.stress)
    particles, count = bring_home(scene, slab, comm, particles, count)
    if bodies := prestressed(scene):
        rows = np.flatnonzero(np.isin(particles.body[:count], bodies))
        remember_stress(scene.setting.without_shape(), particles, rows)
    start.warnings += overstress.measure(scene, particles, count, comm)
    put_in_order(start, slab, particles, count, numbered)
    begin_motion(start.rank)
    continue_motion(start.rank)
    if start.rank.slaves:
        start.notes += start.rank.slaves.notes()
    if start.rank.grips:
        start.rank.grips.start(start.rank)

    # Warnings, and the first step.
    if len(scenes) > 1 and scene.materials.variations:
        require_stable_stages(scenes, rates_at_rest(start.rank, scene, comm))
    start.warnings += at_start(scenes)
    start.notes += stripes(start.case)
    release(start.case)
    stable = max(start.rate, start.rank.parts_rate)
    rate = max(stable, scene.interaction.rigid_bodies.first_rate)
    with located(start.case):
        require_end(scene, rate)
        if start.watch and start.rank.slaves:
            start.watch.part = start.rank.slaves.part
            start.watch.shorten(start.clock)
        dt = start.clock.next(start.done, rate).dt
        start.warnings += check_first_step(scene, dt, stable)
        if start.rank.slaves:
            start.rank.slaves.require_stable(start.rate * dt)
    require_slow(scene.interaction.rigid_bodies, dt)
    if scene.settings.settles:
        begin_settling(start)
    if start.watch:
        start.watch.begin(start.rank)
    return start


def _idle_constraints(
    scenes: Sequence[Scene], comm: Communicator, particles: Particles, count: int
) -> Sequence[str]:
    """Warnings about constraints of later stages that would hold nothing; collective."""
    later = later_constraints([each.case for each in scenes])
    if not later:
        return []
    mine = held(later, particles.body[:count], particles.x[:count])
    return idle_warnings(later, np.sum(comm.allgather(mine), axis=0))


def _require_clear_bodies(
    scene: Scene, comm: Communicator, particles: Particles, count: int
) -> None:
    """Refuse rigid bodies that overlap particles, each other or walls; collective."""
    bodies = scene.interaction.rigid_bodies
    if bodies:
        require_apart(bodies, [(particles.x[:count], particles.body[:count])], comm)
        require_clear(bodies, scene.domain.faces, bodies.first, 0, 0.0, comm)


def resume(
    scenes: Sequence[Scene],
    comm: Communicator,
    reduction: StepReduction,
    source: CheckpointFile,
    now: State,
) -> Start:
    """Restore the state of a checkpoint; collective.

    Parameters
    ----------
    scenes : sequence of Scene
        The scenes of all stages.
    reduction : StepReduction
        The reduction of the run.
    now : State
        Its stage, and the steps before the first one of its clock.

    Raises
    ------
    DamagedError
        On every rank, if it does not hold a state of this case.
    """
    scene = scenes[now.stage]
    start = Start(scene, comm, reduction, stage=now.stage)
    take_as_empty(start.case, comm)
    require(scene, comm, source.count)
    scene.interaction.rigid_bodies.measure(comm)
    _compile(start, scenes[now.stage + 1 :], now.counted)
    state, layers = outline(scene, source, comm)
    require_same(scene.interaction.rigid_bodies, state.rigid_bodies)
    if state.densest is not None:
        scene.materials.weigh(state.densest)
    slab = decompose(start, layers)
    particles, count, edges = read_particles(scene, slab, source, state, layers, comm)
    put_in_order(start, slab, particles, count, state.count, edges)
    read_books(start.rank, source, state, start.diagnostic_sums)
    read_motion(start.rank, source)
    start.rate = state.rate
    if state.settling:
        begin_settling(start)
        if state.relaxation and isinstance(start.rank.damping, Relaxation):
            start.rank.damping.numbers = state.relaxation
    start.done = start.clock.after(state.step, state.time, state.dt)
    if start.clock.held and state.held_rate:  # an older checkpoint has none: a window begins
        start.clock.held.numbers = state.held_rate
    if start.watch:
        if state.watch is None:  # the run began with other steps
            start.watch.begin(start.rank)
        else:
            start.watch.numbers = state.watch
        start.watch.shorten(start.clock)
    release(start.case)  # where bodies meet their surfaces are needed
    return start


def _compile(start: Start, later: Sequence[Scene], counted: int) -> None:
    """Compile the kernels of this stage and of later ones, and start the clock; collective."""
    scene, comm = start.scene, start.comm
    warm_up(scene, comm)
    for each in later:  # none waits for the compiler then, or fails in it
        take_as_empty(each.case, comm)
        each.interaction.rigid_bodies.borrow(scene.interaction.rigid_bodies)
        warm_up(each, comm)
    rate = max(rest_rate(scene, body) for body in range(len(scene.body_names)))
    start.clock = clock_of(start.case, rate, counted)
    start.watch = (
        EnergyWatch(rate * min(scene.domain.frame.cell), start.case.method.stress)
        if start.case.watched
        else None
    )
    # Messages of the ranks about the cache on their nodes, each once.
    said = comm.allgather((problems(), FOLDER.warning))
    start.notes[:0] = messages(found for found, _ in said)
    start.warnings += dict.fromkeys(warning for _, warning in said if warning)


def put_in_order(
    start: Start,
    slab: Slab,
    particles: Particles,
    count: int,
    numbered: int,
    layers: np.ndarray | None = None,
) -> None:
    """Create a rank from its particles, which are put in order; collective.

    Parameters
    ----------
    start : Start
        State with compiled kernels; it gets the rank and its rate.
    slab : Slab
        This rank's.
    particles, count : Particles, int
        The particles of the slab, and their number.
    numbered : int
        Particles that all ranks have had so far.
    layers : (layers + 1,) int64, optional
        Beginnings of the layers; with it the particles are in order and have all their columns.

    Raises
    ------
    CaseError
        On every rank, if they weigh more than the domain can hold.
    """
    scene, comm = start.scene, start.comm
    mine = particles.m[:count]
    dense = (
        float((mine / particles.V0[:count]).max(initial=0.0)) if scene.materials.variations else 0.0
    )
    masses = comm.allgather((float(mine.min(initial=np.inf)), float(mine.sum()), dense))
    if scene.materials.variations and scene.materials.densest is None:
        scene.materials.weigh(max(dense for _, _, dense in masses))
    require_light(scene, sum(mass for _, mass, _ in masses))
    start.rank = rank = Rank(scene, comm, slab, particles, count, layers)
    rank.numbered, rank.mass_cutoff = numbered, LIGHT * min(least for least, _, _ in masses)
    start.balance.watch(count)
    open_window(rank, start.reduction)
    if layers is None:
        scene.interaction.loads.scale_patches(rank.population, comm)
    order, controlled = rank.population.order, scene.settings.controlled or True
    start.rate = max(comm.allgather(fastest(scene, rank.up_to_date(), order, controlled)))
    if (
        scene.materials.variations
    ):  # waves at rest are the particles', far from which typical ones may be
        if isinstance(start.clock, CourantClock):
            start.clock.rest_rate = start.rate or np.inf
        if start.watch:
            start.watch.speed = start.rate * min(scene.domain.frame.cell)
