"""Watch over bodies whose particles lose each other on the grid, at lines of the history."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pgimp.scene.checks.validity.tearing import advice, particles_of, tearing_stretch
from pgimp.solver.rank_state import RankState
from pgimp.solver.time.clock import Step

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

#: Fewest steps from a look to the next: it takes as long as some steps.
_EVERY = 50
#: Particles at a time.
_BLOCK = 1 << 16
#: Part of a body's particles that are beyond the limit when it is told, and fewest particles.
_PART, _FEWEST = 0.01, 16


class TearingWatch:
    """Sees, once for each body, that particles are too far apart along their stretch.

    Only of solids in the current configuration. Elastic ones are told before they tear. What flows
    plastically may be sheared as far, and its particles stay together: it is told at a cell, and
    only if a grip may pull it.
    """

    def __init__(self) -> None:
        self._told: set[str] = set()
        self._last = -_EVERY

    def look(self, rank: RankState, done: Step) -> list[str]:
        """Return warnings about bodies, the same on every rank; collective."""
        limits = self.limits(rank.scene)
        if not limits or 0 <= done.number - self._last < _EVERY:
            return []
        self._last = done.number
        particles, rows = rank.population.columns, rank.population.order
        found = np.zeros((len(limits), 3))  # particles, those beyond, greatest stretch
        for k, (body, limit) in enumerate(limits.items()):
            for first in range(0, len(rows), _BLOCK):
                own = rows[first : first + _BLOCK]
                own = own[particles.body[own] == body]
                stretch = greatest_stretches(particles.F[own], rank.scene.dimension, limit)
                found[k, :2] += float(len(own)), float(np.count_nonzero(stretch > limit))
                found[k, 2] = max(found[k, 2], stretch.max(initial=0.0))
        every = np.stack(rank.comm.allgather(found))
        said = []
        for (body, _), parts in zip(limits.items(), every.transpose(1, 0, 2), strict=True):
            count, beyond = parts[:, :2].sum(axis=0)
            if count >= _FEWEST and beyond >= _PART * count:
                name = rank.scene.body_names[body]
                self._told.add(name)
                said.append(_text(rank.scene, name, float(parts[:, 2].max()), done.end))
        return said

    def limits(self, scene: Scene) -> dict[int, float]:
        """Stretch from which each body is told, by its number."""
        case, found = scene.case, {}
        n = min(case.method.particles_per_cell)
        for number, name in enumerate(scene.body_names):
            known = None if name in self._told else tearing_stretch(case, name)
            if known and case.materials[case.bodies[name].material].ELASTIC:
                found[number] = known[1]
            elif known and any(entry.body == name for entry in case.constraints.values()):
                found[number] = max(float(n), known[1])
        return found


def _text(scene: Scene, name: str, stretch: float, time: float) -> str:
    case = scene.case
    n, known = min(case.method.particles_per_cell), tearing_stretch(case, name)
    assert known
    return (
        f"particles of '{name}' are up to {stretch / n:.2g} cells apart along their stretch of "
        f"{stretch:.3g} at time {time:.6g}; in tension, with {particles_of(case)}, bodies tear on "
        f"the grid from {known[0]:g} times their length on, and what follows is no result: "
        f"{advice(case, name)}"
    )


def greatest_stretches(F: np.ndarray, dimension: int, limit: float) -> np.ndarray:
    """Return the greatest principal stretch within the directions of a case.

    Parameters
    ----------
    F : (n, k) float64
        Deformation gradients, row by row.
    dimension : int
        Of the case; numbers beyond its matrix are left out.
    limit : float
        Stretches that are surely below are given as an upper bound of them.

    Returns
    -------
    (n,) float64
    """
    F = F[:, : dimension * dimension].reshape(-1, dimension, dimension)
    C = np.einsum("nji,njk->nik", F, F)
    squares = np.abs(C).sum(axis=2).max(axis=1)  # of no eigenvalue less
    far = np.flatnonzero(squares > limit * limit)
    if len(far):
        squares[far] = np.linalg.eigvalsh(C[far])[:, -1]
    return np.sqrt(squares)
