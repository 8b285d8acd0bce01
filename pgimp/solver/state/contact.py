"""Contact in checkpoints: velocity fields, forces at which the next step begins, the search."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from pgimp.errors import DamagedError

if TYPE_CHECKING:
    from pgimp.io.checkpoints.checkpointfile import CheckpointFile
    from pgimp.solver.rank import Rank

#: Datasets of a checkpoint.
FIELDS, FORCES, SEARCH = "velocity-fields", "contact-forces", "contact-search"
LOADS = "contact-loads"
BEARING = "contact-vertices"

#: Columns of the forces that are whole numbers, of vertices and bodies, and their bound.
_NUMBERS, _GREATEST = 5, 2.0**52


def stored_contact(rank: Rank, source: CheckpointFile, read: Callable) -> dict[str, np.ndarray]:
    """What a checkpoint has of the state of contact, by name; `read` reads a dataset by its shape.

    An older one has none: fields are assigned anew, the next step begins at zero forces, and with
    a search.

    Raises
    ------
    DamagedError
        If it is not of this scene.
    """
    found, contact, bodies = {}, rank.contact, len(rank.scene.body_names)
    if contact.assignment.size and FIELDS in source.whole:
        assignment = read(source, FIELDS, (1 + bodies,))
        if (assignment < 0).any() or (assignment[1:] >= bodies).any():
            raise DamagedError("the velocity fields of its bodies are none")
        found[FIELDS] = assignment
    width = contact.kept_forces.shape[1]
    if width and FORCES in source.whole:
        forces = read(source, FORCES, (*source.whole[FORCES][1][:1], width))
        numbers = forces[:, :_NUMBERS]
        if (numbers != np.floor(numbers)).any() or (abs(numbers) > _GREATEST).any():
            raise DamagedError("its forces of contact are at no vertices")
        found[FORCES] = forces
    if SEARCH in source.whole:
        found[SEARCH] = read(source, SEARCH, source.whole[SEARCH][1])
        if len(found[SEARCH]) < 8 or not np.isfinite(found[SEARCH]).all():
            raise DamagedError("its search for contact is none")
    if contact.surface_loads.shape[1] and LOADS in source.whole:
        shape = (*source.whole[LOADS][1][:1], contact.surface_loads.shape[1])
        found[LOADS] = read(source, LOADS, shape)
        if found[LOADS][0, 0] < 0.0:
            raise DamagedError("the time of its loads on surfaces is none")
    if rank.averaged_mass and BEARING in source.whole:
        found[BEARING] = read(source, BEARING, source.whole[BEARING][1]).view(np.int64)
        if (np.diff(found[BEARING], prepend=-1) <= 0).any():
            raise DamagedError("what contact moves are no vertices")
    return found


def restore_contact(rank: Rank, found: dict[str, np.ndarray]) -> None:
    """Continue with what `stored_contact` found; collective."""
    if SEARCH in found:
        rank.contact.restore_search(found[SEARCH])
    if FIELDS in found:
        rank.contact.restore(rank, found[FIELDS])
    if FORCES in found:
        rank.contact.restore_forces(found[FORCES])
    if LOADS in found:
        rank.contact.restore_loads(found[LOADS])
    if BEARING in found:
        rank.averaged_mass.restore(found[BEARING])
