"""The standard block: a neo-Hookean block, 8 particles a cell at random positions, in free fall.

Its exact motion is rigid, so stresses and velocity differences are errors.
"""

from __future__ import annotations

import numpy as np

from pgimp.decomposition.slabs import Slab
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.order.order import locate
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.bodies.populate import populate
from pgimp.solver.simulation import Simulation
from pgimp.solver.start.creation import Creation

YOUNG, POISSON, DENSITY, GRAVITY, SPEED = 1.0e6, 0.3, 1000.0, -9.81, 0.1


class RandomCreation(Creation):
    """Particles at random positions within their cells."""

    def layer_counts(self, counts: np.ndarray) -> np.ndarray:
        """See `Creation.layer_counts`."""
        return _spread(counts, self.scene.settings.shape.half[0])

    def create(
        self, slab: Slab, lattice: Lattice, counts: np.ndarray, layer: np.ndarray
    ) -> tuple[Particles, int]:
        """See `Creation.create`."""
        # A random position may lie in a layer next to its lattice plane's: extend by two cells.
        reach = 2 * lattice.per_cell[0]
        own = np.searchsorted(layer, (slab.first, slab.first + slab.layers))
        begin, end = max(0, int(own[0]) - reach), min(lattice.planes, int(own[1]) + reach)
        p = populate(self.scene, lattice, counts, (begin, end))
        count = int(counts[:, begin:end].sum())
        cell = np.array(self.scene.domain.frame.cell)
        corner = np.floor(p.x[:count] / cell) * cell
        p.x[:count] = corner + _uniform(p.id[:count])[:, : len(cell)] * cell
        if p.origin.shape[1]:
            p.origin[:] = p.x
        rows = np.arange(count, dtype=np.int32)
        locate(
            self.scene.settings.shape,
            self.scene.order_frame,
            p,
            rows,
            self.scene.domain.frame.vertices,
        )
        here = slab.first <= p.layer[:count]
        here &= p.layer[:count] < slab.first + slab.layers
        arrays: list[np.ndarray] = list(p)
        del p
        for i in range(len(arrays)):  # so that only one array at a time is duplicated
            arrays[i] = arrays[i][:count][here]
        return Particles._make(arrays), int(here.sum())


class Block(Simulation):
    """The block with particles at random positions within their cells."""

    creation = RandomCreation


def _uniform(ids: np.ndarray) -> np.ndarray:
    """Three numbers in [0, 1) from each id, independent of the ranks (splitmix64)."""
    numbers = []
    for d in range(3):
        z = (ids.astype(np.uint64) * np.uint64(3) + np.uint64(d)) * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        numbers.append((z ^ (z >> np.uint64(31))) >> np.uint64(11))
    return np.stack(numbers, axis=1).astype(float) * 2.0**-53


def block_case(cells: int, steps: int) -> dict[str, object]:
    """The benchmark as a case: a block of `cells` cubed in a domain with a margin of four cells."""
    h, pad = 1.0 / cells, 4
    lam = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    c = np.sqrt((lam + YOUNG / (1 + POISSON)) / DENSITY)
    dt = 0.2 * h / float(c)
    high = [pad * h + 1.0] * 3
    size = [h * (cells + 2 * pad)] * 3
    return {
        "format": 1,
        "title": "Benchmark block",
        "dimensions": 3,
        "grid": {"origin": [0.0] * 3, "size": size, "cell": [h] * 3},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2, 2]},
        "time": {"end": steps * dt, "step": dt},
        "materials": {
            "solid": {
                "model": "neo-hookean",
                "young": YOUNG,
                "poisson": POISSON,
                "density": DENSITY,
            }
        },
        "bodies": {
            "block": {
                "material": "solid",
                "region": {"box": {"min": [pad * h] * 3, "max": high}},
                "velocity": [SPEED, 0.0, 0.0],
            }
        },
        "gravity": [0.0, 0.0, GRAVITY],
    }


def _spread(counts: np.ndarray, half: float) -> np.ndarray:
    """Particles of each layer at random positions, from the counts on the lattice.

    Positions in a cell below the half-width have their support one vertex earlier.
    """
    moved = np.round(half * counts).astype(np.int64)
    return counts - moved + np.append(moved[1:], 0)
