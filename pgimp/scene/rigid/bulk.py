"""Mass, centre and inertia of free rigid bodies, from volume fractions of boxes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError
from pgimp.geometry.regions.base import Region
from pgimp.scene.bodies.lattice_body import LatticeBody

#: Boxes along the longest side of a body, by the number of directions; fewest along the shortest
#: side, within `_MOST` in total. Volume and centre are exact for boxes and of fourth order for
#: round bodies; the inertia is of third order or better.
_BOXES, _ACROSS, _MOST = (1000, 256, 64), 48, 1_000_000


class Bulk(NamedTuple):
    """Inertia of a body."""

    mass: float
    centre: tuple[float, float, float]  #: Centre of mass at the start.
    #: tuple of 9 float: The matrix of moments of inertia about it, in the directions of the start.
    inertia: tuple[float, ...]


def everywhere(D: int) -> NDArray[np.float64]:
    """Corners of an infinite box, (2, D)."""
    return np.repeat([[-np.inf], [np.inf]], D, axis=1)


def bulk(region: Region, density: float, within: NDArray[np.float64], axial: bool = False) -> Bulk:
    """Inertia of a homogeneous body: the part of a finite region within a box.

    Parameters
    ----------
    within : (2, D) float64
        Corners of the box, possibly infinite.
    axial : bool
        Whether the region is the section of a body of revolution, which only moves along its axis.

    Raises
    ------
    CaseError
        If that part is empty.
    """
    D = within.shape[1]
    low, high = np.clip(np.array(region.bounds(), float), *within)
    if not (high - low).min() > 0.0:
        where = "the axis" if axial else "a plane of symmetry"
        raise CaseError(f"lies wholly beyond {where}")
    # Half a body gets half the boxes of the whole, so it has half its mass to rounding.
    halves = 1 + ((low == within[0]) != (high == within[1]))
    extent = (high - low) * halves
    side = min(float(extent.max()) / _BOXES[D - 1], float(extent.min()) / _ACROSS)
    side = max(side, (float(extent.prod()) / _MOST) ** (1.0 / D))
    counts = 2 * np.maximum(np.ceil(0.5 * extent / side - 1e-9).astype(int), 1) // halves
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, counts, strict=True)]
    centres = [0.5 * (e[1:] + e[:-1]) for e in edges]
    body = LatticeBody(region, edges, centres, cut=True)
    ranges = [(0, int(n)) for n in counts]
    found = body.volume_fractions(ranges)
    indices = np.union1d(np.flatnonzero(found.whole), found.indices)
    part = found.fraction(indices)
    x = body.points(ranges, indices) + found.moment(indices) / part[:, None]
    if axial:
        rings = 2.0 * np.pi * part * x[:, 0]  # over the area of a box (Pappus)
        mass = density * float(np.prod(body.size)) * float(rings.sum())
        return Bulk(mass, (0.0, float((rings * x[:, 1]).sum() / rings.sum()), 0.0), (0.0,) * 9)
    volume = float(part.sum())
    centre = np.array([(part * x[:, d]).sum() / volume for d in range(D)])
    arm, second = x - centre, np.zeros((3, 3))
    for d in range(D):
        for e in range(D):
            second[d, e] = (part * arm[:, d] * arm[:, e]).sum()
        # A box's own second moment; a cut box counts as a smaller box of the same shape.
        second[d, d] += (part * part ** (2.0 / D)).sum() * body.size[d] ** 2 / 12.0
    unit = density * float(np.prod(body.size))
    inertia = unit * (np.trace(second) * np.identity(3) - second)
    x, y, z = (*centre.tolist(), 0.0, 0.0)[:3]
    return Bulk(unit * volume, (x, y, z), tuple(inertia.ravel().tolist()))
