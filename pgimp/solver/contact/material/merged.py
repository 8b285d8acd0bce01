"""The pairs of all ways to meet as one list, for one solution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.impulses.reference_grid import REFERENCE_VERTEX, ReferenceVertices
from pgimp.kernels.contact.material.merging import merge_pairs
from pgimp.solver.contact.impulses.impulse_contact import flat
from pgimp.solver.contact.impulses.joint import Joint


class Merger:
    """Merges pairs into arrays that last from step to step."""

    def __init__(self) -> None:
        self.call = Bound()
        self._rooms: list[_Room] = []

    def merged(self, every: Sequence[Joint]) -> Joint:
        """The pairs of one or several ways to meet, in the order of their places."""
        found = every[0]
        for n, other in enumerate(every[1:]):
            if n == len(self._rooms):
                self._rooms.append(_Room())
            room = self._rooms[n]
            room.grow(found, other)
            sizes = self.call(merge_pairs, _parts(found), _parts(other), room.marks, room.parts)
            found = room.filled(*sizes)
        return found


class _Room:
    """Room for the pairs of two ways to meet."""

    def __init__(self) -> None:
        self.parts = _empty(0, 0, 0, 0)
        self.marks = np.empty((2, 0), np.int64)

    def grow(self, one: Joint, other: Joint) -> None:
        """Have room for both."""
        pairs = len(one.pairs.ends) + len(other.pairs.ends)
        rows = len(one.coupling.answer) + len(other.coupling.answer)
        entries = len(one.coupling.column) + len(other.coupling.column)
        vertices = len(one.vertices.keys) + len(other.vertices.keys)
        have, coupling, (keys, _) = self.parts
        lacking = pairs > len(have.ends) or rows > len(coupling.answer)
        if lacking or entries > len(coupling.column) or vertices > len(keys):
            more = [each + each // 4 for each in (pairs, rows, entries, vertices)]
            self.parts = _empty(*more)
            self.marks = np.empty((2, more[3]), np.int64)

    def filled(self, pairs: int, rows: int, entries: int, vertices: int) -> Joint:
        """What is filled, without a copy."""
        every, (start, column, entry, answer), (keys, values) = self.parts
        records = values.view(REFERENCE_VERTEX).reshape(-1)
        return Joint(
            ContactPairs(*(part[:pairs] for part in every)),
            Coupling(start[: rows + 1], column[:entries], entry[:entries], answer[:rows]),
            ReferenceVertices(keys[:vertices], records[:vertices]),
        )


Parts = tuple[ContactPairs, Coupling, tuple[np.ndarray, np.ndarray]]


def _empty(pairs: int, rows: int, entries: int, vertices: int) -> Parts:
    """Allocate for so many of each."""
    values = flat(np.empty(vertices, REFERENCE_VERTEX))
    coupling = Coupling.empty(rows, entries)
    return ContactPairs.empty(pairs), coupling, (np.empty(vertices, np.int64), values)


def _parts(joint: Joint) -> Parts:
    """What `merge_pairs` takes."""
    keys, values = joint.vertices
    joint.coupling.start[0] = 0  # as it is, but in a rehearsal that only notes what would set it
    return joint.pairs, joint.coupling, (keys, flat(values))
