"""Limit of the first step: waves, or the motion of a body; for messages."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pgimp.geometry.regions import Points
from pgimp.scene.bodies.populate import velocities
from pgimp.scene.wave_speeds import rest_rate

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene

#: Least part of a rate for its cause: velocities in files are not included.
_MIN_SHARE = 0.1


class Limit(NamedTuple):
    """Cells crossed in a unit of time: the cause's key in the case, and words."""

    rate: float
    key: str
    what: str


def limiting(scene: Scene, rate: float) -> Limit:
    """Return the cause that crosses most cells in a unit of time at the start.

    Parameters
    ----------
    rate : float
        Largest (c_p + |v_p|)/L at the start, 1/time.
    """
    found = [*_of_bodies(scene), *_of_rigid(scene)]
    most = max(found, key=lambda limit: limit.rate)
    return most if most.rate > _MIN_SHARE * rate else Limit(rate, "bodies", "the fastest particle")


def _of_bodies(scene: Scene) -> list[Limit]:
    """Waves in each body, and its motion."""
    found, inverse = [], max(scene.domain.frame.inverse)
    for number, (name, body) in enumerate(scene.case.bodies.items()):
        waves = rest_rate(scene, number)
        found.append(Limit(waves, f"materials.{body.material}", f"a wave in '{name}'"))
        if not isinstance(body.region, Points) and not scene.settings.lagrangian[number]:
            corners = np.array(list(product(*zip(*body.region.bounds(), strict=True))), float)
            with np.errstate(over="ignore"):
                v = velocities(scene, number, corners)
                speed = float(np.sqrt(np.square(v).sum(axis=1)).max())
            found.append(Limit(speed * inverse, f"bodies.{name}.velocity", f"'{name}'"))
    return found


def _of_rigid(scene: Scene) -> list[Limit]:
    """The greatest motion of each rigid body, of free ones the initial motion."""
    rigid_bodies = scene.interaction.rigid_bodies
    if not rigid_bodies:
        return []
    inverse = max(scene.domain.frame.inverse)
    speeds = {
        rigid_bodies.names[number]: speed * inverse
        for number, speed in rigid_bodies.speeds().items()
    }
    names = (rigid_bodies.names[number] for number in rigid_bodies.free)
    free = dict(zip(names, rigid_bodies.rates(rigid_bodies.first), strict=True))
    return [
        Limit(
            rate,
            f"bodies.{name}.{'velocity' if name in free else 'rigid'}",
            f"the rigid body '{name}'",
        )
        for name, rate in {**speeds, **free}.items()
    ]
