"""From where particles are seen: directions, and the outline of a particle's box."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.schema.messages import unknown
from pgimp.tools.plot.runs import AXES

Array = np.ndarray

_X, _Y, _Z = np.eye(3)
# To the right and up, as seen from a face of the domain.
_FACES = {
    "x-min": (-_Y, _Z),
    "x-max": (_Y, _Z),
    "y-min": (_X, _Z),
    "y-max": (-_X, _Z),
    "z-min": (-_X, _Y),
    "z-max": (_X, _Y),
}
_CORNER = (0.44, -0.77, 0.46)
NAMES = ("corner", *_FACES)


class Camera(NamedTuple):
    """A parallel projection.

    Attributes
    ----------
    right, up : ndarray, shape (3,)
        Unit vectors of the picture.
    """

    right: Array
    up: Array

    @property
    def towards(self) -> Array:
        """Unit vector towards the eye."""
        return np.cross(self.right, self.up)

    @property
    def along_axes(self) -> bool:
        """Whether the picture's axes are axes of space."""
        return bool(np.isin(np.abs([self.right, self.up]), (0.0, 1.0)).all())

    def axis(self, direction: Array) -> tuple[str, bool]:
        """Return the name of an axis of space and whether it points the other way."""
        number = int(np.argmax(np.abs(direction)))
        return AXES[number], bool(direction[number] < 0.0)

    def project(self, position: Array) -> Array:
        """Return coordinates in the picture, the third towards the eye: (n, 3) from (n, 3)."""
        return position @ np.stack([self.right, self.up, self.towards], axis=1)

    def generators(self, dimension: int) -> Array:
        """Return the projected half-edges of a box of half-width 1, (k, 2), each with y >= 0."""
        edges = np.stack([self.right, self.up], axis=1)[:dimension]
        edges = edges[np.linalg.norm(edges, axis=1) > 1e-9]
        back = (edges[:, 1] < -1e-12) | ((np.abs(edges[:, 1]) <= 1e-12) & (edges[:, 0] < 0.0))
        edges[back] *= -1.0
        return edges[np.argsort(np.arctan2(edges[:, 1], edges[:, 0]))]

    def outline(self, dimension: int) -> Array:
        """Return the corners of that box's outline, counter-clockwise, (2k, 2)."""
        edges = self.generators(dimension)
        steps = 2.0 * np.concatenate([edges, -edges])
        return -edges.sum(axis=0) + np.cumsum(steps, axis=0)


def camera(text: str | None, dimension: int, normal: int | None) -> Camera:
    """Return the camera that a name or a direction stands for.

    Parameters
    ----------
    text : str or None
        A face of the domain, ``corner``, or the direction towards the eye, ``X,Y,Z``.
    dimension : int
        Of the case; anything but 3 is seen from z-max.
    normal : int or None
        The axis across a slice, from which it is seen by default.

    Raises
    ------
    UsageError
        If it is none of these.
    """
    if text is not None and dimension < 3:
        raise UsageError(f"--camera is for three dimensions; this case has {dimension}")
    if dimension < 3:
        return Camera(*_FACES["z-max"])
    if text is None:
        text = "corner" if normal is None else ("x-max", "y-min", "z-max")[normal]
    if text in _FACES:
        return Camera(*_FACES[text])
    try:
        towards = np.array(_CORNER if text == "corner" else [float(x) for x in text.split(",")])
    except ValueError:
        what = "direction X,Y,Z" if "," in text else "camera"
        raise UsageError(f"--camera: {unknown(what, text, NAMES, 'there are X,Y,Z and')}") from None
    if towards.shape != (3,) or not np.isfinite(towards).all() or not towards.any():
        raise UsageError(f"--camera {text}: a direction is three numbers, X,Y,Z, not all zero")
    towards = towards / np.linalg.norm(towards)
    right = np.cross(_Z, towards)
    if np.linalg.norm(right) < 1e-9:
        right = _X * np.sign(towards[2])
    right /= np.linalg.norm(right)
    return Camera(right, np.cross(towards, right))
