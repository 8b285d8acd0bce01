"""Edges of tools that press into what yields: cells across, and where the edges lie in theirs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pgimp.geometry.regions.box import Box
from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.rigid import Motion
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.supports import AXES
from pgimp.scene.checks.validity.impedance import strength_of
from pgimp.scene.scene import Scene

if TYPE_CHECKING:
    from pgimp.case.schema import Case

#: Cells within the body's own ends at which an edge does not press into it.
_INSIDE = 1.0
#: Width in cells by which contact may miss an edge, and what is pressed with it: covers all that
#: strip footings of 4 to 21 cells on clay and on soil with friction were off by.
_MISSED = 1.5
#: Cells from a line of the grid within which an edge lies on it.
_ON_LINE = 0.05
#: Instants of the run at which the tool's way is looked at.
_INSTANTS = 65


def notes(scene: Scene, bodies: Sequence[BodyFacts], end: float) -> Iterator[str]:
    """Yield a note on each box that is pressed into a body with a strength, narrower than it.

    Parameters
    ----------
    scene : Scene
        Of the first stage.
    bodies : sequence of BodyFacts
        The bodies of the scene.
    end : float
        End of the run, with all its stages.
    """
    case, rigid, pairs = scene.case, scene.interaction.rigid_bodies, scene.interaction.pairs
    for k, (name, entry) in enumerate(zip(rigid.names, rigid.entries, strict=True)):
        motion, region = entry.rigid, entry.region
        if not isinstance(motion, Motion) or motion.rotation or not isinstance(region, Box):
            continue
        ways = np.array([motion.displacement(t) for t in np.linspace(0.0, end, _INSTANTS)])
        along = int(np.abs(ways).max(axis=0).argmax())
        way = ways[int(np.abs(ways[:, along]).argmax()), along]
        for number, body in enumerate(bodies):
            met = pairs is None or pairs.entry[number, len(scene.body_names) + k] != 0
            cell = case.grid.cell[along]
            # Outside of it at first: what is in a hole of its own has no edge on the body.
            gap = body.low[along] - region.max[along]
            if way < 0.0:
                gap = region.min[along] - body.high[along]
            if met and way and gap > -_INSIDE * cell and strength_of(case, body) > 0.0:
                if text := _text(case, region, along, body):
                    yield f"bodies.{name}.region: {text}"
                    break


def _text(case: Case, region: Box, along: int, body: BodyFacts) -> str:
    """Cells across the narrowest side of a tool whose edges lie above a body; empty without."""
    found: list[tuple[float, str]] = []
    for axis in range(case.dimensions):
        cell, origin, corner = (
            end[axis] for end in (case.grid.cell, case.grid.origin, case.grid.corner)
        )
        low, high = region.min[axis], region.max[axis]
        least, most = body.low[axis] + _INSIDE * cell, body.high[axis] - _INSIDE * cell
        edges = [edge for edge in (low, high) if least < edge < most]
        if axis == along or not edges:
            continue
        across, sides = (high - low) / cell, len(edges)
        for side, plane, far in (("min", origin, high), ("max", corner, low)):
            mirror = case.boundaries.get(f"{AXES[axis]}-{side}")
            on_axis = case.axisymmetric and (axis, side) == (0, "min")
            if low <= plane <= high and (on_axis or isinstance(mirror, Slip)):
                across, sides = 2.0 * abs(far - plane) / cell, 2
        parts = [(edge - origin) / cell % 1.0 for edge in edges]
        parts = [min(part, 1.0 - part) for part in parts]
        found.append((across, _words(across, sides, axis, parts)))
    return min(found)[1] if found else ""


def _words(across: float, sides: int, axis: int, parts: list[float]) -> str:
    lie = " and ".join(dict.fromkeys(f"{part:.2g}" for part in parts))
    on_line = (
        "; on a line rounding decides whether the vertex there is pressed: better in the middle of "
        "a cell"
        if min(parts) < _ON_LINE
        else ""
    )
    return (
        f"{across:.3g} cells across along {AXES[axis]}, edges {lie} of a cell from lines of the "
        f"grid{on_line}. Contact knows an edge to about a cell: the force on it may be off by "
        f"{100.0 * min(_MISSED * sides / across, 1.0):.2g} %, and steps as it sinks (measured: "
        "strip footings of 8 to 9.5 cells -14 to 30 %, of 4 to 5.5 cells -50 to 25 %, of 21 cells "
        "-1.4 %): take smaller cells (grid.cell), and compare runs with the edge elsewhere in one"
    )
