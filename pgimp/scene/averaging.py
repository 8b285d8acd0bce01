"""Part of the consistent mass in the averaged mass of a scene's bodies."""

from __future__ import annotations

import numpy as np

from pgimp.physics.shapes.averaging import averaged_part
from pgimp.scene.scene import Scene
from pgimp.scene.wave_speeds import rest_rate

#: Where kernels are only compiled there are no rates.
TINY = 1e-300


def averaged_parts(scene: Scene) -> np.ndarray:
    """Return the part by body, (bodies,); 0 for bodies with lumped mass.

    It depends on the Courant number of the steps at rest, and so is constant.
    """
    case, method = scene.case, scene.case.method
    rates = np.array([rest_rate(scene, body) for body in range(len(scene.body_names))])
    most = float(rates.max(initial=0.0))
    step = case.time.step if case.courant is None else case.courant / max(most, TINY)
    parts = [averaged_part(method.name, method.particles_per_cell, step * rate) for rate in rates]
    return np.where(scene.settings.averaged, parts, 0.0)
