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
    """A path of deformation.

    Attributes
    ----------
    meaning : str
        Meaning of the value of ``--to``.
    stretch : callable
        Takes the value; returns the logarithmic strains along x, y, z and the shear.
    free : tuple of int
        Directions whose stress is prescribed: minus the confining pressure.
    component : str
        Stress component in the plot.
    """

    meaning: str
    stretch: Callable[[float], tuple[float, float, float, float]]
    free: tuple[int, ...]
    component: str


PATHS = {
    "uniaxial-strain": Path(
        "logarithmic strain along x; none across", lambda e: (e, 0.0, 0.0, 0.0), (), "stress-xx"
    ),
    "uniaxial-stress": Path(
        "logarithmic strain along x; no stress across", lambda e: (e, 0.0, 0.0, 0.0), (1, 2),
        "stress-xx",
    ),
    "oedometer": Path(
        "logarithmic strain along x, below 0 in compression; none across",
        lambda e: (e, 0.0, 0.0, 0.0), (), "stress-xx",
    ),
    "triaxial": Path(
        "logarithmic strain along x after the confinement, below 0 in compression; across, the "
        "confining pressure acts", lambda e: (e, 0.0, 0.0, 0.0), (1, 2), "q",
    ),
    "undrained": Path(
        "logarithmic strain along x after the confinement, at constant volume",
        lambda e: (e, -0.5 * e, -0.5 * e, 0.0), (), "q",
    ),
    "simple-shear": Path(
        "shear: displacement along x over the distance along y", lambda g: (0.0, 0.0, 0.0, g), (),
        "stress-xy",
    ),
    "isotropic": Path(
        "logarithm of the volume ratio, below 0 in compression",
        lambda e: (e / 3.0, e / 3.0, e / 3.0, 0.0), (), "pressure",
    ),
}  # fmt: skip


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
