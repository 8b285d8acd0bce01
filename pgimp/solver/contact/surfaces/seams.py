"""Surfaces in periodic domains: their images across the seams, where facets look for others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.geometry.sweep import close_pairs
from pgimp.kernels.contact.impulses.reference_grid import Changes
from pgimp.kernels.contact.surfaces.data import Surface
from pgimp.kernels.data.frame import Frame
from pgimp.physics.rigid import RigidBody
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.rigid.images import spans
from pgimp.scene.scene import Scene

#: Cells within which ends are at a face.
_AT = 1e-6


def closed_faces(scene: Scene, body: LatticeBody, held: Sequence[tuple[int, int]]) -> Sequence:
    """Axis and side of the faces of the domain behind which a body goes on.

    These are the faces with a condition that `held` has, both ends of a direction that the body
    goes round, and the axis of rings. Where such ends differ, both are surfaces as a whole.
    """
    domain, case = scene.domain, scene.case
    cell, (low, high) = np.array(domain.frame.cell), body.region.bounds()
    below = np.array(low) - case.grid.origin < _AT * cell
    above = np.array(high) - case.grid.corner > -_AT * cell
    round_it = [d for d, joined in enumerate(domain.periodic) if joined and below[d] and above[d]]
    round_it = [d for d in round_it if _alike(body, d)]
    found = [face for face in held if not domain.periodic[face[0]]]
    found += [(d, side) for d in round_it for side in (-1, 1)]
    return [*found, (0, -1)] if case.axisymmetric else found


def _alike(body: LatticeBody, d: int) -> bool:
    """Whether both ends of a body along a direction are the same, to a box."""
    differ = np.True_
    for shift in (-0.2, 0.0, 0.3):  # what differs by rounding alone does so at one of them
        axes = [each + shift * size for each, size in zip(body.centres, body.size, strict=True)]
        inside = []
        for end in (body.edges[d][0] + _AT * body.size[d], body.edges[d][-1] - _AT * body.size[d]):
            axes[d] = np.array([end])
            points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
            inside.append(body.region.contains(points.reshape(-1, len(axes))))
        differ = differ & (inside[0] != inside[1])
    return not differ.any()


def one_period(
    body: LatticeBody, entry: RigidBody, frame: Frame, periods: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Periods of directions that a rigid body spans, and the ends of its part that counts.

    None if it spans none. Its images lie on each other, or side by side without a face between.
    """
    length, far = spans(entry, periods), _AT * np.array(frame.cell)
    if not length.any():
        return None
    low, high = (np.array(end, float) for end in body.region.bounds())
    origin, size = np.array(frame.origin), np.array(body.size)
    edge = origin + np.ceil((low - origin) / size - _AT) * size
    begin = np.where(high - low > length + size, edge, low - far)
    begin = np.where((low < origin + far) & (high > origin + length - far), origin, begin)
    return length, np.where(length > 0.0, begin, 0.0), np.where(length > 0.0, low, 0.0)


def close_images(
    low: np.ndarray,
    high: np.ndarray,
    origin: Sequence[float],
    periods: np.ndarray,
    reach: np.ndarray,
) -> np.ndarray:
    """Pairs of boxes within reach of each other, or of each other's images, ascending, (2, k)."""
    far = float(np.max(reach) + 0.5 * (high - low).max(initial=0.0))
    number, shift = _images(low, high, origin, periods, far)
    low, high = low[number] + shift, high[number] + shift
    a, b = close_pairs(low, high, reach).T
    near = (low[a] <= high[b] + reach).all(axis=1) & (low[b] <= high[a] + reach).all(axis=1)
    pairs = np.sort(np.stack([number[a[near]], number[b[near]]]), axis=0)
    return np.unique(pairs[:, pairs[0] != pairs[1]], axis=1)


def with_images(
    surface: Surface, some: np.ndarray, origin: Sequence[float], periods: np.ndarray, reach: float
) -> tuple[Surface, np.ndarray]:
    """Some facets and their images, as a surface, and the facet that each is: images come last."""
    D, now = len(origin), surface.now[some]
    number, shift = _images(now[:, :D], now[:, :D], origin, periods, reach)
    every, placed = some[number], now[number]
    placed[:, :D] += shift
    parts = {name: getattr(surface, name)[every] for name in ("x", "patch", "body", "tip")}
    return surface._replace(now=placed, turned=surface.turned[every], **parts), every


def places_with_images(
    x: np.ndarray, origin: Sequence[float], periods: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Places, (n, 3), and their images near the seams: which each is, and where."""
    D = len(origin)
    number, shift = _images(x[:, :D], x[:, :D], origin, periods, reach)
    placed = x[number]
    placed[:, :D] += shift
    return number, placed


def _images(
    low: np.ndarray, high: np.ndarray, origin: Sequence[float], periods: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and shifts of boxes and of their images, (n,) and (n, D).

    The boxes come first, shifted so that their middles are in the domain. Images are those of
    boxes within `reach` of a seam.
    """
    number, shift = np.arange(len(low)), np.zeros(low.shape)
    around = [(d, period) for d, period in enumerate(periods.tolist()) if period > 0.0]
    some = np.isfinite(low).all(axis=1)
    for d, period in around:
        middle = 0.5 * (low[some, d] + high[some, d])
        shift[some, d] = -np.floor((middle - origin[d]) / period) * period
    for d, period in around:
        below = np.flatnonzero(low[number, d] + shift[:, d] < origin[d] + reach)
        above = np.flatnonzero(high[number, d] + shift[:, d] > origin[d] + period - reach)
        number = np.concatenate([number, number[below], number[above]])
        shift = np.concatenate([shift, shift[below], shift[above]])
        first = len(shift) - len(above)
        shift[first - len(below) : first, d] += period
        shift[first:, d] -= period
    return number, shift


def changes_of_images(changes: Changes, frame: Frame, bits: Sequence[int]) -> Changes:
    """Changes at vertices, also at the images beyond the high end of x, which ranks store."""
    keys = changes.keys
    low = np.flatnonzero(keys >> sum(bits) < 2 * frame.ghost)
    image = keys[low] + (frame.cells[0] << sum(bits))
    each = zip(changes, (image, changes.velocities[low], changes.held[low]), strict=True)
    return Changes(*(np.concatenate(both) for both in each))
