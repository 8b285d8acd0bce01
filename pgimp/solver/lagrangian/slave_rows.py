"""Where a rank has slaves and their masters, and their vectors for other ranks.

See `pgimp.solver.lagrangian.slaves`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.kernels.data.record import RECORD
from pgimp.mpi.communicator import Communicator
from pgimp.solver.lagrangian.masters import REACH, Vertices
from pgimp.solver.rank_state import RankState


class Rows(NamedTuple):
    """Where a rank has the slaves and their masters, until its planes or its window change."""

    #: slaves, own: (n,) int64: Number of each slave's record, -1 where the rank has none; likewise
    #: of those that it owns.
    slaves: np.ndarray
    own: np.ndarray
    masters: np.ndarray  #: (m,) int64: Likewise of all masters.
    #: tuple of 2 (k,) int64: Numbers of slaves, and of masters, that other ranks may need;
    #: ascending, as ranks are.
    shared: tuple[np.ndarray, np.ndarray]
    #: tuple of 2 (j,) int64: Numbers of the rank's own ones among both.
    mine: tuple[np.ndarray, np.ndarray]
    counts: np.ndarray  #: (2, ranks) int64: How many of both each rank has.
    #: (c,) int64: Numbers of changes of mass at the rank's own vertices; their records and layers
    #: follow.
    changed: np.ndarray
    #: records, layers: (c,) int64.
    records: np.ndarray
    layers: np.ndarray
    #: (k, 2) int64: Records of both copies of what is at the ends of a ring of one rank.
    copies: np.ndarray


def find_rows(
    rank: RankState, slaves_of: np.ndarray, masters_of: np.ndarray, changes_of: np.ndarray
) -> Rows:
    """Find where a rank has slaves, masters and what changes by these; collective."""
    owned, slab, ring = rank.grid.owned, rank.slab, rank.scene.domain.ring_layers
    slaves, i = records_of(rank, slaves_of)
    masters, k = records_of(rank, masters_of)
    changes, n = records_of(rank, changes_of)
    changed = np.flatnonzero((changes >= 0) & (n < owned))
    own, mine = (slaves >= 0) & (i < owned), (masters >= 0) & (k < owned)
    # Whatever is this near to the end of a slab may be of use to other ranks.
    ends = rank.comm.allgather((slab.first, slab.first + owned) if owned else ())
    edges = np.unique([end for each in ends for end in each])
    edges = edges[1:-1] if not ring or len(edges) < 3 else edges
    near, have = [], []
    for keys, here in ((slaves_of, own), (masters_of, mine)):
        x = Vertices.numbers(rank, keys)[0]
        apart = np.abs(x[:, None] - edges[None]) if len(edges) else np.full((len(x), 1), 99)
        apart = np.minimum(apart, ring - apart) if ring and len(edges) else apart
        near.append(np.flatnonzero(apart.min(axis=1) <= 2 * REACH))
        have.append(near[-1][here[near[-1]]])
    counts = np.array(rank.comm.allgather([len(each) for each in have])).T
    layers = np.minimum(n[changed], max(slab.layers - 1, 0))
    twice = [
        here[(here >= 0) & (plane + ring < rank.grid.planes)]
        for here, plane in ((slaves, i), (masters, k))
    ]
    first = np.concatenate(twice)[:, None] if ring else np.zeros((0, 1), np.int64)
    copies = np.hstack([first, first + ring * (rank.grid.window.stride[0] // RECORD)])
    return Rows(
        slaves, np.where(own, slaves, -1), masters, (near[0], near[1]), (have[0], have[1]),
        counts, changed, changes[changed], layers, copies,
    )  # fmt: skip


def records_of(rank: RankState, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the records of vertices, -1 where the rank has none; and their planes."""
    grid, ring = rank.grid, rank.scene.domain.ring_layers
    x, y, z, field = Vertices.numbers(rank, keys)
    (i, j, k), extent = (
        (each - low for each, low in zip((x, y, z), grid.window.lower, strict=True)),
        (grid.planes, *grid.window.extent[1:]),
    )
    i = i % ring if ring else i
    there = (i >= 0) & (i < extent[0]) & (j >= 0) & (j < extent[1])
    there &= (k >= 0) & (k < extent[2])
    stride = [s // RECORD for s in grid.window.stride]
    size = extent[1] * extent[2]
    at = i * stride[0] + field * size + j * stride[1] + k * stride[2]
    return np.where(there, at, -1), i


def places_of(rank: RankState, keys: np.ndarray) -> np.ndarray:
    """Coordinates of vertices in the initial state, (n, 3)."""
    frame, found = rank.grid.frame, np.zeros((len(keys), 3))
    for d, number in enumerate(Vertices.numbers(rank, keys)[: len(frame.cell)]):
        found[:, d] = frame.origin[d] + (number - frame.ghost) * frame.cell[d]
    return found


def exchange(comm: Communicator, values: np.ndarray, rows: Rows, which: int) -> None:
    """Set the vectors of slaves (0) or masters (1) that other ranks own; collective."""
    counts = rows.counts[which]
    if comm.size == 1 or not counts.sum():
        return
    sent = np.zeros((int(counts.max()), 3))
    sent[: counts[comm.rank]] = values[rows.mine[which]]
    found = np.empty((comm.size, *sent.shape))
    comm.Allgather(sent, found)
    known = np.arange(len(sent))[None] < counts[:, None]
    values[rows.shared[which]] = found[known]
