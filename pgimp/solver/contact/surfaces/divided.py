"""Facets of all bodies, of which each rank finds a part."""

from __future__ import annotations

from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np

from pgimp.errors import CaseError
from pgimp.geometry.measure import TangledError
from pgimp.mpi.collective import all_or_none
from pgimp.mpi.communicator import Communicator
from pgimp.scene.bodies.elements import Elements
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_elements import find_elements
from pgimp.scene.bodies.surface_patches import Around, Facets, facets_of
from pgimp.scene.bodies.surfaces.boxes import Closed


class Ends(NamedTuple):
    """Where a body's surface ends, see `facets_of`."""

    closed: Closed = ()
    ring: bool = False
    around: Around = None


def all_facets(
    comm: Communicator, bodies: list[LatticeBody], origin: np.ndarray, cell: np.ndarray,
    ends: list[Ends],
) -> list[Facets]:  # fmt: skip
    """Facets of bodies, see `facets_of`; collective.

    Each rank measures the surfaces in some planes of the bodies' lattices, and makes the patches of
    the bodies that begin there. Nothing depends on where others end.
    """
    if comm.size == 1:
        both = zip(bodies, ends, strict=True)
        return [facets_of(body, origin, cell, *its) for body, its in both]
    planes = planes_by_rank(bodies, comm.size)
    first = [min(each, default=0) for each in planes]

    def measured() -> list[list[tuple[int, Elements]]]:
        sent: list[list[tuple[int, Elements]]] = [[] for _ in range(comm.size)]
        for n, each in enumerate(planes):
            if comm.rank in each:
                part = find_elements(bodies[n], None, each[comm.rank], ends[n].closed)
                sent[first[n]].append((n, part))
        return sent

    found: list[list[Elements]] = [[] for _ in bodies]
    for n, part in chain(*comm.alltoall(all_or_none(comm, measured, TangledError, CaseError))):
        found[n].append(part)
    mine = []
    for n, (body, some) in enumerate(zip(bodies, found, strict=True)):
        if first[n] == comm.rank:
            whole = Elements(*map(np.concatenate, zip(*some, strict=True)))
            mine.append((n, facets_of(body, origin, cell, *ends[n], whole)))
    every = dict(chain(*comm.allgather(mine)))
    return [every[n] for n in range(len(bodies))]


def planes_by_rank(bodies: list[LatticeBody], ranks: int) -> list[dict[int, tuple[int, int]]]:
    """The planes of each body's lattice by the ranks that have them, about as many boxes each."""
    widths = [max(0, body.box[0][1] - body.box[0][0]) + 2 for body in bodies]
    # A surface crosses a plane in about as many boxes as its lattice there has along its edges.
    many = [1.0 + sum(1.0 + end - begin for begin, end in body.box[1:]) for body in bodies]
    cost = np.repeat(many, widths)
    owner = ((np.cumsum(cost) - 0.5 * cost) * (ranks / max(cost.sum(), 1.0))).astype(np.int64)
    found, begin = [], 0
    for body, width in zip(bodies, widths, strict=True):
        own, low = owner[begin : begin + width], body.box[0][0] - 1
        begin += width
        ends = [*np.flatnonzero(np.diff(own, prepend=-1)).tolist(), width]
        parts = pairwise(ends)
        found.append({int(own[a]): (low + a, low + b) for a, b in parts})
    return found
