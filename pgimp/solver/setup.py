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
from pgimp.errors import CaseError
from pgimp.jit.compiled.cache import messages, problems
from pgimp.jit.kernel import FOLDER
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.once.prestress import remember_stress
from pgimp.kernels.order.order import layers_of
from pgimp.mpi.collective import all_or_none
from pgimp.mpi.communicator import Communicator
from pgimp.scene.bodies.initial_stress import set_initial_stress
from pgimp.scene.bodies.populate import prestressed
from pgimp.scene.checks import nearness, overstress
from pgimp.scene.checks.facts import rest_rate
from pgimp.scene.checks.later_constraints import held, idle_warnings, later_constraints
from pgimp.scene.checks.locking import locking, stripes
from pgimp.scene.checks.quiet import unquiet
from pgimp.scene.geometry import release, share, take_as_empty
from pgimp.scene.mass_scaling import scaling_notes
from pgimp.scene.rigid.checks import require_apart, require_clear, require_same, require_slow
from pgimp.scene.rigid.warnings import motion_warnings
from pgimp.scene.scene import Scene, count_particles, present
from pgimp.solver.coming.inflow import most_at_once, to_enter
from pgimp.solver.configurations import fastest
from pgimp.solver.decomposition import bring_home, create_particles, partition, ring_counts
from pgimp.solver.lagrangian.motion import begin_motion
from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction
from pgimp.solver.rest.relaxation import Relaxation
from pgimp.solver.rest.settle import begin_settling
from pgimp.solver.start.continued import continue_motion, verify_checkpoints
from pgimp.solver.start.creation import LIGHT, Creation
from pgimp.solver.start.require_memory import require
from pgimp.solver.start.sound import require_light, require_particles
from pgimp.solver.start.start import Start
from pgimp.solver.start.validate_stages import rates_at_rest, require_stable_stages
from pgimp.solver.start.warmup import warm_up
from pgimp.solver.state.restore import outline, read_books, read_motion, read_particles
from pgimp.solver.state.state import State
from pgimp.solver.time.clock import CourantClock, clock_of
from pgimp.solver.time.energy_watch import EnergyWatch
from pgimp.solver.time.stability import check_first_step, require_end
from pgimp.solver.window import open_window

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
    comm : communicator
        Of all ranks.
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
    verify_checkpoints(scene, comm)
    share(start.case, comm)
    require(scene, comm)
    scene.interaction.rigid_bodies.measure(comm, keep=True)
    lattice, counts, notes = count_particles(scene, comm)
    start.notes += notes
    entering = to_enter(scene.case, counts, scenes[-1].case.time.end)
    require(scene, comm, most_at_once(scene.case, counts, entering))
    counts = present(scene, counts)
    start.count = int(counts.sum())
    layer = np.empty(len(lattice.coordinates[0]), np.int64)
    layers_of(
        scene.settings.shape,
        scene.order_frame,
        scene.setting.identity,
        lattice.coordinates[0],
        layer,
    )
    on_lattice = np.bincount(layer, counts.sum(axis=0), scene.domain.frame.vertices[0])
    slab = _decompose(start, ring_counts(scene, creation.layer_counts(on_lattice)))
    particles, count = create_particles(
        scene,
        slab,
        comm,
        lambda own: all_or_none(
            comm, lambda: creation.create(own, lattice, counts, layer), CaseError
        ),
    )
    require_particles(scene, particles, count, comm)
    if later := later_constraints([each.case for each in scenes]):
        mine = held(later, particles.body[:count], particles.x[:count])
        start.warnings += idle_warnings(later, np.sum(comm.allgather(mine), axis=0))
    if scene.interaction.rigid_bodies:
        require_apart(
            scene.interaction.rigid_bodies, [(particles.x[:count], particles.body[:count])], comm
        )
        require_clear(
            scene.interaction.rigid_bodies,
            scene.domain.faces,
            scene.interaction.rigid_bodies.first,
            0,
            0.0,
            comm,
        )
    _compile(start, scenes[1:], 0)
    if scene.case.start.stress is not None:
        set_initial_stress(scene, particles, count, comm, scene.case.start.stress)
        particles, count = bring_home(scene, slab, comm, particles, count)
    if bodies := prestressed(scene):
        rows = np.flatnonzero(np.isin(particles.body[:count], bodies))
        remember_stress(scene.setting.without_shape(), particles, rows)
    start.warnings += overstress.measure(scene, particles, count, comm)
    put_in_order(start, slab, particles, count)
    begin_motion(start.rank)
    continue_motion(start.rank)
    if start.rank.grips:
        start.rank.grips.start(start.rank)
    if len(scenes) > 1 and scene.materials.variations:
        require_stable_stages(scenes, rates_at_rest(start.rank, scene, comm))
    start.warnings += locking(start.case)
    start.notes += stripes(start.case)
    start.warnings += nearness.warnings(start.case, scene.interaction.rigid_bodies)
    start.warnings += unquiet(start.case)
    release(start.case)
    rate = max(start.rate, scene.interaction.rigid_bodies.first_rate)
    with located(start.case):
        require_end(scene, rate)
        dt = start.clock.next(start.done, rate).dt
        start.warnings += check_first_step(scene, dt, start.rate)
    require_slow(scene.interaction.rigid_bodies, dt)
    start.warnings += motion_warnings(scenes)
    if scene.settings.settles:
        begin_settling(start)
    if start.watch:
        start.watch.begin(start.rank)
    return start


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
    comm : communicator
        Of all ranks.
    reduction : StepReduction
        The reduction of the run.
    source : CheckpointFile
        The checkpoint.
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
    start.count = state.count
    if state.densest is not None:
        scene.materials.weigh(state.densest)
    slab = _decompose(start, layers)
    put_in_order(start, slab, *read_particles(scene, slab, source, state, layers, comm))
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
    return start


def _decompose(start: Start, counts: np.ndarray) -> Slab:
    """Cut the layers into slabs, one a rank, with balanced numbers of particles."""
    slab, start.balance, notes = partition(start.scene, start.comm, counts)
    start.notes += [*notes, *scaling_notes(start.case)]
    return slab


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
    start.watch = EnergyWatch(rate * min(scene.domain.frame.cell)) if start.case.watched else None
    # Messages of the ranks about the cache on their nodes, each once.
    said = comm.allgather((problems(), FOLDER.warning))
    start.notes[:0] = messages(found for found, _ in said)
    start.warnings += dict.fromkeys(warning for _, warning in said if warning)


def put_in_order(
    start: Start, slab: Slab, particles: Particles, count: int, layers: np.ndarray | None = None
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
    rank.mass_cutoff = LIGHT * min(least for least, _, _ in masses)
    start.balance.watch(count)
    open_window(rank, start.reduction)
    if layers is None:
        scene.interaction.loads.scale_patches(rank.population, comm)
    order, controlled = rank.population.order, scene.settings.controlled or True
    start.rate = max(comm.allgather(fastest(scene, rank.particles, order, controlled)))
    if (
        scene.materials.variations
    ):  # waves at rest are the particles', far from which typical ones may be
        if isinstance(start.clock, CourantClock):
            start.clock.rest_rate = start.rate or np.inf
        if start.watch:
            start.watch.speed = start.rate * min(scene.domain.frame.cell)
