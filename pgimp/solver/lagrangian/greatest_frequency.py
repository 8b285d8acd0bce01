"""Frequencies of vertices near surfaces, where bodies are exact to them, and masses by these."""

from __future__ import annotations

from itertools import product

import numpy as np

from pgimp.geometry.rows import each_once
from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.lagrangian.pieces import runs
from pgimp.solver.rank_state import RankState

#: Iterations for the greatest frequency.
_ITERATIONS = 40

#: Courant number that vertices without masters are to bear.
BORNE = 0.5


def stable_courant(
    few: np.ndarray,
    known: np.ndarray,
    mass: np.ndarray,
    cells: tuple[np.ndarray, np.ndarray],
    folding: tuple[np.ndarray, np.ndarray],
    side: float,
) -> float:
    """Courant number up to which vertices near slaves are stable.

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
    cells : (c, 2^D) int64, (c, 2^D, 2^D) float64
        Those round them, see `near_cells`.
    folding : (n, 2^D) int64, (n, 2^D) float64
        Numbers among `known`, and weights, of each slave's masters.
    side : float
        Least side of a cell.
    """
    (of, weights), (at, stiffness) = folding, cells
    slaves = np.searchsorted(known, few[: len(of)])
    inverse = np.where(mass > 0.0, 1.0 / np.where(mass > 0.0, mass, 1.0), 0.0)
    inverse[slaves] = 0.0
    u, square = np.cos(1.7 * np.arange(len(known))) * (inverse > 0.0), 0.0
    for _ in range(_ITERATIONS):
        u /= np.sqrt((mass * u * u).sum())
        u[slaves] = (weights * u[of]).sum(axis=1)
        force = np.einsum("cij,cj->ci", stiffness, np.append(u, 0.0)[at])
        f = np.bincount(at.reshape(-1), force.reshape(-1), len(known) + 1)[:-1]
        f += np.bincount(of.reshape(-1), (weights * f[slaves, None]).reshape(-1), len(known))
        u = inverse * f
        square = np.sqrt((mass * u * u).sum())
    return float(2.0 / (np.sqrt(square) * side))


def missing_masses(
    free: np.ndarray,
    slaves: np.ndarray,
    mass: np.ndarray,
    cells: tuple[np.ndarray, np.ndarray],
    side: float,
) -> list[tuple[int, int, float]]:
    """Masses that free vertices lack for steps of Courant number `BORNE`, of their cells' others.

    By Gershgorin's bound of the frequency of each; as far as others have more than they need.

    Parameters
    ----------
    free, slaves : (f,) int64, (n,) int64
        Numbers of vertices among all, ascending.
    mass : (k,) float64
        Masses of all; those of slaves are not used.
    cells : (c, 2^D) int64, (c, 2^D, 2^D) float64
        See `near_cells`.
    side : float
        Least side of a cell.

    Returns
    -------
    list of (int, int, float)
        Numbers of the vertex that takes and of the one that gives, and the mass.
    """
    (at, stiffness), found = cells, []
    sums = np.abs(stiffness).sum(axis=2) * (0.5 * BORNE * side) ** 2
    need = np.bincount(at.reshape(-1), sums.reshape(-1), len(mass) + 1)[:-1]
    spare = mass - need
    spare[slaves] = 0.0
    for vertex in free:
        others = np.unique(at[(at == vertex).any(axis=1)])
        others = others[others < len(mass)]
        for other in others[np.argsort(-spare[others], kind="stable")]:
            given = min(-spare[vertex], spare[other])
            if given > 0.0:
                found.append((int(vertex), int(other), float(given)))
                spare[vertex] += given
                spare[other] -= given
    return found


