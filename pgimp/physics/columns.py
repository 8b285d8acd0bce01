"""Vertex quantities and probe columns: name, meaning, function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pgimp.physics.fields import FIELDS, Array, pressure_of, von_mises_of


class Vertex(NamedTuple):
    """A quantity of the grid's vertices."""

    values: Callable[[Any], Array]
    """Takes the sums at n vertices, attributes of these names; returns (n,) or (n, 3)."""
    components: str
    """Names of the components in order; empty for a scalar."""
    meaning: str
    """Meaning, with the unit in square brackets where there is one."""


def _velocity(sums: Any) -> Array:
    """Return the velocity; zero for a vertex without mass."""
    return sums.momentum / np.where(sums.mass > 0.0, sums.mass, 1.0)[:, None]


GRID: dict[str, Vertex] = {
    "mass": Vertex(lambda sums: sums.mass, "", "mass, the sum of w m over the particles [mass]"),
    "momentum": Vertex(lambda sums: sums.momentum, "x y z",
        "momentum, the sum of w m v [mass length/time]"),
    "velocity": Vertex(_velocity, "x y z", "momentum over mass [length/time]"),
    "force": Vertex(lambda sums: sums.force, "x y z",
        "force by which the momentum will grow: of stresses, tractions, body forces and gravity, "
        "before faces and constraints act; at rest minus their reaction [force]"),
    "contact": Vertex(lambda sums: sums.contact, "x y z",
        "force of contact on the bodies that come first in `bodies` by those that come after them, "
        "on the material where the other one is rigid: what the next step gives, if it is as long "
        "as the last [force]"),
}  # fmt: skip
"""What ``output.grid`` may name, at the vertices."""

SURFACE: dict[str, str] = {
    "contact-pressure": "force along the normals of contact on the surface, over its area, mean "
    "since the frame before; negative where it adheres [stress]",
    "traction": "force of contact on the surface, over its area, mean since the frame before "
    "[stress]",
    "gap": "distance to the other body, negative where they overlap; nan where none is near, and "
    "in the first frame [length]",
    "slip": "way that other bodies slid along it while they pressed, since the start [length]",
    "wear-work": "heat of friction there since the start, over the area [stress length]",
}
"""What ``output.surface`` may name, at the facets of surfaces."""

#: Fields of the particle that a material point follows, after time and step and before states.
FOLLOWED = tuple(
    "position displacement velocity stress strain pressure von-mises volume density".split()
)


def patterns(name: str, components: int) -> str:
    """Column names of a quantity: AXIS stands for x, y, z and COMPONENT for xx to xz."""
    return f"{name}-{'AXIS' if components == 3 else 'COMPONENT'}" if components else name


#: First columns of all probes.
WHEN = {"time": "simulated time [time]", "step": "steps done"}

POINT: dict[str, str] = WHEN | {
    patterns(name, FIELDS[name].columns): FIELDS[name].meaning for name in FOLLOWED
}
"""Columns of a material point's file, in their order."""


class Around(NamedTuple):
    """Sums over the particles around a position: volume w V over a cell's volume, and more."""

    fraction: float
    volume: float
    mass: float
    momentum: Array
    """(D,), the sum of w m v."""
    stress: Array
    """(3, 4 or 6), the sum of w V times the Cauchy stress."""

    @property
    def mean(self) -> Array:
        """Mean stress of the particles, (1, 3 to 6)."""
        return self.stress[None] / self.volume


class Mean(NamedTuple):
    """A quantity at a fixed position: function, which returns one number a column; meaning."""

    values: Callable[[Around], Any]
    meaning: str


PLACE: dict[str, Mean] = {
    "volume-fraction": Mean(
        lambda sums: sums.fraction, "sum of w V over the particles, over the volume of a cell [1]"
    ),
    "density": Mean(
        lambda sums: sums.mass / sums.volume, "sum of w m over sum of w V [mass/length^dimensions]"
    ),
    "velocity-AXIS": Mean(
        lambda sums: sums.momentum / sums.mass, "sum of w m v over sum of w m [length/time]"
    ),
    "stress-COMPONENT": Mean(
        lambda sums: sums.mean[0], "sum of w V times the Cauchy stress, over sum of w V [stress]"
    ),
    "pressure": Mean(lambda sums: pressure_of(sums.mean)[0], "of this stress [stress]"),
    "von-mises": Mean(lambda sums: von_mises_of(sums.mean)[0], "of this stress [stress]"),
}
"""Columns of a place's file after time and step, in their order."""
