"""Connected groups of bodies near each other, each solved for on one rank."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.reference_grid import Changes
from pgimp.kernels.data.ledger import Ledger
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.impulses.messages import swap_parts, total

#: What groups book, by plane.
_BOOKED = ("work", "impulse", "wall_energy", "contact", "rigid_bodies", "contact_moments")


class Groups(NamedTuple):
    """Groups of bodies that may meet: what one exchanges depends on it alone."""

    of: np.ndarray  #: (bodies,) int64: Group of each body; -1 of those that join nothing.
    rank: np.ndarray  #: (groups,) int64: The rank that solves for each.

    def number(self, bodies: np.ndarray) -> np.ndarray:
        """Group of each pair of bodies, (n, 2); pairs that join nothing are in the first one."""
        return np.maximum(self.of[bodies].max(axis=1), 0)


def labels_of(scene: Scene, bonded: np.ndarray, walls: int) -> np.ndarray:
    """What each body joins to: bonded ones are one, (bodies + rigid bodies + walls,) int64.

    Those that move as prescribed, and walls, have -1.
    """
    rigid = scene.interaction.rigid_bodies
    soft, found = len(bonded), np.full(len(bonded) + len(rigid) + walls, -1)
    found[:soft] = bonded
    for body in rigid.free:
        found[soft + body] = soft + body
    return found


def _least_joined(count: int, pairs: np.ndarray) -> np.ndarray:
    """The least number that each number is joined to by pairs; those with one below 0 join none."""
    a, b = pairs[(pairs >= 0).all(axis=1)].T
    root = np.arange(count)
    while (root[a] != root[b]).any():
        least = np.minimum(root[a], root[b])
        np.minimum.at(root, root[a], least)
        np.minimum.at(root, root[b], least)
        root = root[root]
    while (root[root] != root).any():
        root = root[root]
    return root


def find_groups(
    labels: np.ndarray, met: np.ndarray, of: np.ndarray, x: np.ndarray, ranks: int
) -> Groups:
    """Find the groups of bodies, and share them out.

    Groups are in the order of their places along x, as slabs are. Ranks have parts of that order
    with about as many pairs.

    Parameters
    ----------
    labels : (bodies,) int64
        See `labels_of`.
    met : (m, 2) int64
        Pairs of bodies that may meet.
    of, x : (n,) int64, (n,) float64
        Facets' pairs, and where they are.
    """
    roots = np.append(_least_joined(1 + int(labels.max(initial=-1)), labels[met]), -1)[labels]
    known, number = np.unique(roots[met].max(axis=1), return_inverse=True)
    number = number[of]
    size = np.bincount(number, minlength=len(known))
    order = np.lexsort((known, np.bincount(number, x, len(known)) / np.maximum(size, 1)))
    whole = np.cumsum(size[order])
    rank = np.zeros(len(known), np.int64)
    rank[order] = ranks * (2 * whole - size[order]) // np.maximum(2 * whole[-1:], 1)
    at = np.minimum(np.searchsorted(known, roots), max(len(known) - 1, 0))
    there = roots >= 0
    there[there] = known[at[there]] == roots[there] if len(known) else False
    return Groups(np.where(there, at, -1), rank)


class Grouped(NamedTuple):
    """Pairs by group."""

    order: np.ndarray  #: (pairs,) int64: Their offsets, by group.
    first: np.ndarray  #: (groups + 1,) int64: The first of each in that order.
    number: np.ndarray  #: (groups,) int64: Numbers of the groups.
    sorted: bool  #: Whether the pairs have this order themselves.

    @classmethod
    def of(cls, pairs: ContactPairs, groups: Groups) -> Grouped:
        """Sort pairs by group."""
        count = len(pairs.ends)
        if len(groups.rank) < 2 and count:
            return _one_group(count)
        number = groups.number(pairs.ends["bodies"])
        order = np.argsort(number, kind="stable")
        first = np.flatnonzero(np.diff(number[order], prepend=-1))
        sort = bool((number[1:] >= number[:-1]).all())
        return cls(order, np.append(first, count), number[order][first], sort)

    def chosen(self, pairs: ContactPairs) -> ContactPairs:
        """The pairs in the order of groups; a copy if they have another."""
        return pairs if self.sorted else pairs.chosen(self.order)


@lru_cache(8)
def _one_group(count: int) -> Grouped:
    """So many pairs in one group; they are the same in most steps."""
    return Grouped(np.arange(count), np.array([0, count]), np.zeros(1, np.int64), True)


class GroupBooks(NamedTuple):
    """Books of groups, a plane each, for a ledger."""

    whole: np.ndarray  #: All their numbers.
    planes: Ledger
    ledger: Ledger
    first: list[tuple[np.ndarray, np.ndarray]]  #: First planes of the ledger, and of the books.


def books_of(ledger: Ledger, count: int) -> GroupBooks:
    """Empty books of as many groups."""
    shapes = [(count, *getattr(ledger, name).shape[1:]) for name in _BOOKED]
    ends = np.cumsum([int(np.prod(shape, dtype=int)) for shape in shapes])
    whole = np.zeros(ends[-1])
    parts = zip(_BOOKED, np.split(whole, ends[:-1]), shapes, strict=True)
    planes = ledger._replace(**{name: part.reshape(shape) for name, part, shape in parts})
    first = [(getattr(ledger, name)[:1], getattr(planes, name)[:1]) for name in _BOOKED]
    return GroupBooks(whole, planes, ledger, [pair for pair in first if pair[0].size])


def add_books(
    comm: Communicator, root: int, own: tuple[np.ndarray, GroupBooks] | None, ledger: Ledger
) -> None:
    """Add the books of all ranks' groups, in their order, to the first plane of the root's.

    Collective. `own` has the numbers of a rank's groups, and their books; None without any.
    """
    if comm.size == 1 and own is None:
        return
    number, (_, books, _, first) = own or (np.empty(0, np.int64), books_of(ledger, 0))
    if comm.size == 1 and len(number) == 1:
        for into, found in first:
            into += found
        return
    widths = [int(np.prod(getattr(books, name).shape[1:], dtype=int)) for name in _BOOKED]
    shaped = zip(_BOOKED, widths, strict=True)
    parts = [getattr(books, name).reshape(len(number), width) for name, width in shaped]
    rows = np.concatenate(parts, axis=1)
    if comm.size > 1:
        every = comm.gather((number, rows), root)
        if comm.rank != root:
            return
        number = np.concatenate([each[0] for each in every])
        rows = np.concatenate([each[1] for each in every])[np.argsort(number, kind="stable")]
    sums = np.add.accumulate(rows, axis=0)[-1:]
    ends = np.cumsum(widths)
    for name, a, b in zip(_BOOKED, ends - widths, ends, strict=True):
        into = getattr(ledger, name)
        for found in sums[:, a:b]:
            into[0] += found.reshape(into.shape[1:])


def share_changes(
    comm: Communicator, changes: Changes, extra: np.ndarray, ascending: bool
) -> Changes:
    """Return what all ranks have changed, by vertex; `extra` float64 are summed in place.

    Collective. Of `extra` each number is 0 on all ranks but one. `ascending` tells whether the keys
    of this rank's are.
    """
    if extra.size:
        extra[...] = total(comm, extra + 0.0)
    if comm.size == 1 and ascending:
        return changes
    mine = np.column_stack([changes.keys.view(float), changes.velocities, changes.held])
    every = mine if comm.size == 1 else swap_parts(comm, [mine] * comm.size)[0]
    keys = np.ascontiguousarray(every[:, 0]).view(np.int64)
    order = np.argsort(keys, kind="stable")
    changed = (np.ascontiguousarray(every[order, a:b]) for a, b in ((1, 4), (4, 7)))
    return Changes(keys[order], *changed)
