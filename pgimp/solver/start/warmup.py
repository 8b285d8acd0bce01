"""Compilation of a scene's kernels before its first step: one without particles is rehearsed."""

from functools import partial

import numpy as np

from pgimp.decomposition.migrate import pack, unpack
from pgimp.decomposition.slabs import Slab
from pgimp.jit.compiled.collector import spared
from pgimp.jit.rehearsal import note_calls, rehearsal
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.once.prestress import bearable_stress, remember_stress
from pgimp.kernels.order.layer_changes import partition_migrants
from pgimp.kernels.order.order import layers_of
from pgimp.kernels.rigid.bodies import distances
from pgimp.kernels.step.g2p import grid_to_particles
from pgimp.kernels.step.p2g import complete, particles_to_grid
from pgimp.kernels.sums.energies import strain_energies
from pgimp.kernels.sums.errors import initial_velocities
from pgimp.kernels.update.turns import turn_particles
from pgimp.mpi.comm import Serial
from pgimp.mpi.communicator import Communicator
from pgimp.mpi.node import shared_out
from pgimp.physics.derived import RECOVERED
from pgimp.scene.bodies.populate import prestressed
from pgimp.scene.checks.overstress import stressed
from pgimp.scene.scene import Scene
from pgimp.solver.damping.relaxation import Relaxation
from pgimp.solver.decomposition import open_window
from pgimp.solver.flows import EVERY
from pgimp.solver.history.diagnostics import Diagnostics
from pgimp.solver.lagrangian.recovered_stress import recovered_stresses
from pgimp.solver.particle_groups import fastest
from pgimp.solver.rank import Rank
from pgimp.solver.reduction import StepReduction
from pgimp.solver.state.grid_state import active_grid
from pgimp.solver.state.vertex_motion import begin_motion, rehearse_motion
from pgimp.solver.step import step
from pgimp.solver.time.clock import Step

#: A step in which also flows are due.
STEP = Step(EVERY, 0.0, 1.0, 1.0)

#: The field that a kernel computes.
ENERGY = "strain-energy-density"

#: Rough compile time beyond that of the arguments, in letters of their types: materials and shapes.
LONG = {grid_to_particles: 8000, particles_to_grid: 6000}


def warm_up(scene: Scene, comm: Communicator) -> None:
    """Compile the kernels that the scene's steps call; collective."""
    with spared(), rehearsal():
        if comm.size > 1:
            noted = note_calls(lambda: _rehearse(scene))
            shared_out(
                comm,
                [
                    (len(str(types)) + LONG.get(each, 0), partial(each.compile, types))
                    for each, types in noted
                ],
            )
            if not noted:  # so all have been called
                return
        _rehearse(scene)


def _rehearse(scene: Scene) -> None:
    """Call the kernels of set-up, step, history and exchange on a rank without particles."""
    particles, rows = Particles.empty(1, scene.created), np.empty(0, np.int32)
    rank = Rank(scene, Serial(), Slab(0, 1, None, None), particles, 0)
    later = rank.damping if scene.settings.settles else None
    if scene.settings.settles:
        rank.damping = Relaxation()
    open_window(rank, StepReduction(Serial()))
    begin_motion(rank)
    step(rank, STEP._replace(end=STEP.start), lambda: STEP, scene.settings.controlled)
    if later:  # the damping that acts when the run has come to rest
        rank.damping = later
        step(rank, STEP._replace(end=STEP.start), lambda: STEP, scene.settings.controlled)
    rehearse_motion(rank)
    rank.contact.excursion(rank)
    rank.population.restore_order(rows, rows)
    fastest(scene, particles, rows, scene.settings.controlled)
    Diagnostics().line(rank, STEP)
    fields = {f for each in (scene.case.output, *scene.case.probes.values()) for f in each.fields}
    if ENERGY in fields:
        strain_energies(scene.setting, particles, rows)
    if RECOVERED in fields:
        recovered_stresses(rank, particles.origin[:0], particles.body[:0])
    if rank.contact.at_vertices and "contact" in scene.case.output.grid:
        active_grid(rank, STEP.start, STEP.dt)
    complete(rank.grid.field, 0, 1, False, np.empty(0))
    if rank.grid.fields:  # bodies will come near others
        rank.grid.regroup(rank.grid.fields)
    partition_migrants(particles.layer, rows, rows, 0, 1, 0, rows.copy(), rows.copy())
    unpack(pack(particles, rows), particles, rows)
    layers_of(
        scene.settings.shape,
        scene.order_frame,
        scene.setting.identity,
        np.empty(0),
        np.empty(0, np.int64),
    )
    if any(scene.domain.periodic) and scene.case.staged.added:
        turn_particles(scene.settings.shape, scene.order_frame, scene.domain.exits, particles, rows)
    material, chosen = scene.setting.without_shape(), rows.astype(np.int64)
    if scene.interaction.rigid_bodies:  # looked at now and then, also by runs that go on
        placed = scene.interaction.rigid_bodies.at(STEP.start, STEP.start)
        distances(placed, 0, scene.interaction.rigid_bodies.frame, particles.x[:0], np.empty(0))
    if prestressed(scene):
        remember_stress(material, particles, chosen)
    begins = scene.case.start.stress, scene.case.staged.stress
    if stressed(scene) or any(each is not None for each in begins):
        bearable_stress(material, particles, chosen, particles.sigma[:0])
    if scene.settings.moves:
        initial_velocities(
            scene.settings.exact, scene.domain.frame, particles.x[:0], particles.v[:0]
        )
