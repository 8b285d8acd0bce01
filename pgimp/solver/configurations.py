"""Groups of a rank's particles by configuration: kernels take each group with its own setting.

Most scenes have one. In cases with both configurations the bodies in the initial one are a separate
group, with velocity fields of their own on shared vertices.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pgimp.decomposition.population import Population
from pgimp.kernels.data.arguments import Field, Forcing, KernelScene, Order
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.order.split import split_order
from pgimp.kernels.sums.sums import fastest_rate
from pgimp.scene.scene import Scene


class ConfigurationGroup(NamedTuple):
    """Particles of one setting.

    Attributes
    ----------
    setting : KernelScene
        The scene for kernels.
    order : Order
        The particles; all groups have the same layers.
    rank_in_order : (n,) int32 or None
        Their offsets in the order of all particles; None if they are all.
    lagrangian : bool
        Whether they are in the initial configuration, beside others.
    """

    setting: KernelScene
    order: Order
    rank_in_order: np.ndarray | None = None
    lagrangian: bool = False

    def bounded(self, scene: Scene, field: Field) -> Field:
        """The field with bounds on the coordinates of these particles."""
        bounds = scene.domain.bounds if self.lagrangian else None
        return field if bounds is None else field._replace(bounds=bounds)

    def loaded(self, loads: Loads) -> Loads:
        """The loads on these particles."""
        if not self.lagrangian:
            return loads
        mean = () if isinstance(loads.mean, tuple) else 1.0
        return loads._replace(mean=(), mean_lagrangian=mean, affine=(), relaxation=())

    def forced(self, forcing: Forcing) -> Forcing:
        """The forcing of these particles."""
        if not self.lagrangian:
            return forcing
        return forcing._replace(loads=self.loaded(forcing.loads), keepers=())


def groups_by_configuration(scene: Scene, population: Population) -> tuple[ConfigurationGroup, ...]:
    """Return the groups of a rank's particles, one or two; valid until their order changes."""
    order = population.ordered
    if not scene.settings.mixed:
        return (ConfigurationGroup(scene.setting, order),)
    rank_in_order = np.empty((2, len(order.rows)), np.int32)
    ends = np.empty((2, len(order.start)), np.int64)
    split_order(scene.settings.lagrangian, population.particles.body, *order, rank_in_order, ends)
    found = [rank_in_order[i, : ends[i, -1]] for i in range(2)]
    orders = [Order(order.rows[found[i]], ends[i]) for i in range(2)]
    return (
        ConfigurationGroup(scene.setting, orders[0], found[0]),
        ConfigurationGroup(scene.setting_lagrangian, orders[1], found[1], True),
    )


def fastest(
    scene: Scene, particles: Particles, rows: np.ndarray, controlled: bool | float
) -> float:
    """`fastest_rate` of the particles in `rows`, in any configuration."""
    return max(
        fastest_rate(setting, particles, those, controlled)
        for setting, those in _by_setting(scene, particles, rows)
    )


def _by_setting(
    scene: Scene, particles: Particles, rows: np.ndarray
) -> Iterator[tuple[KernelScene, np.ndarray]]:
    if not scene.settings.mixed:
        yield scene.setting.without_shape(), rows
        return
    lagrangian = scene.settings.lagrangian[particles.body[rows]]
    yield scene.setting.without_shape(), rows[~lagrangian]
    yield scene.setting_lagrangian.without_shape(), rows[lagrangian]
