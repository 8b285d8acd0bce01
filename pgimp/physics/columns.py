"""Quantities of vertices, and columns of probes: names and meaning."""

from __future__ import annotations

from typing import NamedTuple

from pgimp.physics.fields import FIELDS


class Vertex(NamedTuple):
    """A quantity of the grid's vertices."""

    components: str
    """Names of the components in order; empty for a scalar."""
    meaning: str
    """Meaning, with the unit in square brackets where there is one."""


GRID: dict[str, Vertex] = {
    "mass": Vertex("", "mass, the sum of w m over the particles [mass]"),
    "momentum": Vertex("x y z", "momentum, the sum of w m v [mass length/time]"),
    "velocity": Vertex("x y z", "momentum over mass [length/time]"),
    "force": Vertex(
        "x y z",
        "force by which the momentum will grow: of stresses, tractions, body forces and gravity, "
        "before faces and constraints act; at rest minus their reaction [force]",
    ),
    "contact": Vertex(
        "x y z",
        "force of contact on the bodies that come first in `bodies` by those that come after them, "
        "on the material where the other one is rigid: what the next step gives, if it is as long "
        "as the last [force]",
    ),
}
"""What ``output.grid`` may name, at the vertices."""

#: Fields of the particle that a material point follows, after time and step; states come to them.
FOLLOWED = (
    "position", "displacement", "velocity", "stress", "strain", "pressure", "von-mises", "volume",
    "density",
)  # fmt: skip


def patterns(name: str, components: int) -> str:
    """How a quantity's columns are named: AXIS stands for x, y, z and COMPONENT for xx to xz."""
    return f"{name}-{'AXIS' if components == 3 else 'COMPONENT'}" if components else name


POINT: dict[str, str] = {
    "time": "simulated time [time]",
    "step": "steps done",
} | {patterns(name, FIELDS[name].columns): FIELDS[name].meaning for name in FOLLOWED}
"""Columns of a material point's file, in their order."""

PLACE: dict[str, str] = {
    "time": "simulated time [time]",
    "step": "steps done",
    "volume-fraction": "sum of w V over the particles, over the volume of a cell [1]",
    "density": "sum of w m over sum of w V [mass/length^dimensions]",
    "velocity-AXIS": "sum of w m v over sum of w m [length/time]",
    "stress-COMPONENT": "sum of w V times the Cauchy stress, over sum of w V [stress]",
    "pressure": "of this stress [stress]",
    "von-mises": "of this stress [stress]",
}
"""Columns of a place's file, in their order."""
