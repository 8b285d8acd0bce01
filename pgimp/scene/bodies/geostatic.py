"""Geostatic stress: that of the weight above each particle, and of K0 across.

The weight above is summed in the columns of the lattice, from the surface down: all of the points
above, and half of the point itself, over the area of a column. The buoyancy of water in the ground
is taken off, and loads on surfaces that face upwards are added. On level ground that fills the
lattice's boxes it is exact. A material gets the stress by what it remembers:

- the stress itself, or states that follow from it: F stays 1;
- the deviator alone, as its pressure follows from the volume: F is the same in all directions;
- F alone: two stretches, along gravity and across it. Of a fluid, one, and the stress is pressure.

The particle's volume and mass are those of the lattice, so that its initial volume is V/J.
"""

from __future__ import annotations

import numpy as np

from pgimp.case.start import InitialStress
from pgimp.errors import CaseError
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.collective import all_or_none
from pgimp.mpi.communicator import Communicator
from pgimp.physics.materials.cam_clay import CamClay
from pgimp.scene.bodies.prestrain import find_deformation, unknowns_along
from pgimp.scene.bodies.surcharge import surcharge
from pgimp.scene.scene import Scene


def set_geostatic_stress(
    scene: Scene,
    particles: Particles,
    count: int,
    comm: Communicator,
    entry: InitialStress,
    time: float = 0.0,
) -> None:
    """Set stress, deformation and states of the first `count` particles; collective.

    They carry each other, with the gravity at `time`.

    Raises
    ------
    CaseError
        On every rank, if a material has no such stress.
    """
    weight, axis = weight_above(scene, particles, count, comm, time), vertical(scene, time)[0]

    def set_all() -> None:
        for body, name in enumerate(scene.body_names):
            if name in scene.case.inflow:  # what enters later has no weight above it, either
                continue
            rows = np.flatnonzero(particles.body[:count] == body)
            _set_body(scene, particles, rows, name, weight[rows], (entry, axis))

    all_or_none(comm, set_all, CaseError)


def vertical(scene: Scene, time: float = 0.0) -> tuple[int, float]:
    """Axis of gravity, and its component along it."""
    gravity = scene.domain.gravity(time)
    axis = int(np.argmax(np.abs(gravity)))
    return axis, gravity[axis]


def weight_above(
    scene: Scene, particles: Particles, count: int, comm: Communicator, time: float = 0.0
) -> np.ndarray:
    """Weight of the column above each particle, over its area, (count,); collective.

    It is less by the buoyancy of water, and more by the surcharge. Sums have the columns' order, so
    that their bits do not depend on the ranks.
    """
    axis, pull = vertical(scene, time)
    frame, method = scene.domain.frame, scene.case.method
    per_cell = np.array(method.particles_per_cell)
    x, m = particles.x[:count], particles.m[:count]
    area = np.prod(frame.cell) / np.prod(per_cell) / frame.cell[axis] * per_cell[axis]
    areas = scene.domain.circumference(x) * area if scene.case.axisymmetric else area
    number = np.floor((x - frame.origin) * frame.inverse * per_cell).astype(np.int64)
    level = -number[:, axis] if pull < 0.0 else number[:, axis]
    across = np.delete(number, axis, axis=1)
    bounds = comm.allgather((level.min(initial=2**62), level.max(initial=-(2**62))))
    weight, on_top = m * abs(pull), surcharge(scene, particles, count, (axis, pull), time)
    if scene.interaction.loads.water:
        weight -= scene.interaction.loads.water.lift(particles, count, time)
    weight, on_top = weight / areas, on_top / areas
    top = min(low for low, _ in bounds)
    levels = max(high for _, high in bounds) - top + 1
    if axis > 0:  # whole columns are here
        columns, column = np.unique(across, axis=0, return_inverse=True)
        place = column.ravel(), level - top
        sums = [_by_level(*place, each, len(columns), levels) for each in (weight, on_top)]
        return _at(sums, np.zeros(len(columns)))[0][place]
    every = np.concatenate(comm.allgather(np.unique(across, axis=0)))
    columns = np.unique(every, axis=0)
    key = np.concatenate([columns, across])
    column = np.unique(key, axis=0, return_inverse=True)[1].ravel()[len(columns) :]
    place = column, level - top
    sums = [_by_level(*place, each, len(columns), levels) for each in (weight, on_top)]
    above, found = np.zeros(len(columns)), sums[0]
    ranks = range(comm.size) if pull > 0.0 else reversed(range(comm.size))
    for rank in ranks:  # one after the other, from the surface down
        if rank == comm.rank:
            found, above = _at(sums, above)
        above = comm.bcast(above, root=rank)
    return np.asarray(found[place])


def _by_level(
    column: np.ndarray, level: np.ndarray, weight: np.ndarray, columns: int, levels: int
) -> np.ndarray:
    """Sums of weights by column and level, (columns, levels)."""
    sums = np.zeros((columns, max(levels, 0)))
    np.add.at(sums, (column, level), weight)
    return sums


def _at(sums: list[np.ndarray], above: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weight above the middle of each level, and above what comes below.

    `sums` are those of the weights, and of loads on top of each level.
    """
    weight, on_top = sums
    every = np.cumsum(np.concatenate([above[:, None], weight + on_top], axis=1), axis=1)
    return every[:, :-1] + on_top + 0.5 * weight, every[:, -1]


def k0_of(entry: InitialStress, scene: Scene, name: str) -> float:
    """Ratio of the horizontal to the vertical stress of a body."""
    return entry.ratio(name, scene.case.materials[scene.case.bodies[name].material])


def _set_body(
    scene: Scene,
    p: Particles,
    rows: np.ndarray,
    name: str,
    weight: np.ndarray,
    way: tuple[InitialStress, int],
) -> None:
    """Set the stress of a body's particles, under the weight above them, along an axis."""
    entry, axis = way
    law = scene.case.materials[scene.case.bodies[name].material]
    k0 = 1.0 if law.VOLUME_ONLY and not law.CARRIES_STRESS else k0_of(entry, scene, name)
    wanted = np.zeros((len(rows), p.sigma.shape[1]))
    wanted[:, :3] = -k0 * weight[:, None]
    wanted[:, axis] = -weight
    p.sigma[rows] = wanted
    if not (law.CARRIES_STRESS and law.CARRIES_PRESSURE):
        words = "the weight above", "and this k0; take another k0, stiffer material, or settle"
        unknowns = unknowns_along(scene, name, axis)
        find_deformation(scene, (p, rows), name, wanted, unknowns, words)
    if isinstance(law, CamClay) and entry.ocr is not None:
        pressure, q = -wanted[:, :3].mean(axis=1), (1.0 - k0) * weight
        bears = pressure + (q / law.m) ** 2 / np.maximum(pressure, 1e-300)
        at = scene.materials.states.first(
            "preconsolidation", scene.materials.names.index(scene.case.bodies[name].material)
        )
        p.state[rows, at] = entry.ocr * bears
