"""Particles and reference vertices near contact, of bodies that are exact to their surface."""

from __future__ import annotations

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.kernels.contact.lagrangian.reference_grid import key_bits, key_of_vertex
from pgimp.kernels.contact.lagrangian.reference_numbers import PART, Parts, References
from pgimp.kernels.contact.lagrangian.vertices import EXACT
from pgimp.kernels.data.particles import Particles
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.rank_state import RankState


def move_to_boxes(scene: Scene, particles: Particles, rows: np.ndarray, motion: np.ndarray) -> None:
    """Move the positions of cut particles, (n,) NEAR_MOTION, to the middles of their whole boxes.

    Particles of bodies that are exact to their surface are at the centroids of their parts.
    """
    exact = scene.settings.exact_surfaces[particles.body[rows]]
    motion["position"][exact] -= motion["centroid_offset"][exact]


def parts_near(
    scene: Scene, particles: Particles, rows: np.ndarray, table: np.ndarray
) -> np.ndarray:
    """Parts of the particles in some rows, see `Parts`; marks these in `table`.

    The weights of rings are about the mass's centroid, not the section's.
    """
    D, exact = scene.dimension, scene.settings.exact_surfaces[particles.body[rows]]
    table["lagrangian"][exact] = EXACT
    found, inverse = np.zeros((len(rows), PART)), np.array(scene.domain.frame.inverse)
    offset = particles.offset[rows].copy()
    if scene.case.axisymmetric:
        offset += particles.products[rows, 1:]
        table["weight_position"][:, :D] += particles.products[rows, 1:]
    found[:, 3 - D : 3] = offset * inverse
    axes = (1, 2), (0, 2), (0, 1), (0, 1, 2)
    for k in range((0, 1, 4)[D - 1]):
        scale = inverse[list(axes[k])].prod() if D == 3 else inverse.prod()
        found[:, 3 + k] = particles.products[rows, k] * scale
    return found


class SlaveKeys:
    """Slaves and masters as contact numbers reference vertices."""

    def __init__(self, rank: RankState, fields: int) -> None:
        bits = key_bits.py_func(rank.scene.domain.frame, fields)  # type: ignore[attr-defined]
        self.slaves, self._shift = rank.slaves, sum(bits)
        self.keys, self.masters = (
            key_of_vertex.py_func(bits, (x, y, z), field)  # type: ignore[attr-defined]
            for x, y, z, field in (
                Vertices.numbers(rank, keys) for keys in (rank.slaves.keys, rank.slaves.masters)
            )
        )

    def owners(self, grid: Grid, comm: Communicator, keys: np.ndarray) -> np.ndarray:
        """Ranks that own vertices, given their keys; collective."""
        first, x = grid.window.lower[0], keys >> self._shift
        found = np.zeros(len(keys), np.int64)
        for rank, (begin, end) in enumerate(comm.allgather((first, first + grid.owned))):
            found[(begin <= x) & (x < end)] = rank
        return found

    def with_masters(self, found: References) -> References:
        """Vertices with the masters of those that are slaves; these have no particle, -1."""
        _, rows, _ = np.intersect1d(self.keys, found.keys, return_indices=True)
        more = np.setdiff1d(self.masters[self.slaves.of[rows]], found.keys)
        return References(
            np.concatenate([found.keys, more]),
            np.concatenate([found.particle, np.full(len(more), -1)]),
        )

    def parts(self, parts: np.ndarray, keys: np.ndarray) -> Parts:
        """Parts of particles, and the slaves among their reference vertices, ascending `keys`."""
        _, rows, places = np.intersect1d(self.keys, keys, return_indices=True)
        slave = np.full(len(keys), -1)
        slave[places] = np.arange(len(rows))
        of = np.searchsorted(keys, self.masters[self.slaves.of[rows]])
        return Parts(parts, slave, of, np.ascontiguousarray(self.slaves.weights[rows]))
