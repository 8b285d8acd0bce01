"""Columns of history.csv of particles that left or came: escaped, removed, added, entered."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from pgimp.kernels.sums.sums import KINETIC, MASS, MOMENTUM, STRAIN
from pgimp.solver.history.totals import Column, Group, Totals

if TYPE_CHECKING:
    from pgimp.scene.scene import Scene


def _passed(
    name: str,
    there: Callable[[Scene], bool],
    sums: Callable[[Totals], np.ndarray],
    mass: str,
    what: str = "were removed",
) -> Group:
    """Columns of removed particles, or of particles that came, in scenes where `there` is true."""
    return Group(lambda scene: [""] if there(scene) else [], (
        Column(f"{name}.mass", "mass", mass, lambda s, _: sums(s)[MASS]),
        Column(f"{name}.momentum-AXIS", "mass length/time", f"their momentum when they {what}",
            lambda s, _: s.along(sums(s), MOMENTUM)),
        Column(f"{name}.angular-momentum-AXIS", "mass length^2/time", "their angular momentum then",
            lambda s, _: s.moment(sums(s))),
        Column(f"{name}.kinetic-energy", "energy", "their kinetic energy then",
            lambda s, _: sums(s)[KINETIC]),
        Column(f"{name}.strain-energy", "energy", "their strain energy then",
            lambda s, _: sums(s)[STRAIN]),
    ))  # fmt: skip


ESCAPED = (
    _passed("outflow", lambda scene: scene.settings.escapes, lambda s: s.escaped,
        "only where `outflow` removes particles, as all columns of this name: mass of those that "
        "were removed since the start, so that with `mass` it is constant"),
)  # fmt: skip
"""Of particles that have left."""

REMOVED_AND_CAME = (
    _passed("removed", lambda scene: bool(scene.case.staged.removed), lambda s: s.removed,
        "mass of the bodies that stages have removed, so that with `mass` it is constant"),
    _passed("added", lambda scene: bool(scene.case.staged.added), lambda s: s.added,
        "mass of the bodies that have come in stages, so that `mass` less it is constant", "came"),
    _passed("inflow", lambda scene: bool(scene.case.inflow), lambda s: s.inflow,
        "only with `inflow`, as all columns of this name: mass of the particles that have entered "
        "since the start, so that `mass` less it is constant",
        "entered"),
)  # fmt: skip
"""Of removed bodies, and of what came in stages or by inflow."""
