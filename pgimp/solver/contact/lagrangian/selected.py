"""A selection of particles and vertices where contact is possible, as ranks keep it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pgimp.kernels.contact.lagrangian.reference_grid import FACE_PLANE, NUMBERS
from pgimp.kernels.contact.lagrangian.reference_numbers import ReferenceSupports
from pgimp.kernels.contact.lagrangian.vertices import ContactVertices
from pgimp.kernels.data.arguments import KernelScene
from pgimp.scene.scene import Scene


class Given(NamedTuple):
    """What a rank has of the selections of all ranks, one after the other."""

    every: np.ndarray  #: (m,) int64: Offsets of all its selected particles in the canonical order.
    offsets: np.ndarray  #: (n,) int64: Offsets by rank.
    keys: np.ndarray  #: (k,) int64: Keys of reference vertices by rank.
    #: particles, vertices: (ranks,) int64: How many there are for each rank.
    particles: np.ndarray
    vertices: np.ndarray


class Selection(NamedTuple):
    """Particles near contact round a rank's share of the vertices."""

    given: Given  #: What this rank has of all selections.
    table: np.ndarray  #: (n,) NEAR_PARTICLE: The particles, in canonical order.
    half_width: np.ndarray  #: (n, 3) float64: Their half-widths in cells.
    cut: bool  #: Whether any is cut.
    contact_vertices: ContactVertices  #: The candidate vertices, with room for sums.
    initial: ReferenceSupports  #: The particles' initial supports.
    #: (slots, 2) int64: Hash table of their reference vertices: offsets in `keys`.
    hashes: np.ndarray
    keys: np.ndarray  #: (k,) int64: Keys of these vertices, ascending.
    order: np.ndarray  #: (k,) int64: Their offsets among the vertices that other ranks send.
    #: particles, vertices: (ranks,) int64: How many particles and vertices each rank sends.
    particles: np.ndarray
    vertices: np.ndarray
    parts: Any = ()  #: Parts or (): Of bodies that are exact to their surface.


def flat(values: np.ndarray) -> np.ndarray:
    """Records of reference vertices as (n, NUMBERS) float64, without a copy."""
    return values.view(np.float64).reshape(-1, NUMBERS)


def plain(scene: Scene) -> KernelScene:
    """Kernel scene with current positions and whole particles, without materials."""
    frame, shape = scene.domain.frame, scene.settings.uncut
    return scene.setting.without_materials()._replace(frame=frame, shape=shape)


def mirrors_of(scene: Scene) -> np.ndarray:
    """The mirrors, (n,) FACE_PLANE."""
    frame = scene.domain.frame
    rows = []
    for each in scene.domain.mirrors:
        vertex = frame.ghost + (each.side > 0) * frame.cells[each.axis]
        rows.append((each.axis, each.side, vertex, each.number, each.sticks))
    return np.array(rows, FACE_PLANE)
