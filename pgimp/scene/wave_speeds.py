"""Wave speeds of bodies at rest, and the rates by which they limit steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.kernels.data.particles import Particles
from pgimp.kernels.sums.sums import fastest_rate
from pgimp.scene.scene import Scene

_Reals = np.ndarray[Any, np.dtype[np.float64]]


def wave_speed(scene: Scene, body: int, points: tuple[_Reals, _Reals] | None = None) -> float:
    """Wave speed of a body at rest; see `rest_rate`."""
    # Cells are so large here that viscosity is negligible.
    return rest_rate(scene, body, 2.0**-200, points) * 2.0**200


def rest_rate(
    scene: Scene, body: int, inverse: float = 0.0, points: tuple[_Reals, _Reals] | None = None
) -> float:
    """Rate that limits the step of a body at rest, by waves and viscosity, 1/time.

    Parameters
    ----------
    scene, body : Scene, int
        The body's number in a scene.
    inverse : float
        Inverse of the side of a cell; by default the scene's.
    points : ((n, own), (n, k)) float64, optional
        Columns `own` and `state` of particles whose material varies; by default typical ones.
    """
    number = scene.materials.body_material[body]
    if points is None:
        points = (
            scene.materials.variations.typical[number][None],
            scene.materials.states.initial[number][None],
        )
    point = Particles.empty(len(points[0]), scene.carried)
    point.body[:] = body
    point.own[:], point.state[:] = points
    setting, D = scene.setting.without_shape(), scene.dimension
    if inverse:
        setting = setting._replace(frame=setting.frame._replace(inverse=(inverse,) * D))
    return fastest_rate(setting, point, np.arange(len(point.body), dtype=np.int32), True)
