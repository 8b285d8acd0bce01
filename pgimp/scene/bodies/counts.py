"""Particle counts before creation, each rank a share of the planes, and overlap checks."""

from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np

from pgimp.case.locations import located
from pgimp.errors import CaseError
from pgimp.mpi.communicator import Communicator
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.scene import Scene


class Counts(NamedTuple):
    """Particle counts on all ranks before any particle exists.

    `counts` holds the particles of each body in each plane, (bodies, planes); `notes` names
    the bodies that share cells.
    """

    counts: np.ndarray
    notes: list[str]


def count_all(lattice: Lattice, comm: Communicator) -> Counts:
    """Count all particles, each rank a share of the planes, and check for overlaps.

    Raises
    ------
    CaseError
        The same on every rank: a point in two bodies, a body without a particle, too many
        surfaces in one place.
    """
    step = lattice.per_cell[0]
    columns = lattice.planes // step
    share = (comm.rank * columns // comm.size * step, (comm.rank + 1) * columns // comm.size * step)
    mine: Any
    try:
        mine = (lattice.count(share), *lattice.find_overlaps(share))
    except CaseError as error:
        mine = str(error)
    results = comm.allgather(mine)
    if failure := next((result for result in results if isinstance(result, str)), None):
        raise CaseError(failure)
    counts = np.concatenate([result[0] for result in results], axis=1)
    overlaps = [overlap for result in results for overlap in result[1]]
    overlaps.sort(key=lambda overlap: overlap[0])  # each pair's first point along x stays first
    problems = [message for _, message in overlaps[:1]]
    for body, name in enumerate(lattice.names):
        if counts[body].sum() == 0 and lattice.counted[body]:
            problems.append(
                f"bodies.{name}.region: contains no particle: no point of the lattice of "
                f"{' x '.join(str(n) for n in lattice.per_cell)} particles a cell lies inside; "
                "use a larger region, smaller cells (grid.cell), more particles per cell or "
                "surface: cut-particles"
            )
    if problems:
        raise CaseError("\n".join(problems))
    pairs = sorted(set().union(*(result[2] for result in results)))
    alone, number = lattice.shared, lattice.names.index
    notes = [
        f"bodies '{a}' and '{b}' have particles in the same cell: they start in contact, as one"
        for a, b in pairs
        if alone[tuple(sorted((number(a), number(b))))]
    ]
    counted = zip(lattice.bodies, lattice.counted, strict=True)
    notes += [note for body, counts_ in counted if counts_ for note in body.region.notes()]
    return Counts(counts, notes)


def count_particles(
    scene: Scene, comm: Communicator, only: Collection[str] | None = None
) -> tuple[Lattice, np.ndarray, list[str]]:
    """Count the particles: lattice, counts by body and plane, and notes; collective.

    Those of bodies that come in later stages count, too; see `present`. `only` leaves all bodies
    out but some.

    Raises
    ------
    CaseError
        See `count_all`.
    """
    lattice = Lattice(scene.case, only)
    with located(scene.case):
        taken = count_all(lattice, comm)
        if int(taken.counts.sum()) >= 2**53:
            raise CaseError("grid.cell: more particles than can be numbered; use larger cells")
    return lattice, taken.counts, taken.notes


def present(scene: Scene, counts: np.ndarray) -> np.ndarray:
    """Counts by body and plane without the bodies that come in later stages."""
    awaited = [name in scene.case.staged.awaited for name in scene.body_names]
    return np.where(np.array(awaited)[:, None], 0, counts)
