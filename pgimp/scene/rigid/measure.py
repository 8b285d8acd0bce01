"""Measures of rigid bodies at the start: distances, thickness and inertia."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.case.checks.periodic import periodic_axes
from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry.distancefield import MARGIN, DistanceField, distance_field, extent, thickness
from pgimp.kernels.data.frame import Frame
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.rigid import Free, Motion, RigidBody
from pgimp.scene.rigid.bulk import Bulk, bulk, everywhere
from pgimp.schema.tables import VectorFunction

#: Instants at which a body that does not turn is placed, to find the part that enters the domain.
_INSTANTS = 2000

#: Least density of a free body, over the material's around it; the greatest is the inverse.
LIGHTEST = 1e-10

#: Most points of a lattice: about 1 GB.
_MOST_POINTS = 30_000_000

#: Points, and their number over that in the domain, up to which bodies in the initial configuration
#: find a rigid body known beyond the domain as well: 10 MB.
_POINTS_BEYOND, _TIMES_BEYOND = 250_000, 1.5

_Ends = tuple[NDArray[np.float64], NDArray[np.float64]]


class Measured(NamedTuple):
    """Measures of a body from its region."""

    field: DistanceField
    thick: float  #: Its thickness.
    inertia: Bulk | None  #: Inertia of a free body.
    ends: NDArray[np.float64]  #: (2, D) float64: Least and greatest coordinates of the whole body.


def require_densities(case: Case) -> None:
    """Refuse free bodies whose mass is out of the range for solving six equations.

    Raises
    ------
    CaseError
        With the first of them.
    """
    used = (case.materials[body.material] for body in case.bodies.values())
    densities = [material.typical("density") for material in used]
    low, high = LIGHTEST * min(densities), max(densities) / LIGHTEST
    for name, entry in case.rigid_bodies.items():
        if entry.free and not low <= entry.free.density <= high:
            raise CaseError(
                f"bodies.{name}.rigid.density: {entry.free.density:.3g}, and bodies of a "
                f"material have {min(densities):.3g} to {max(densities):.3g}; with less than "
                f"{LIGHTEST:g} of the least, or more than that part says of the greatest, "
                "rounding decides how it moves"
            )


def measure(case: Case, frame: Frame, name: str, entry: RigidBody) -> Measured:
    """Measure a rigid body.

    Raises
    ------
    CaseError
        If the body is too thin for the cells, or too large.
    """
    D = len(frame.cell)
    try:
        field = _distances(case, frame, entry)
        inertia = None
        if entry.free:
            part = _symmetric_part(case, entry.free)
            inertia = bulk(entry.region, entry.free.density, part, case.axisymmetric)
        ends = np.array(entry.region.bounds(), float)
        return Measured(field, thickness(entry.region, D), inertia, ends)
    except CaseError as error:
        raise CaseError(f"bodies.{name}.region: {error}") from None


def is_symmetry(face: str, condition: Boundary, free: Free, D: int) -> bool:
    """Whether a face is a plane of symmetry also for a free rigid body, which may lie across it."""
    return isinstance(condition, Slip) and free.mirrored("xyz".index(face[0]), D)


def _symmetric_part(case: Case, free: Free) -> NDArray[np.float64]:
    """Box of a body's symmetric part, (2, D): the other half lies beyond its sides."""
    D = len(case.grid.cell)
    ends = everywhere(D)
    if case.axisymmetric:
        ends[0, 0] = 0.0
    for face, condition in case.boundaries.items():
        if is_symmetry(face, condition, free, D):
            d, upper = "xyz".index(face[0]), face.endswith("max")
            ends[int(upper), d] = (case.grid.origin, case.grid.corner)[upper][d]
    return ends


def lattice_points(case: Case, frame: Frame, entry: RigidBody) -> float:
    """Number of points at which the distance from a body is stored."""
    return _points(entry, frame.cell, _within(case, frame, entry))


def _points(entry: RigidBody, cell: tuple[float, ...], within: _Ends | None) -> float:
    return float(np.prod(extent(entry.region, cell, within)[2].astype(float)))


def _distances(case: Case, frame: Frame, entry: RigidBody) -> DistanceField:
    cell, within = frame.cell, _within(case, frame, entry)
    thick = thickness(entry.region, len(cell))
    if thick < (1.0 - 1e-3) * min(cell):
        raise CaseError(
            f"is {thick:.2g} thick at most, and cells are {min(cell):.6g} wide: what meets it "
            "would meet both of its sides at once; make it thicker, on a side that meets "
            "nothing, or the cells smaller"
        )
    points = _points(entry, cell, within)
    if points > _MOST_POINTS:
        raise CaseError(
            f"is too large for these cells: it would take {points:.3g} distances half a cell "
            f"apart, where {_MOST_POINTS:.3g} are possible; leave out what meets nothing"
        )
    return distance_field(entry.region, cell, within)


def _within(case: Case, frame: Frame, entry: RigidBody) -> _Ends | None:
    """Ends of the part of a body that is known, in its initial position; None for all of it.

    It is the part that enters the domain. Bodies in the initial configuration may leave that: then
    it is all of the body, or as much around the domain as takes little memory.
    """
    entering = _entering(case, frame, entry)
    if entering is None or all(
        body.formulation != "total-lagrangian" for body in case.bodies.values()
    ):
        return entering
    most = max(_POINTS_BEYOND, _TIMES_BEYOND * _points(entry, frame.cell, entering))
    if _points(entry, frame.cell, None) <= most:
        return None
    low, high = entering
    wide, steps = np.array(frame.cell), 0
    while _points(entry, frame.cell, (low - wide, high + wide)) <= most:
        wide, steps = 2.0 * wide, steps + 1
    return (low - 0.5 * wide, high + 0.5 * wide) if steps else entering


def _entering(case: Case, frame: Frame, entry: RigidBody) -> _Ends | None:
    """Ends of the part of a body that enters the domain, in its initial position."""
    motion = entry.rigid
    if not isinstance(motion, Motion) or motion.rotation is not None:
        return None
    D, end, velocity = len(frame.cell), case.time.end, motion.velocity
    times = np.linspace(0.0, end, _INSTANTS if motion.moves else 1)
    if isinstance(velocity, VectorFunction):
        rows = np.array([time for time, _ in velocity.rows])
        times = np.concatenate([times, rows[(rows > 0.0) & (rows < end)]])
    paths = np.array([motion.displacement(float(t))[:D] for t in times])
    slack = (MARGIN + 1.0) * np.array(frame.cell)
    low = np.array(case.grid.origin, float) - paths.max(axis=0) - slack
    high = np.array(case.grid.corner, float) - paths.min(axis=0) + slack
    for axis in periodic_axes(case.boundaries):  # there its images enter, too
        low[axis], high[axis] = -np.inf, np.inf
    return low, high
