"""The particles of a run at its start: counted, decomposed and created."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.decomposition.slabs import Slab
from pgimp.errors import CaseError
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.order.order import layers_of
from pgimp.mpi.collective import all_or_none
from pgimp.scene.bodies.counts import count_particles, present
from pgimp.scene.geometry import share
from pgimp.scene.mass_scaling import scaling_notes
from pgimp.scene.scene import Scene
from pgimp.solver.decomposition import create_particles, partition, ring_counts
from pgimp.solver.sources.inflow import most_at_once, to_enter
from pgimp.solver.start.continued import verify_checkpoints
from pgimp.solver.start.creation import Creation
from pgimp.solver.start.require_memory import require
from pgimp.solver.start.start import Start


def create_start(
    start: Start, scenes: Sequence[Scene], creation: Creation
) -> tuple[Slab, Particles, int, int]:
    """Create the particles of this rank's slab; collective.

    Parameters
    ----------
    start : Start
        The start, which gets its balance and notes.
    scenes : sequence of Scene
        The scenes of all stages.
    creation : Creation
        Creates the particles.

    Returns
    -------
    Slab
        This rank's slab.
    Particles
        Its particles.
    int, int
        Their number, and that of the particles of all ranks.

    Raises
    ------
    CaseError
        On every rank, for errors that show in the bodies, and if memory does not suffice.
    """
    scene, comm = start.scene, start.comm
    verify_checkpoints(scene, comm)
    share(start.case, comm)
    require(scene, comm)
    scene.interaction.rigid_bodies.measure(comm, keep=True)
    lattice, counts, notes = count_particles(scene, comm)
    start.notes += notes
    entering = to_enter(scene.case, counts, scenes[-1].case.time.end)
    require(scene, comm, most_at_once(scene.case, counts, entering))
    counts = present(scene, counts)
    x = lattice.coordinates[0]
    layer = np.empty(len(x), np.int64)
    layers_of(scene.settings.shape, scene.order_frame, scene.setting.identity, x, layer)
    on_lattice = np.bincount(layer, counts.sum(axis=0), scene.domain.frame.vertices[0])
    slab = decompose(start, ring_counts(scene, creation.layer_counts(on_lattice)))

    def create(own: Slab) -> tuple[Particles, int]:
        return all_or_none(comm, lambda: creation.create(own, lattice, counts, layer), CaseError)

    particles, count = create_particles(scene, slab, comm, create)
    return slab, particles, count, int(counts.sum())


def decompose(start: Start, counts: np.ndarray) -> Slab:
    """Cut the layers into slabs, one a rank, with balanced numbers of particles."""
    slab, start.balance, notes = partition(start.scene, start.comm, counts)
    start.notes += [*notes, *scaling_notes(start.case)]
    return slab
