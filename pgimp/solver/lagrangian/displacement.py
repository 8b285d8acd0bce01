"""Lattice particles from the vertices' motion, when something asks for them."""

from __future__ import annotations

from operator import is_not

import numpy as np

from pgimp.kernels.data.arguments import Order
from pgimp.kernels.lagrangian.displace import Displaced, displace_particles, place_particles
from pgimp.solver.rank_state import RankState


class Displacement:
    """Updates of a rank's lattice particles, in the initial configuration."""

    def __init__(self, rank: RankState) -> None:
        self._rank = rank
        self._near: tuple[tuple, Order] | None = None

    def update(self, near: np.ndarray | None = None) -> None:
        """Update the particles' columns, all or those `near`, given by offsets in the order.

        Of elastic ones among those `near` only positions and F: all columns stay out of date.
        """
        rank, stored = self._rank, self._rank.population.columns
        order = rank.lattice_cells().inside if near is None else self._near_order(near)
        if near is None or rank.scene.cell_loads:
            self.place(order, Displaced(*(getattr(stored, name) for name in Displaced._fields)))
            return
        frame, field = rank.scene.domain.frame, rank.grid.motion_field
        rank.call(place_particles, rank.scene.setting, frame, field, stored, order)

    def place(self, order: Order, displaced: Displaced, to: np.ndarray | None = None) -> None:
        """Set columns of particles by the vertices' motion, in rows `to` or in their own."""
        rank = self._rank
        setting = rank.scene.setting
        if rank.scene.cell_loads:  # F and stress are those of the step
            setting = setting.without_materials()
        rank.call(
            displace_particles, setting, rank.scene.domain.frame, rank.grid.motion_field,
            rank.population.columns, order, displaced, order.rows if to is None else to,
        )  # fmt: skip

    def _near_order(self, near: np.ndarray) -> Order:
        """Lattice particles among those `near`; kept while these and the lattice do not change."""
        population, lattice = self._rank.population, self._rank.lattice_cells()
        of = near, population.order, lattice
        if self._near is None or any(map(is_not, of, self._near[0])):
            rows = population.order[near]
            inside = lattice.is_inside[rows]
            self._near = of, Order(rows[inside], np.searchsorted(near[inside], population.start))
        return self._near[1]
