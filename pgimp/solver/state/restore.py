"""Restoring a simulation's state: a checkpoint is checked, then taken over."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pgimp.case.gauges import flux_gauges
from pgimp.decomposition.slabs import Slab
from pgimp.errors import DamagedError, UsageError
from pgimp.kernels.data.ledger import PLACES
from pgimp.kernels.data.particles import COLUMNS, Particles
from pgimp.kernels.order.order import cell_numbers, locate
from pgimp.mpi.collective import all_or_none
from pgimp.mpi.communicator import Communicator
from pgimp.scene.rigid.free_body import State as FreeState
from pgimp.scene.scene import Scene
from pgimp.solver.history.diagnostics import Diagnostics
from pgimp.solver.history.gauge_means import stored_lines
from pgimp.solver.loads.grips import Grips
from pgimp.solver.rank import Rank
from pgimp.solver.state.contact import restore_contact, stored_contact
from pgimp.solver.state.state import State
from pgimp.solver.state.stored_motion import MOTION, MOTION_PLANES, put_motion
from pgimp.solver.state.vertex_motion import keep_masses

if TYPE_CHECKING:
    from pgimp.io.checkpoints.checkpointfile import CheckpointFile


def outline(scene: Scene, source: CheckpointFile, comm: Communicator) -> tuple[State, np.ndarray]:
    """State and number of particles by layer, in agreement with each other and the scene.

    Everything in a checkpoint is checked before it is used: a file with the right checksums may
    still hold data that no run has written. Collective.

    Parameters
    ----------
    scene : Scene
        The scene of the case, with the changes allowed to a resume.

    Raises
    ------
    DamagedError
        On every rank, if it does not hold a state of this scene.
    """

    def read() -> tuple[State, np.ndarray]:
        state = State.of(source)
        layers = _whole(source, "layers", (scene.domain.frame.vertices[0],))
        if (layers < 0).any() or (layers > source.count).any() or layers.sum() != source.count:
            raise DamagedError("its particles by layer do not add up")
        if source.count > state.count:
            raise DamagedError("it has more particles than the case began with")
        return state, layers

    return all_or_none(comm, read, DamagedError)


def read_particles(
    scene: Scene,
    slab: Slab,
    source: CheckpointFile,
    state: State,
    layers: np.ndarray,
    comm: Communicator,
) -> tuple[Particles, int, np.ndarray]:
    """Read the particles of a slab; collective.

    Parameters
    ----------
    scene, source, comm
        As in `outline`.
    slab : Slab
        This rank's slab.
    state, layers
        From `outline`.

    Returns
    -------
    Particles
        In canonical order.
    int
        Their number.
    (layers + 1,) int64
        Beginnings of the layers.

    Raises
    ------
    DamagedError
        On every rank, if particles of any cannot be of this scene.
    UsageError
        On every rank, if frames request data that the checkpoint does not hold.
    """
    edges = np.concatenate([[0], np.cumsum(layers)])[slab.first : slab.first + slab.layers + 1]
    first, start, n = int(edges[0]), edges - edges[0], int(edges[-1] - edges[0])

    def read() -> Particles:
        particles = _read_rows(scene, source, first, n)
        if fault := _inconsistent(scene, slab, particles, start, n, state.count):
            raise DamagedError(fault)
        return particles

    return all_or_none(comm, read, DamagedError, UsageError), n, start


def read_books(rank: Rank, source: CheckpointFile, state: State, records: Diagnostics) -> None:
    """Restore the sums by plane and the state of the history; collective.

    Raises
    ------
    DamagedError
        On every rank, if they are not of this scene.
    """
    scene, own, first = rank.scene, rank.booked(), rank.slab.first
    planes = scene.domain.frame.vertices[0] + scene.settings.vertices - 1

    def read() -> dict[str, np.ndarray]:
        staged, width = scene.case.staged, scene.materials.sums
        for names, there, what in (
            (staged.removed, state.removed, "removed bodies"),
            (staged.added, state.added, "bodies that came"),
        ):
            if (there is not None) != bool(names) or len(there or ()) != bool(names) * width:
                raise DamagedError(f"what it has of {what} is not of its stage")
        if rank.inflow and len(state.inflow or ()) != len(rank.inflow.numbers):
            raise DamagedError("what it has of inflow is not of its case")
        found = {}
        for name, mine in own.datasets().items():
            if mine.shape[1:] and 0 in mine.shape[1:]:
                continue
            whole = _whole(source, name, (planes, *mine.shape[1:]))
            found[name] = whole[first : first + len(mine)]
        if scene.interaction.rigid_bodies.free:
            begun = scene.interaction.rigid_bodies.first
            shape = (len(begun), len(begun[0].numbers))
            states = _whole(source, "free-bodies", shape)
            if (abs((states[:, 3:7] ** 2).sum(axis=1) - 1.0) > 1e-9).any():
                raise DamagedError("the rotation of a rigid body is none")
            found["free-bodies"] = states
        if "grips" in source.whole and rank.grips is None:  # of a stage before
            rank.grips = Grips(scene, rank.comm)
        if rank.grips:
            found["grips"] = _whole(source, "grips", rank.grips.state.shape)
        if rank.absorbing:
            found |= rank.absorbing.stored(source, _whole)
        found |= stored_contact(rank, source, _whole)
        if state.last_line is not None:
            rows = len(scene.interaction.pairs.kind) if scene.interaction.pairs else 0
            rows *= 1 + scene.settings.by_vertex * PLACES
            rows += 2 * len(scene.interaction.rigid_bodies) + len(scene.domain.faces)
            rows += 2 * len(flux_gauges(scene.case.gauges))
            rows += len(scene.interaction.loads.booked_tractions)
            shape = (len(scene.interaction.loads.booked_constraints) + rows, 3)
            for name in ("last-impulse", "last-force") if shape[0] else ():
                found[name] = _whole(source, name, shape)
        return found | stored_lines(scene, source, _whole)

    found = all_or_none(rank.comm, read, DamagedError)
    for name, mine in own.datasets().items():
        if name in found:
            mine[:] = found[name]
    if rank.free:
        rank.free.states = [FreeState.of(numbers.tolist()) for numbers in found["free-bodies"]]
    if rank.grips:
        rank.grips.state[:] = found["grips"]
    if rank.absorbing:
        rank.absorbing.restore(found)
    restore_contact(rank, found)
    if rank.comm.rank == 0:
        rank.clamped, rank.held = state.clamped, state.held
        if rank.surface_kinematics:
            rank.surface_kinematics.fallbacks = state.fallbacks
    if rank.inflow and state.inflow:
        rank.inflow.restore(state.inflow)
    rank.mass_cutoff = state.mass_cutoff
    records.first_energy = state.first_energy
    records.most_outside = state.beyond, state.beyond_time, state.beyond_face
    records.removed = None if state.removed is None else np.array(state.removed)
    records.changed, records.settling_time = state.changed, state.settling_time
    records.added = None if state.added is None else np.array(state.added)
    records.initial_losses[:] = state.initial_losses
    records.means.restore(scene, found.get("gauge-lines"))
    if state.last_line is not None:
        none = np.zeros((0, 3))
        last = (found.get("last-impulse", none), found.get("last-force", none))
        records.last = (state.last_line, *last)


def read_motion(rank: Rank, source: CheckpointFile) -> None:
    """Restore the motion of the vertices in the initial configuration; collective.

    Raises
    ------
    DamagedError
        On every rank, if it is not of this scene.
    """
    scene, slab = rank.scene, rank.slab
    if scene.settings.lagrangian_bodies is None:
        return
    rank.contact.assign_fields(rank)
    grid = rank.grid

    def read() -> None:
        counts = _whole(
            source, MOTION_PLANES, (scene.domain.frame.vertices[0] + scene.settings.vertices - 1,)
        )
        edges = np.concatenate([[0], np.cumsum(counts)])
        total = int(edges[-1])
        if (counts < 0).any() or any(
            source.whole.get(name) != (np.dtype(kind), (total, *tail))
            for name, kind, tail in zip(MOTION, (np.int64, np.float64), ((), (6,)), strict=True)
        ):
            if total:
                raise DamagedError("its motion of vertices is not of the scene's shape")
            return
        first, last = edges[slab.first], edges[slab.first + grid.planes]
        keys, values = (source.read_part(name, int(first), int(last)) for name in MOTION)
        if not np.isfinite(values).all() or not put_motion(rank, keys, values):
            raise DamagedError("its motion of vertices is not of this scene")

    all_or_none(rank.comm, read, DamagedError)
    if scene.domain.ring is not None:  # planes behind the last layer are the first ones
        rank.share_motion()
    keep_masses(rank)


def _whole(source: CheckpointFile, name: str, shape: tuple[int, ...]) -> np.ndarray:
    integers = ("layers", "velocity-fields", MOTION_PLANES)
    kind = np.dtype(np.int64 if name in integers else np.float64)
    if source.whole.get(name) != (kind, shape):
        raise DamagedError(f"it has no {name} of the scene's shape")
    array = source.read_whole(name)
    if not np.isfinite(array).all():
        raise DamagedError(f"its {name} has values that are no finite numbers")
    return array


def _read_rows(scene: Scene, source: CheckpointFile, first: int, n: int) -> Particles:
    """Read `n` rows of a checkpoint, with the columns of the scene."""
    expected = Particles.empty(0, scene.carried)._asdict()
    particles = Particles.empty(max(n, 1), scene.carried)
    for name, like in expected.items():
        if 0 in like.shape[1:]:
            continue
        if name == "origin" and name not in source.rows:
            raise UsageError(
                "output.fields: the displacement needs the initial positions, which the checkpoint "
                "does not hold because the run began without that field; leave it out, or start "
                "over with --overwrite"
            )
        if source.rows.get(name) != (like.dtype, like.shape[1:]):
            raise DamagedError(f"its particles have no {name} of the scene's shape")
        array = source.read(name, first, first + n)
        if not np.isfinite(array).all():
            raise DamagedError(f"the {name} of its particles has values that are no finite numbers")
        getattr(particles, name)[:n] = array
    return particles


def _inconsistent(
    scene: Scene, slab: Slab, p: Particles, start: np.ndarray, n: int, count: int
) -> str:
    """Return the inconsistency of particles with this scene, as a step requires; else empty."""
    frame, shape = scene.domain.frame, scene.settings.shape
    x = (scene.weighed(p, np.arange(n)) - frame.origin) * frame.inverse
    # Supports begin within the domain where it is periodic, not centres.
    beyond = 2.0 * np.array(scene.domain.periodic)
    if ((x < 0.0) | (x > np.array(frame.cells, float) + beyond)).any():
        return "the x of a particle is out of range"
    greatest = {
        "bodies": len(scene.body_names) - 1,
        "particles": count - 1,
        "cells": np.inf if scene.domain.periodic[0] else cell_numbers(frame.vertices) - 1,
        "constraints": len(scene.interaction.loads.constraints),
    }
    for name, column in COLUMNS.items():
        values = getattr(p, name)[:n]
        least = -np.inf if greatest.get(column.numbers) == np.inf else 0
        if column.numbers and ((values < least) | (values > greatest[column.numbers])).any():
            return f"the {name} of a particle is out of range"
        if column.least is not None and (values < column.least).any():
            return f"the {name} of a particle is out of range"
        if column.above is not None and not (values > column.above).all():
            return f"the {name} of a particle is not above {column.above:g}"
    layer = p._replace(layer=np.empty_like(p.layer), cell=np.empty_like(p.cell))
    locate(shape, scene.order_frame, layer, np.arange(n, dtype=np.int32), frame.vertices)
    expected = slab.first + np.repeat(np.arange(len(start) - 1), np.diff(start))
    if (p.layer[:n] != expected).any() or (layer.layer[:n] != expected).any():
        return "a particle is not in its layer"
    same = expected[1:] == expected[:-1]
    cell, number = np.diff(p.cell[:n]), np.diff(p.id[:n])
    if (same & ((cell < 0) | ((cell == 0) & (number <= 0)))).any():
        return "its particles are not in canonical order"
    return ""
