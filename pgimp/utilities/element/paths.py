"""Paths of deformation: directions with prescribed strain, and with prescribed stress."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pgimp.errors import UsageError
from pgimp.schema.messages import unknown

Array = np.ndarray


class Path(NamedTuple):
    """A path of deformation."""

    meaning: str  #: Meaning of the value of ``--to``.
    #: Takes the value; returns the logarithmic strains along x, y, z and the shear.
    stretch: Callable[[float], tuple[float, float, float, float]]
    free: tuple[int, ...]  #: Directions whose stress is prescribed: minus the confining pressure.
    component: str  #: Stress component in the plot.


def _along(e: float) -> tuple[float, float, float, float]:
    return e, 0.0, 0.0, 0.0


_COMPRESSION = "logarithmic strain along x, below 0 in compression"
_CONFINED = "logarithmic strain along x after the confinement"
_ACROSS = ", below 0 in compression; across, the confining pressure acts"
_FREE = "logarithmic strain along x; no stress across"
_SHEAR = "shear: displacement along x over the distance along y"
_VOLUME = "logarithm of the volume ratio, below 0 in compression"
PATHS = {
    "uniaxial-strain": Path("logarithmic strain along x; none across", _along, (), "stress-xx"),
    "uniaxial-stress": Path(_FREE, _along, (1, 2), "stress-xx"),
    "oedometer": Path(f"{_COMPRESSION}; none across", _along, (), "stress-xx"),
    "triaxial": Path(f"{_CONFINED}{_ACROSS}", _along, (1, 2), "q"),
    "undrained": Path(
        f"{_CONFINED}, at constant volume", lambda e: (e, -0.5 * e, -0.5 * e, 0.0), (), "q"
    ),
    "simple-shear": Path(_SHEAR, lambda g: (0.0, 0.0, 0.0, g), (), "stress-xy"),
    "isotropic": Path(_VOLUME, lambda e: (e / 3.0, e / 3.0, e / 3.0, 0.0), (), "pressure"),
}


def gradient(strains: Array, shear: float, dimensions: int) -> Array:
    """Return the deformation gradient of logarithmic strains followed by a shear, (D, D)."""
    F = np.diag(np.exp(strains))
    F = F @ np.eye(3)
    F[0, 1] += shear * F[1, 1]
    return F[:dimensions, :dimensions]


def legs(values: Sequence[float], steps: int) -> Array:
    """Return the values at the end of each step, with `steps` steps to each value in turn."""
    ends = pairwise([0.0, *values])
    return np.concatenate([a + (b - a) * np.arange(1, steps + 1) / steps for a, b in ends])


def path_of(name: str) -> Path:
    """Return a path by its name.

    Raises
    ------
    UsageError
        If there is no path of that name.
    """
    if name not in PATHS:
        raise UsageError(f"--path: {unknown('path', name, PATHS)}")
    return PATHS[name]
