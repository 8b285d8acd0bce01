"""Small parts of boxes, merged into the boxes next to them."""

import numpy as np

from pgimp.scene.bodies.volume_fractions import Reals, VolumeFractions

#: Volume fraction below which a cut box merges into a neighbour, if one is fuller.
LEAST_FRACTION = 1e-3


def merge_small(volumes: VolumeFractions, size: Reals) -> VolumeFractions:
    """Merge small cut boxes into the fullest neighbour, among equals the nearest, then first.

    The nearest neighbour is the one with the fewest different coordinates.

    Parameters
    ----------
    volumes : VolumeFractions
        Of a part of the lattice.
    size : (D,) float64
        Sides of a box.
    """
    small = np.flatnonzero(volumes.fractions < LEAST_FRACTION)
    if len(small) == 0:
        return volumes
    origins = volumes.indices[small]
    shape = tuple(end - begin for begin, end in volumes.ranges)
    index = np.unravel_index(origins, shape)
    target = np.full(len(origins), -1)
    fullest = np.full(len(origins), np.nextafter(LEAST_FRACTION, 0.0))
    away = np.zeros((len(origins), len(shape)))
    steps = np.array(list(np.ndindex(*(3,) * len(shape)))) - 1
    for step in steps[np.argsort(np.abs(steps).sum(axis=1), kind="stable")]:
        there = [i + s for i, s in zip(index, step, strict=True)]
        valid = np.ones(len(origins), bool)
        for i, n in zip(there, shape, strict=True):
            valid &= (0 <= i) & (i < n)
        rows = np.flatnonzero(valid)
        indices = np.ravel_multi_index([i[rows] for i in there], shape)
        fraction = volumes.fraction(indices)
        better = fraction > fullest[rows]
        rows = rows[better]
        target[rows], fullest[rows] = indices[better], fraction[better]
        away[rows] = -step * size
    goes = target >= 0
    small, target, away = small[goes], target[goes], away[goes]
    kept = np.ones(len(volumes.indices), bool)
    kept[small] = False
    indices = np.union1d(volumes.indices[kept], target)
    fractions, moments = volumes.fraction(indices), volumes.moment(indices)
    whole = volumes.whole.copy()
    whole[indices] = False
    at = np.searchsorted(indices, target)
    given = volumes.fractions[small]
    np.add.at(fractions, at, given)  # one after the other, in the order of the boxes
    np.add.at(moments, at, volumes.moments[small] + given[:, None] * away)
    return volumes._replace(whole=whole, indices=indices, fractions=fractions, moments=moments)
