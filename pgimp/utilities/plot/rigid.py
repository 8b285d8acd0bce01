"""Outlines of rigid bodies in pictures of frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.io.results.frame import Frame, Reading
from pgimp.utilities.plot.camera import Camera

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = np.ndarray

#: Greatest widening of a picture for rigid bodies, over its size.
_ROOM = 0.12
#: Distance from a plane of symmetry that is none, over the greatest coordinate.
_ON = 1e-9
#: Sections of a body of revolution.
_SECTIONS = 18


def lines(
    frame: Frame,
    camera: Camera,
    angles: Sequence[float] = (),
    mirrored: Sequence[tuple[int, float]] = (),
) -> Array:
    """Return the edges of the surfaces in a picture, (n, 2, 2); possibly none.

    Parameters
    ----------
    frame : Frame
        A frame of particles, beside which rigid bodies have theirs.
    angles : sequence of float
        Angles about y at which sections are shown; some of them, and both ends.
    mirrored : sequence of (int, float)
        Planes of symmetry, by axis and coordinate, at which surfaces end and images are added.
    """
    path = frame.path.with_name(frame.path.name.replace("particles-", "rigid-"))
    if not path.is_file():
        return np.zeros((0, 2, 2))
    with Reading(path) as file:
        position, cells = file["position"][:], file["connectivity"][:]
    if cells.shape[1] == 1:
        return np.zeros((0, 2, 2))
    pairs = [cells] if cells.shape[1] == 2 else [cells[:, [k, (k + 1) % 4]] for k in range(4)]
    edges = position[np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)]
    for axis, plane in mirrored:
        first = frame.rows("position", 0, 1)
        edges = _with_image(edges, axis, plane, first[0, axis] if len(first) else plane)
    if not len(angles):
        return _projected(camera, edges)
    found = []
    for angle in (*angles[:: max(1, len(angles) // _SECTIONS)], angles[-1]):
        place = edges.astype(np.float64)
        place[..., 2] = -np.sin(angle) * place[..., 0]
        place[..., 0] *= np.cos(angle)
        found.append(_projected(camera, place))
    return np.concatenate(found)


def _projected(camera: Camera, edges: Array) -> Array:
    """Return edges in a picture, (n, 2, 2)."""
    return camera.project(edges.reshape(-1, 3))[:, :2].reshape(-1, 2, 2)


def _with_image(edges: Array, axis: int, plane: float, inside: float) -> Array:
    """Return edges up to a plane of symmetry, and their images; those in the plane are no edges.

    `inside` is a coordinate on the side of the material.
    """
    away = np.copysign(1.0, inside - plane) * (edges[..., axis] - plane)
    there = away.max(axis=1) > _ON * np.abs(edges[..., axis]).max(initial=0.0)
    edges, away = edges[there].copy(), away[there]
    for end in (0, 1):
        cut = away[:, end] < 0.0
        near, far = away[cut, end], away[cut, 1 - end]
        part = (near / (near - far))[:, None]
        edges[cut, end] += part * (edges[cut, 1 - end] - edges[cut, end])
    image = edges.copy()
    image[..., axis] = 2.0 * plane - image[..., axis]
    return np.concatenate([edges, image])


def widened(inside: Array, edges: list[Array]) -> Array:
    """Return the corners of a picture, (2, 2), widened for rigid bodies beyond them."""
    points = np.concatenate([some.reshape(-1, 2) for some in edges])
    if not len(points):
        return inside
    room = _ROOM * (inside[1] - inside[0]).max()
    return np.array(
        [
            np.maximum(np.minimum(inside[0], points.min(axis=0)), inside[0] - room),
            np.minimum(np.maximum(inside[1], points.max(axis=0)), inside[1] + room),
        ]
    )


def draw_lines(axis: Axes, edges: Array, flat: bool) -> None:
    """Add edges to axes: the outline in 2D, in 3D a net."""
    from matplotlib.collections import LineCollection

    width = 1.1 if flat else 0.25
    axis.add_collection(
        LineCollection(list(edges), colors="#333333" if flat else "#77777766", linewidths=width)
    )
