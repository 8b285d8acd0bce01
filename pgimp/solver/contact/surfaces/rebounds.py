"""Rebounds of rigid bodies from each other, by their coefficients of restitution."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.impulses.pairs import ContactPairs
from pgimp.kernels.contact.surfaces.rebounds import COLUMNS, find_gains, find_rebounds
from pgimp.scene.scene import Scene
from pgimp.solver.contact.surfaces.groups import Grouped

#: Solutions of a step, at most, as long as impulses give energy; which part of what they exchange
#: is rounding.
TRIES, NOTHING = 8, 1e-6


class Rebounds:
    """Solves for impulses of rigid bodies that hit each other.

    With friction Newton's hypothesis may give more energy than there was: then bodies rebound less.

    Parameters
    ----------
    restitution : (entries,) float64
        Coefficient of restitution of each law.
    free : int
        Number of the rigid bodies that move freely.
    """

    def __init__(self, restitution: np.ndarray, free: int) -> None:
        self.restitution, self.call = restitution, Bound()
        self._velocities = np.empty((free, 6))

    def solve(
        self,
        rigid_bodies: Any,
        pairs: ContactPairs,
        grouped: Grouped,
        states: tuple[np.ndarray, ...],
        sweep: Callable[[], Any],
    ) -> None:
        """Solve for the impulses by `sweep`, which changes `states`; of each group alone."""
        call, first, count = self.call, grouped.first, len(grouped.number)
        order = grouped.order
        gaps, scratch = pairs.states["gap_rate"].copy(), np.empty((len(pairs.ends), COLUMNS))
        own, found = grouped.chosen(pairs), 0
        for a, b in [*pairwise(first.tolist())] or [(0, 0)]:
            some = rigid_bodies, own.chosen(slice(a, b)), self.restitution, self._velocities
            found += call(find_rebounds, *some, scratch[a:b])
        if not needed(found):
            sweep()
            return
        pairs.states["gap_rate"][order] = own.states["gap_rate"]
        speeds, group = pairs.states["gap_rate"].copy(), np.empty(len(pairs.ends), np.int64)
        group[order] = np.repeat(np.arange(count), np.diff(first))
        hit = np.flatnonzero(speeds != gaps)
        states = (*states, pairs.states, rigid_bodies.motion, rigid_bodies.responses)
        before, gains = [each.copy() for each in states], np.empty((2, len(pairs.ends)))
        part, lost = np.ones((2, count))
        for number in range(TRIES):
            sweep()
            call(find_gains, rigid_bodies, pairs, gains)
            whole, most = (np.bincount(group, each, count) for each in gains)
            more = whole > NOTHING * most
            if number != 1 and not needed(more.any()):
                return
            if number == 0:
                given, part[more] = whole, 0.0
            elif number == 1:
                lost, more = np.maximum(-whole, 0.0), part == 0.0
                part[more], whole = 1.0, given
            if number > 0:  # the energy of a rebound is the square of its velocity
                part[more] *= np.sqrt(lost[more] / (lost[more] + whole[more]))
            part[more] *= number + 1 < TRIES
            for each, kept in zip(states, before, strict=True):
                each[...] = kept
            pairs.states["gap_rate"][hit] = speeds[hit] * part[group[hit]]
        sweep()


def rebounds_of(scene: Scene) -> Rebounds | None:
    """Return the rebounds of a scene's rigid bodies; None without any."""
    letting = [face.condition for face in scene.domain.faces if face.condition.approaches]
    given = [*(entry.restitution for entry in scene.case.contact), 0.0]
    restitution = np.array(given + [getattr(wall, "restitution", 0.0) for wall in letting])
    free = len(scene.interaction.rigid_bodies.free)
    return Rebounds(restitution, free) if free and restitution.any() else None