def near_cells(
    rank: RankState, few: np.ndarray, known: np.ndarray, masters: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cells of all ranks round some vertices; collective.

    Returns
    -------
    (c, 2^D) int64
        Numbers of their corners among `known`; k for others.
    (c, 2^D, 2^D) float64
        Sums over their particles of the masses times products of the weights' gradients; of rings
        also of the weights of their hoops.
    """
    frame, p, order = rank.grid.frame, rank.up_to_date(), rank.population.ordered
    h, corners = np.array(frame.cell), np.array([*product((0, 1), repeat=len(frame.cell))])
    near = Vertices.cells_of(rank, np.concatenate([few, known[masters]]))
    axial, found = rank.scene.case.axisymmetric, []
    for run in (*runs(order.start), slice(0)):  # at the end none, for a rank without particles
        rows = order.rows[run]
        x = (p.origin[rows] - np.array(frame.origin)) / h + frame.ghost
        first = np.floor(x).astype(np.int64)
        keys = Vertices.key(rank, first, p.body[rows])
        begin = np.flatnonzero(np.diff(keys, prepend=-1))  # particles of a cell follow each other
        mine = np.repeat(np.isin(keys[begin], near), np.diff(begin, append=len(keys)))
        x, first, rows, keys = x[mine] - first[mine], first[mine], rows[mine], keys[mine]
        gradients = np.empty((len(rows), len(corners), len(h) + axial))
        # From the section's centroid to the mass's.
        out = p.products[rows, 1:] / h if axial else 0.0
        for c, corner in enumerate(corners):
            n = np.where(corner == 1, x, 1.0 - x)
            if axial:
                off_axis = first[:, 0] + corner[0] > frame.ghost  # on it no ring is stretched
                off_axis |= frame.origin[0] > 0.0
                gradients[:, c, 2] = off_axis * n.prod(axis=1) / p.origin[rows, 0]
                n = np.where(corner == 1, x + out, 1.0 - x - out)
            for d in range(len(h)):
                slope = (2 * corner[d] - 1) / h[d]
                gradients[:, c, d] = slope * n[:, [e for e in range(len(h)) if e != d]].prod(axis=1)
        begin, bodies = np.flatnonzero(np.diff(keys, prepend=-1)), p.body[rows]
        products = np.einsum("pid,pjd->pij", p.m[rows][:, None, None] * gradients, gradients)
        stiffness = np.add.reduceat(products, begin) if len(begin) else products
        at = np.zeros((len(begin), len(corners)), np.int64)
        for c, corner in enumerate(corners):
            keys = Vertices.key(rank, first[begin] + corner, bodies[begin])
            at[:, c] = np.minimum(np.searchsorted(known, keys), len(known) - 1)
            at[known[at[:, c]] != keys, c] = len(known)
        found.append((at, stiffness))
    at, stiffness = (np.concatenate(each) for each in zip(*found, strict=True))
    parts = rank.comm.allgather((at, stiffness))
    at, stiffness = (np.concatenate(each) for each in zip(*parts, strict=True))
    ascending = np.lexsort(at.T)  # not in the order of ranks
    return at[ascending], stiffness[ascending]


def steady(
    rank: RankState, vertices: Vertices, known: np.ndarray, folded: np.ndarray,
    few: tuple[np.ndarray, np.ndarray], folding: tuple[np.ndarray, np.ndarray],
) -> tuple[float, list[tuple[int, int, float]]]:  # fmt: skip
    """Give free vertices of the masses of others; collective.

    Parameters
    ----------
    known, folded : (k,) int64, (k,) float64
        Vertices around slaves and free ones, ascending, and their masses; changed in place.
    few : ((n,) int64, (f,) int64)
        The slaves, and the free vertices.
    folding : (n, 2^D) int64, (n, 2^D) float64
        See `stable_courant`.

    Returns
    -------
    float
        Courant number up to which all are stable.
    list of (int, int, float)
        What is given, see `missing_masses`.
    """
    light, side = np.concatenate(few), min(rank.grid.frame.cell)
    cells = near_cells(rank, light, known, each_once(folding[0].reshape(-1)))
    slaves, free = (np.searchsorted(known, each) for each in few)
    moved = missing_masses(free, slaves, folded, cells, side)
    for to, by, mass in moved:
        folded[to] += mass
        folded[by] -= mass
    moving = np.where(vertices.at_rest(known), 0.0, folded)
    return stable_courant(light, known, moving, cells, folding, side), moved
