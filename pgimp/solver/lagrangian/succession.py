"""Momentum of vertices that become slaves with a stage."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.motion import KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.lagrangian.slaves import take_vectors
from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.lagrangian.slave_rows import exchange
from pgimp.solver.lagrangian.slaves import Slaves
from pgimp.solver.rank_state import RankState


def hand_momentum_over(
    rank: RankState, before: Slaves | None, fields: int, came: Mapping[int, int]
) -> None:
    """Give the momentum of vertices that a stage makes slaves to their masters; collective.

    They then move as these. So no momentum is lost where bodies part, or join. They stay where they
    are; by the little that their masters do not say of that, angular momentum changes.

    Parameters
    ----------
    before : Slaves or None
        Those of the stage before.
    fields : int
        How many velocity fields that had.
    came : mapping of int to int
        Its field by field, of those that came from one.
    """
    slaves = rank.slaves
    new = _new_ones(rank, slaves, before, fields, came)
    if not needed(new.any()):
        return
    values, rows = rank.grid.kept.values, slaves.located(rank)
    v, known = np.empty((len(slaves.keys), 3)), np.empty((len(slaves.masters), 3))
    for which, (at, found) in enumerate(((rows.own, v), (rows.masters, known))):
        rank.call(take_vectors, values, RECORD, KEPT_VELOCITY, at, found)
        exchange(rank.comm, found, rows, which)
    of, change = slaves.of[new], np.zeros_like(known)
    share = slaves.weights[new] * slaves.own.sum(axis=0)[new, None]
    np.add.at(change, of, share[..., None] * (v[new, None] - known[of]))
    mass = slaves.mass
    change = np.divide(change, mass[:, None], out=np.zeros_like(change), where=mass[:, None] > 0.0)
    here, velocity = rows.masters >= 0, slice(KEPT_VELOCITY, KEPT_VELOCITY + 3)
    values.reshape(-1, RECORD)[rows.masters[here], velocity] += change[here]
    slaves.spread(rank, values, KEPT_VELOCITY)


def _new_ones(
    rank: RankState, slaves: Slaves, before: Slaves | None, fields: int, came: Mapping[int, int]
) -> np.ndarray:
    """Mask of the slaves that were none, or had other masters or weights."""
    if before is None or not len(before.keys):
        return np.ones(len(slaves.keys), bool)
    now = Vertices.sizes(rank)[2]
    vertex, field = np.divmod(slaves.keys, now)
    old = np.array([came.get(each, -1) for each in range(now)])[field]
    keys = np.where(old >= 0, vertex * fields + old, -1)
    at = np.minimum(np.searchsorted(before.keys, keys), len(before.keys) - 1)
    masters = slaves.masters[slaves.of] // now, before.masters[before.of[at]] // fields
    same = (masters[0] == masters[1]) & (slaves.weights == before.weights[at])
    return (before.keys[at] != keys) | ~same.all(axis=1)
