"""Viewing directions, and the visible faces of a particle's box."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.schema.messages import unknown
from pgimp.utilities.plot.runs import AXES, PlotFrame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = np.ndarray

_ARROW = 24.0

# Towards the eye.
_EYES = {
    "corner": np.array([0.44, -0.77, 0.46]),
    **{f"{axis}-min": -unit for axis, unit in zip(AXES, np.eye(3), strict=True)},
    **{f"{axis}-max": unit for axis, unit in zip(AXES, np.eye(3), strict=True)},
}
# Lightness of faces across x, y and z: shows the shape without looking like another value.
_LIGHT = np.array([0.77, 0.89, 1.0])


class Camera(NamedTuple):
    """A parallel projection."""

    #: right, up: ndarray, shape (3,): Unit vectors of the picture.
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
        """Return the name of an axis of space and whether it is reversed."""
        number = int(np.argmax(np.abs(direction)))
        return AXES[number], bool(direction[number] < 0.0)

    def project(self, position: Array) -> Array:
        """Return coordinates in the picture, the third towards the eye, (..., 3)."""
        return position @ np.stack([self.right, self.up, self.towards], axis=1)

    @property
    def light(self) -> Array:
        """Lightness of faces across x, y and z, (3,); 1 for the lightest that is seen."""
        seen = np.abs(self.towards) > 1e-9
        return _LIGHT / _LIGHT[seen].max()

    def faces(self) -> tuple[Array, Array]:
        """Return the visible part of a box of half-width 1: its faces and their lightness.

        Returns
        -------
        corners : ndarray, shape (k, 4, 2)
            Corners in the picture.
        light : ndarray, shape (k,)
            1 for the lightest.
        """
        towards = self.towards
        seen = np.flatnonzero(np.abs(towards) > 1e-9)
        a, b, normal = np.eye(3)[[seen - 2, seen - 1, seen]]
        normal *= np.sign(towards[seen])[:, None]
        corners = np.stack([a + b, b - a, -a - b, a - b], axis=1) + normal[:, None]
        return self.project(corners)[..., :2], _LIGHT[seen] / _LIGHT[seen].max()


def camera(text: str | None, dimension: int, normal: int | None) -> Camera:
    """Return the camera of a name or a direction.

    Parameters
    ----------
    text : str or None
        A face of the domain, ``corner``, or the direction towards the eye, ``X,Y,Z``.
    dimension : int
        Dimensions of the case; other than 3 it is viewed from z-max.
    normal : int or None
        The axis across a slice, the default viewing direction.

    Raises
    ------
    UsageError
        If it is none of these.
    """
    if text is not None and dimension < 3:
        raise UsageError(f"--camera is for three dimensions; this case has {dimension}")
    if text is None and dimension == 3:
        text = "corner" if normal is None else ("x-max", "y-min", "z-max")[normal]
    text = text or "z-max"
    try:
        towards = _EYES[text] if text in _EYES else np.array([float(x) for x in text.split(",")])
    except ValueError:
        what = "direction X,Y,Z" if "," in text else "camera"
        raise UsageError(f"--camera: {unknown(what, text, _EYES, 'there are X,Y,Z and')}") from None
    if towards.shape != (3,) or not np.isfinite(towards).all() or not towards.any():
        raise UsageError(f"--camera {text}: a direction is three numbers, X,Y,Z, not all zero")
    towards = towards / np.linalg.norm(towards)
    right = np.array([-towards[1], towards[0], 0.0])
    if np.linalg.norm(right) < 1e-9:
        right = np.array([np.sign(towards[2]), 0.0, 0.0])
    right /= np.linalg.norm(right)
    return Camera(right, np.cross(towards, right))


def upright(text: str | None) -> Camera:
    """Return the camera of a name or a direction for bodies of revolution: y is upwards.

    Directions are as in 3D with z upwards: x, -z and y here are its x, y and z.

    Raises
    ------
    UsageError
        As `camera`.
    """
    found = camera(text, 3, None)
    right, up = ([side[0], side[2], -side[1]] for side in (found.right, found.up))
    return Camera(np.array(right), np.array(up))


def name_axes(
    axis: Axes, snapshot: PlotFrame, camera: Camera, columns: int, *, lowest: bool
) -> None:
    """Name the axes at the left and below; `lowest`: no picture is below this one."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    if not camera.along_axes:
        axis.set(xticks=[], yticks=[])  # without axes there would be no space for the title
        axis.spines[:].set_visible(False)
        return
    panel = axis.get_subplotspec()
    first = panel is not None and panel.is_first_col()
    sides = (("x", axis.xaxis, camera.right), ("y", axis.yaxis, camera.up))
    for side, ticks, direction in sides:
        name, reversed_ = camera.axis(direction)
        ticks.set_major_locator(MaxNLocator(3 if side == "x" and columns > 2 else 5))
        if reversed_:
            ticks.set_major_formatter(FuncFormatter(lambda value, _: f"{-value + 0.0:g}"))
        if lowest if side == "x" else first:
            axis.set(**{f"{side}label": snapshot.shown.label(name, "length")})
    axis.xaxis.set_tick_params(labelbottom=lowest)


def compass(axis: Axes, camera: Camera) -> None:
    """Draw the directions of the axes of space into the lower left corner."""
    options: dict[str, Any] = {
        "xycoords": "axes fraction",
        "textcoords": "offset points",
        "fontsize": 8,
        "annotation_clip": False,
    }
    centred: dict[str, Any] = {"ha": "center", "va": "center"}
    arrow = {"arrowstyle": "<|-,head_width=0.15,head_length=0.3", "color": "#444444", "lw": 0.9}
    for name, right, up in zip(AXES, camera.right, camera.up, strict=True):
        x, y = _ARROW * right, _ARROW * up
        if np.hypot(x, y) > 0.1 * _ARROW:
            axis.annotate("", (0.0, 0.0), xytext=(x, y), arrowprops=arrow, **options)
            axis.annotate(name, (0.0, 0.0), xytext=(1.3 * x, 1.3 * y), **centred, **options)
