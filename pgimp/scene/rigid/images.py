"""Images of rigid bodies in periodic domains: of each a point meets the nearest one."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.distancefield import MARGIN, DistanceField
from pgimp.kernels.contact.fill import CERTAINLY
from pgimp.kernels.data.frame import Frame
from pgimp.physics.rigid import Motion, Pose, RigidBody
from pgimp.schema.sizes import AXES


class Ring(NamedTuple):
    """A direction in which the domain may be periodic: its low end, and its period or 0."""

    low: float
    period: float

    def inside(self, x: float, way: float = 0.0) -> float:
        """Return ``x + way``, less whole periods so that it is within the domain.

        The way is added last: so the sum is rounded as within the domain.
        """
        if self.period == 0.0:
            return x + way
        return (x - floor((x + way - self.low) / self.period) * self.period) + way


def rings(frame: Frame, periods: NDArray[np.float64]) -> tuple[Ring, ...]:
    """Return the directions of a periodic domain, three; () for others."""
    if not periods.any():
        return ()
    found = [Ring(*each) for each in zip(frame.origin, periods.tolist(), strict=True)]
    return (*found, Ring(0.0, 0.0), Ring(0.0, 0.0))[:3]


class Middle(NamedTuple):
    """How the middle of a body's lattice is found from a pose, in a periodic domain."""

    rings: tuple[Ring, ...]  #: The directions.
    #: start, own: (3,) float64: The middle at the start, and from the reference point then.
    start: NDArray[np.float64]
    own: NDArray[np.float64]


def place(
    row: NDArray, pose: Pose, middle: Middle | None, motion: Motion | Sequence[float], time: float
) -> None:
    """Set the pose of a rigid body, see `MOTION`.

    Parameters
    ----------
    row : MOTION
        Of the body.
    pose : Pose
        Its pose.
    middle : Middle or None
        None in domains that are not periodic.
    motion : Motion or sequence of float
        How it moves; of a free body the image of its centre that is within the domain.
    """
    row["centre"], row["rotation"].flat[:] = pose
    if middle is None:
        return
    # No matrix product: machines may round it differently.
    own, turn = middle.own, row["rotation"]
    lever = [turn[d, 0] * own[0] + turn[d, 1] * own[1] + turn[d, 2] * own[2] for d in range(3)]
    row["lever"] = lever
    if not isinstance(motion, Motion):
        row["middle"] = [x + a for x, a in zip(motion, lever, strict=True)]
        return
    turns = motion.rotation is not None
    first = motion.reference if turns else middle.start
    for d, (ring, way) in enumerate(zip(middle.rings, motion.displacement(time), strict=True)):
        row["middle"][d] = ring.inside(float(first[d]), way) + (lever[d] if turns else 0.0)


def own_ends(field: DistanceField, reference: Sequence[float]) -> list[list[float]]:
    """First and last point of a body's lattice from its reference point, as it is at the start."""
    far = field.low + field.spacing * (field.shape - 1)
    return [(end - np.array(reference)).tolist() for end in (field.low, far)]


def bound(
    row: NDArray, lattice: NDArray, ends: list[list[float]], frame: Frame, periods: NDArray
) -> None:
    """Set the first and the last vertex near a body; `ends` are its lattice's, see `own_ends`."""
    turn, centre = row["rotation"].tolist(), row["centre"].tolist()
    for d, (origin, inverse) in enumerate(zip(frame.origin, frame.inverse, strict=True)):
        # No matrix product: machines may round it differently.
        each = [(r * a, r * b) for r, a, b in zip(turn[d], *ends, strict=True)]
        a, b, c = map(min, each)
        low = a + b + c + centre[d]
        a, b, c = map(max, each)
        high = a + b + c + centre[d]
        if periods[d] > 0.0:
            turns = np.floor((0.5 * (low + high) - origin) * inverse / frame.cells[d])
            low, high = low - turns * periods[d], high - turns * periods[d]
            slack, end = (frame.ghost + 2) / inverse, origin + periods[d]
            if low < origin + slack or high > end - slack:  # it may be on both sides
                lattice["least"][d], lattice["most"][d] = 0, frame.vertices[d] - 1
                continue
        # Also beyond the domain, where bodies in the initial configuration may go.
        lattice["least"][d] = floor((low - origin) * inverse) + frame.ghost - 1
        lattice["most"][d] = ceil((high - origin) * inverse) + frame.ghost + 1


def nearest_image(
    x: NDArray[np.float64], middle: NDArray[np.float64], periods: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the points x, (n, D), less the whole periods that they are away from `middle`."""
    length = np.where(periods > 0.0, periods, np.inf)
    turns = np.floor((x - middle) / length + 0.5)
    return np.asarray(x - turns * periods)


def turning(entry: RigidBody, D: int) -> bool:
    """Whether a rigid body may turn, in D dimensions."""
    if isinstance(entry.rigid, Motion):
        return entry.rigid.rotation is not None
    return any(entry.rigid.may(D)[3:])


def spans(entry: RigidBody, periods: NDArray[np.float64]) -> NDArray[np.float64]:
    """Periods of the directions along which a body that does not turn spans them, else 0, (D,).

    One that moves freely, with all of its mass, is no longer than that.
    """
    low, high = (np.array(end, float) for end in entry.region.bounds())
    whole = (periods > 0.0) & (high - low > (1.0 - 1e-9) * periods)
    if not isinstance(entry.rigid, Motion):
        whole &= high - low < (1.0 + 1e-9) * periods
    return np.where(whole & (not turning(entry, len(periods))), periods, 0.0)


def require_short(
    entry: RigidBody,
    field: DistanceField,
    frame: Frame,
    periods: NDArray[np.float64],
    name: str,
    by_surfaces: bool,
) -> None:
    """Refuse a body so long that a vertex may be near two of its images.

    `by_surfaces` is whether bodies meet at their surfaces: then it may also span the domain.

    Raises
    ------
    CaseError
        Always with the greatest length.
    """
    D = len(frame.cell)
    sides = field.spacing * (field.shape[:D] - 1) - 2.0 * MARGIN * np.array(frame.cell)
    turns = turning(entry, D)
    if turns and D > 1:
        sides = np.full(D, float(np.sqrt(np.square(sides).sum())))
    spanned = spans(entry, periods) if by_surfaces else np.zeros(D)
    for d in np.flatnonzero(periods):
        most = float(periods[d]) - 2.0 * CERTAINLY * sum(frame.cell)
        if sides[d] > most and not spanned[d]:
            turned = " as it turns" if turns and D > 1 else ""
            raise CaseError(
                f"bodies.{name}.region: is up to {sides[d]:.4g} long along {AXES[d]}{turned}, and "
                f"the domain repeats every {periods[d]:.4g}: with these cells its images come too "
                f"near each other from {max(most, 0.0):.4g} on; take a shorter body, smaller cells "
                "or a longer domain, or a wall (boundaries) in place of a plate"
            )
