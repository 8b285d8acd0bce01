"""Particles as boxes, drawn from back to front; of many only the nearest to the eye."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pgimp.io.results.reader import Frame
from pgimp.utilities.plot.camera import Camera
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.selection import Block, Selection

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = np.ndarray

FEW = 20_000
"""Up to this number, all particles are drawn."""

SPOTS = 1000
"""Spots along the longer side of a picture with more particles; each shows one."""

_SEAM = 0.5  # points; avoids visible hairlines between neighbours


def extent(frame: Frame, selection: Selection, camera: Camera) -> Array:
    """Return the corners of the particles' extent in a picture, (2, 2); low above high if empty."""
    reach = np.abs(camera.faces()[0]).max(axis=(0, 1))
    found = np.array([[np.inf] * 2, [-np.inf] * 2])
    for block in selection.blocks(frame, None):
        if len(block.radius):
            place, half = camera.project(block.position)[:, :2], block.radius[:, None] * reach
            found[0] = np.minimum(found[0], (place - half).min(axis=0))
            found[1] = np.maximum(found[1], (place + half).max(axis=0))
    return found


def visible(
    frame: Frame, selection: Selection, quantity: Quantity, camera: Camera, inside: Array
) -> tuple[Block, int]:
    """Select the visible particles, in memory independent of their number.

    Parameters
    ----------
    selection : Selection
        Particles to select from, at least one.
    inside : ndarray, shape (2, 2)
        Low and high corner of their extent, or more.

    Returns
    -------
    particles : Block
        All, if there are few. Otherwise for each spot the particle with its centre nearest to the
        eye, among equals the greatest id. A spot is the least area that the boxes cover, so that no
        gaps show.
    total : int
        Number of particles before the selection.
    """
    spot = (inside[1] - inside[0]).max() / SPOTS
    kept: Block | None = None
    total = 0
    for block in selection.blocks(frame, quantity):
        total += len(block.id)
        if kept is not None:
            block = Block(*(np.concatenate(pair) for pair in zip(kept, block, strict=True)))
        place = camera.project(block.position)
        order = np.lexsort((-block.id, -place[:, 2]))
        if len(frame) * max(1, len(selection.angles)) > FEW:
            column, row = np.floor((place[order, :2] - inside[0]) / spot).astype(np.int64).T
            order = order[np.unique(row * (SPOTS + 2) + column, return_index=True)[1]]
        kept = block.take(order)
    assert kept is not None
    if len(kept.id) < total:
        larger = np.maximum(1.0, spot / np.maximum(kept.radius, 1e-300))
        edges = kept.edges * np.where(kept.radius > 0.0, larger, 1.0)[:, None, None]
        kept = kept._replace(radius=np.maximum(kept.radius, spot), edges=edges)
    return kept, total


def draw(axis: Axes, camera: Camera, particles: Block, colours: Array, flat: bool) -> None:
    """Add particles to axes, as the visible faces of boxes, or of what these have become.

    Parameters
    ----------
    axis : matplotlib.axes.Axes
        The axes.
    particles : Block
        The particles; those without edges are boxes along the axes of space.
    colours : ndarray, shape (n, 4)
        Red, green, blue and opacity.
    flat : bool
        Whether only their faces across z are seen, as in 2D.
    """
    if particles.edges.size:
        _draw_sheared(axis, camera, particles, colours, flat)
    else:
        _draw_boxes(axis, camera, particles, colours)


def _draw_sheared(axis: Axes, camera: Camera, particles: Block, colours: Array, flat: bool) -> None:
    """Add parallelepipeds, each in the shade of its own faces."""
    from matplotlib.collections import PolyCollection

    order = np.argsort(camera.project(particles.position)[:, 2], kind="stable")
    centre, edges = particles.position[order, None], particles.edges[order]
    faces, shades = [], []
    for across in (2,) if flat else (0, 1, 2):
        a, b, c = (edges[:, (across + k) % 3] for k in (1, 2, 0))
        normal = np.cross(a, b)
        normal *= np.sign(np.einsum("ni,ni->n", normal, c))[:, None]
        outward = np.sign(normal @ camera.towards)[:, None, None]
        ring = np.stack([a + b, b - a, -a - b, a - b], axis=1) + outward * c[:, None]
        faces.append(camera.project(centre + ring)[..., :2])
        length = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        light = ((normal / length) ** 2) @ camera.light
        shades.append(np.where(light > 0.0, light, 1.0))
    shaded = np.repeat(colours[order, None], len(faces), axis=1)
    shaded[..., :3] *= np.clip(np.stack(shades, axis=1), 0.0, 1.0)[..., None]
    axis.add_collection(
        PolyCollection(
            list(np.stack(faces, axis=1).reshape(-1, 4, 2)),
            facecolors=shaded.reshape(-1, 4),
            edgecolors="face",
            lw=_SEAM,
            snap=False,
            rasterized=len(order) > FEW,
        )
    )


def _draw_boxes(axis: Axes, camera: Camera, particles: Block, colours: Array) -> None:
    """Add boxes along the axes of space."""
    from matplotlib.collections import EllipseCollection
    from matplotlib.path import Path

    radius = particles.radius
    place = camera.project(particles.position)
    order = np.argsort(place[:, 2], kind="stable")
    corners, light = camera.faces()
    shaded = np.repeat(colours[order], len(light), axis=0)
    shaded[:, :3] *= np.tile(light, len(order))[:, None]
    # Ellipses have sizes in data units. Of k paths, item i has path i modulo k.
    size = np.repeat(2.0 * radius[order], len(light))
    shown = EllipseCollection(
        size,
        size,
        0.0,
        units="xy",
        offsets=np.repeat(place[order, :2], len(light), axis=0),
        offset_transform=axis.transData,
        facecolors=shaded,
        edgecolors="face",
        lw=_SEAM,
        snap=False,
        rasterized=len(order) > FEW,
    )
    shown.set_paths([Path(one, closed=False) for one in corners])
    axis.add_collection(shown)
