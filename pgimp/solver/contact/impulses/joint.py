"""Pairs of all ranks, joined on the rank that solves for their impulses, and what they change."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.kernels.contact.data import PAIR_STATE
from pgimp.kernels.contact.impulses.coupling import Coupling
from pgimp.kernels.contact.impulses.pairs import ENDS, ContactPairs
from pgimp.kernels.contact.impulses.reference_grid import REFERENCE_VERTEX, ReferenceVertices
from pgimp.mpi.communicator import Communicator
from pgimp.solver.contact.impulses.messages import swap


class Joint(NamedTuple):
    """Candidate pairs with their rows of B, and the vertices that these have."""

    pairs: ContactPairs
    coupling: Coupling  #: Columns are numbers of `vertices`.
    vertices: ReferenceVertices


def join(comm: Communicator, root: int, mine: Joint) -> tuple[int, Joint | None]:
    """Number of pairs of all ranks; on rank `root`, if any, the pairs in the order of vertices.

    Collective. Columns of B are then numbers of the returned vertices, and rows of the pairs are
    numbers in the joint matrix.
    """
    mine = _used(mine)
    pairs, coupling, vertices = mine
    counts = np.array(
        [len(pairs.ends), len(coupling.answer), len(coupling.column), len(vertices.keys)]
    )
    every = np.empty((comm.size, 4), np.int64)
    comm.Allgather(counts, every)
    found = int(every[:, 0].sum())
    if found == 0:
        return 0, None
    message = np.concatenate([part.reshape(-1).view(np.float64) for part in _parts(mine)])
    sent, received = np.zeros((2, comm.size), np.int64)
    sent[root] = len(message)
    if comm.rank == root:
        received[:] = [_size(each) for each in every.tolist()]
    arrived = swap(comm, message, sent, received)
    if comm.rank != root:
        return found, None
    pieces = np.split(arrived, np.cumsum(received)[:-1])
    unpacked = [_unpack(piece, each) for piece, each in zip(pieces, every.tolist(), strict=True)]
    return found, merged(unpacked)


def _used(joint: Joint) -> Joint:
    """Without the vertices that no row has."""
    marks = np.zeros(len(joint.vertices.keys), bool)
    marks[joint.coupling.column] = True
    number, vertices = np.cumsum(marks) - 1, joint.vertices
    return Joint(
        joint.pairs,
        joint.coupling._replace(column=number[joint.coupling.column]),
        ReferenceVertices(vertices.keys[marks], vertices.values[marks]),
    )


def _parts(joint: Joint) -> tuple[np.ndarray, ...]:
    """All arrays, of numbers and records of 8 bytes each."""
    (ends, states, rigid), coupling, vertices = joint
    return (
        ends, states, rigid, coupling.start[1:], coupling.column, coupling.entry, coupling.answer,
        vertices.keys, vertices.values,
    )  # fmt: skip


def _shapes(counts: list[int]) -> list[tuple[tuple[int, ...], np.dtype]]:
    """Shapes and types of `_parts`."""
    pairs, rows, entries, vertices = counts
    whole, real = np.dtype(np.int64), np.dtype(np.float64)
    return [
        ((pairs,), ENDS), ((pairs,), PAIR_STATE), ((pairs, 3, 3), real), ((rows,), whole),
        ((entries,), whole), ((entries, 1), real), ((rows, 3), real),
        ((vertices,), whole), ((vertices,), REFERENCE_VERTEX),
    ]  # fmt: skip


def _size(counts: list[int]) -> int:
    """Length of a message in numbers of 8 bytes."""
    shapes = _shapes(counts)
    return sum(int(np.prod(shape)) * kind.itemsize // 8 for shape, kind in shapes)


def _unpack(message: np.ndarray, counts: list[int]) -> Joint:
    """The pairs of a message."""
    arrays, begin = [], 0
    for shape, kind in _shapes(counts):
        end = begin + int(np.prod(shape)) * kind.itemsize // 8
        arrays.append(message[begin:end].view(kind).reshape(shape))
        begin = end
    start = np.concatenate([np.zeros(1, np.int64), arrays[3]])
    return Joint(
        ContactPairs(*arrays[:3]), Coupling(start, *arrays[4:7]), ReferenceVertices(*arrays[7:])
    )


def merged(every: list[Joint]) -> Joint:
    """The pairs of all ranks, or ways to meet, in the order of their vertices."""
    keys = np.concatenate([each.vertices.keys for each in every])
    values = np.concatenate([each.vertices.values for each in every])
    keys, first = np.unique(keys, return_index=True)
    rows = entries = 0
    starts, columns = [np.zeros(1, np.int64)], []
    for (ends, _, _), coupling, own in every:
        sides = ends["rows"]
        sides[sides >= 0] += rows
        starts.append(coupling.start[1:] + entries)
        columns.append(np.searchsorted(keys, own.keys)[coupling.column])
        rows, entries = rows + len(coupling.answer), entries + len(coupling.column)
    pairs = ContactPairs(
        np.concatenate([each.pairs.ends for each in every]),
        np.concatenate([each.pairs.states for each in every]),
        np.concatenate([each.pairs.rigid for each in every]),
    )
    coupling = Coupling(
        np.concatenate(starts),
        np.concatenate(columns),
        np.concatenate([each.coupling.entry for each in every]),
        np.concatenate([each.coupling.answer for each in every]),
    )
    order = np.lexsort(pairs.ends["vertex"].T[::-1])
    return Joint(pairs.chosen(order), coupling, ReferenceVertices(keys, values[first]))
