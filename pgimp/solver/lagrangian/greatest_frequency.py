"""Greatest frequency of vertices near surfaces, where bodies are exact to them."""

from __future__ import annotations

from itertools import product

import numpy as np

from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.rank_state import RankState

#: Iterations for the greatest frequency.
_ITERATIONS = 40


def stable_courant(
    rank: RankState,
    few: np.ndarray,
    known: np.ndarray,
    mass: np.ndarray,
    folding: tuple[np.ndarray, np.ndarray],
) -> float:
    """Courant number up to which vertices near slaves are stable; collective.

    From the greatest frequency of a scalar wave by power iteration. What lies farther away is at
    rest. Rings are strained by their hoops as well.

    Parameters
    ----------
    few : (n + free,) int64
        The slaves, then vertices that hold as little, but have no masters.
    known : (k,) int64
        All vertices around these, ascending.
    mass : (k,) float64
        Their masses, with those of slaves, which have none.
    folding : (n, 2^D) int64, (n, 2^D) float64
        Numbers among `known`, and weights, of each slave's masters.
    """
    if not len(few):
        return np.inf
    of, weights = folding
    at, gradients, m = _near_particles(rank, few, known, np.unique(of))
    slaves = np.searchsorted(known, few[: len(of)])
    inverse = np.where(mass > 0.0, 1.0 / np.where(mass > 0.0, mass, 1.0), 0.0)
    inverse[slaves] = 0.0
    u, square = np.cos(1.7 * np.arange(len(known))) * (inverse > 0.0), 0.0
    for _ in range(_ITERATIONS):
        u /= np.sqrt((mass * u * u).sum())
        u[slaves] = (weights * u[of]).sum(axis=1)
        strain = np.einsum("pcd,pc->pd", gradients, np.append(u, 0.0)[at])
        force = np.einsum("pcd,pd->pc", gradients, m[:, None] * strain)
        f = np.bincount(at.reshape(-1), force.reshape(-1), len(known) + 1)[:-1]
        np.add.at(f, of.reshape(-1), (weights * f[slaves, None]).reshape(-1))
        u = inverse * f
        square = np.sqrt((mass * u * u).sum())
    return float(2.0 / (np.sqrt(square) * min(rank.grid.frame.cell)))


def _near_particles(
    rank: RankState, few: np.ndarray, known: np.ndarray, masters: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Particles of all ranks in the cells round some vertices; collective.

    Returns
    -------
    (p, 2^D) int64
        Numbers of their cells' corners among `known`; k for others.
    (p, 2^D, D or 3) float64
        Gradients of their weights there; of rings also the weights of their hoops.
    (p,) float64
        Their masses.
    """
    frame, p, rows = rank.grid.frame, rank.up_to_date(), rank.population.order
    h, corners = np.array(frame.cell), [*product((0, 1), repeat=len(frame.cell))]
    x = (p.origin[rows] - np.array(frame.origin)) / h + frame.ghost
    first = np.floor(x).astype(np.int64)
    cells = Vertices.cells_of(rank, np.concatenate([few, known[masters]]))
    near = np.isin(Vertices.key(rank, first, p.body[rows]), cells)
    x, first, rows = x[near] - first[near], first[near], rows[near]
    axial = rank.scene.case.axisymmetric
    gradients = np.zeros((len(rows), len(corners), len(h) + axial))
    out = p.products[rows, 1:] / h if axial else 0.0  # from the section's centroid to the mass's
    at = np.zeros((len(rows), len(corners)), np.int64)
    for c, corner in enumerate(corners):
        keys = Vertices.key(rank, first + np.array(corner), p.body[rows])
        at[:, c] = np.minimum(np.searchsorted(known, keys), len(known) - 1)
        at[known[at[:, c]] != keys, c] = len(known)
        n = np.where(np.array(corner) == 1, x, 1.0 - x)
        if axial:
            off_axis = first[:, 0] + corner[0] > frame.ghost  # on it no ring is stretched
            off_axis |= frame.origin[0] > 0.0
            gradients[:, c, 2] = off_axis * n.prod(axis=1) / p.origin[rows, 0]
            n = np.where(np.array(corner) == 1, x + out, 1.0 - x - out)
        for d in range(len(h)):
            sign = (2 * corner[d] - 1) / h[d]
            gradients[:, c, d] = sign * np.delete(n, d, axis=1).prod(axis=1)
    parts = rank.comm.allgather((at, gradients, p.m[rows]))
    at, gradients, m = (np.concatenate(each) for each in zip(*parts, strict=True))
    return at, gradients, m
