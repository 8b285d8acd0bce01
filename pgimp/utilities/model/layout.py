"""Layout of a scene for division into slabs: particles per layer, and size of a plane."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.decomposition.slabs import cut, most_slabs
from pgimp.kernels.order.order import layers_of
from pgimp.scene.bodies.extent import Extent
from pgimp.scene.scene import Scene
from pgimp.solver.start.memory import window

if TYPE_CHECKING:
    from pgimp.solver.simulation import Simulation


class Layout(NamedTuple):
    """Layout of a scene for division into slabs.

    Attributes
    ----------
    counts : (layers,) int64
        Particles of each layer.
    plane : int
        Stored vertices of a plane.
    vertices : int
        Vertices per direction in a support, s; slabs have at least s - 1 layers.
    ends : int
        Least number of layers of the first and of the last slab, if more.
    crossing : float
        Fraction of a layer's particles that leave it in a step.
    wide : int
        Vertices of a plane on several ranks; 0 if the same.
    """

    counts: NDArray[np.int64]
    plane: int
    vertices: int
    ends: int = 0
    crossing: float = 0.0
    wide: int = 0

    def plane_on(self, ranks: int) -> int:
        """Vertices of a plane on `ranks` ranks."""
        return self.wide if ranks > 1 and self.wide else self.plane

    @property
    def particles(self) -> int:
        """Total number of particles."""
        return int(self.counts.sum())

    @property
    def most_ranks(self) -> int:
        """Greatest number of slabs."""
        return most_slabs(len(self.counts), self.vertices - 1, self.ends)

    def cuts(self, ranks: int) -> list[int]:
        """First layers of the slabs, and the number of layers, as in a run on `ranks` ranks."""
        return cut(self.counts, ranks, self.vertices - 1, self.ends)


def layout_of(
    scene: Scene, bodies: list[Extent], x: NDArray[np.float64], counts: NDArray[np.int64]
) -> Layout:
    """Layout of a scene in its initial state.

    Parameters
    ----------
    bodies : list of Extent
        See `pgimp.scene.bodies.extent.extents`.
    x : (planes,) float64
        Coordinates of the lattice's planes along x.
    counts : (planes,) int64
        Particles of each plane.
    """
    layer = np.empty(len(x), np.int64)
    D = scene.dimension
    identity = tuple(float(i == j) for i in range(D) for j in range(D))
    layers_of(scene.settings.shape, scene.placing, identity, x, layer)
    of_layers = np.zeros(scene.domain.frame.vertices[0], np.int64)
    np.add.at(of_layers, layer, counts)
    plane, wide = (
        int(np.prod(window(scene, bodies, ranks)[1:], dtype=np.int64)) for ranks in (1, 2)
    )
    return Layout(of_layers, plane, scene.settings.vertices, scene.ends, wide=wide)


def layout_now(sim: Simulation) -> Layout:
    """Layout of a simulation in its present state; collective."""
    scene, rows = sim.scene, sim.live()
    speed = float(np.abs(sim.particles.v[rows, 0]).sum())
    mine = (sim.rank.slab.first, np.diff(sim.population.start), speed)
    counts = np.zeros(scene.domain.frame.vertices[0], np.int64)
    travel = 0.0
    for first, some, speeds in sim.comm.allgather(mine):
        counts[first : first + len(some)] = some
        travel += speeds * sim.dt
    return Layout(
        counts,
        int(np.prod(sim.rank.grid.window.extent[1:], dtype=np.int64)),
        scene.settings.vertices,
        scene.ends,
        min(1.0, travel * scene.domain.frame.inverse[0] / max(int(counts.sum()), 1)),
    )
