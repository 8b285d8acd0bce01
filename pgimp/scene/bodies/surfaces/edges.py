"""Elements at edges of a surface, parted into their faces."""

from __future__ import annotations

import numpy as np

from pgimp.scene.bodies.elements import Elements, Indices, Reals
from pgimp.scene.bodies.surfaces.beside import beside

#: Greatest cosine between normals of two faces.
FLAT = 0.8

#: Moments across the normal, over area times size, above which an element has several faces, and
#: least area of one of these; what their areas may lack of the element's.
_BENT, _LACKS = 1e-3, 0.02

#: Distance of elements beside an edge, over twice the half-sides of their boxes.
_NEAR = 1.6


def parted(elements: Elements) -> Elements:
    """Elements with those at edges parted into their faces, whose normals are those beside them.

    With area vectors A_i n_i and first moments A_i c_i n_i^T of the faces, which add up to the
    element's, A_i and A_i c_i are the products of both with the vectors dual to n_i.
    """
    area = np.sqrt((elements.area * elements.area).sum(axis=1))
    normal = elements.area / np.maximum(area, 1e-300)[:, None]
    # Moments of a flat element are along its normal.
    along = (elements.moment * normal[:, None]).sum(axis=2)
    askew = elements.moment - along[:, :, None] * normal[:, None]
    reach = 2.0 * elements.half.max(axis=1)
    D = elements.centre.shape[1]
    length = np.minimum(reach, area ** (1.0 / (D - 1)) if D > 1 else reach)
    bent = np.sqrt((askew * askew).sum(axis=(1, 2))) > _BENT * area * length
    some = np.flatnonzero(bent & (area > 0.0))
    plain = np.flatnonzero(~bent & (area > _LACKS * reach ** (D - 1)))
    normals, count = _normals(elements, normal, reach, some, plain)
    keep, rows, numbers, parts = np.ones(len(area), bool), [], [], []
    for k in range(2, D + 1):
        own = some[count == k]
        every = normals[count == k, :k]
        dual = np.linalg.pinv(every)  # (n, D, k)
        each = (elements.area[own, :, None] * dual).sum(axis=1)
        whole = each > _BENT * area[own, None]
        rest = elements.area[own] - ((each * whole)[:, :, None] * every).sum(axis=1)
        far = np.sqrt((rest * rest).sum(axis=1)) > _LACKS * area[own]
        good = ~far & ~(each < -_LACKS * area[own, None]).any(axis=1)
        keep[own[good]] = False
        row, i = np.nonzero(whole & good[:, None])
        moment = (elements.moment[own[row]] * dual[row, None, :, i]).sum(axis=2)
        second = (elements.second[own[row]] * dual[row, None, :, i]).sum(axis=2)
        of = every[row, i]
        rows.append(own[row])
        numbers.append(i)
        faces = moment[:, :, None] * of[:, None], second[:, :, None] * of[:, None]
        parts.append((each[row, i, None] * of, *faces))
    if keep.all():
        return elements
    found, i = np.concatenate(rows), np.concatenate(numbers)
    order = np.lexsort((i, found))
    areas, moments, seconds = (np.concatenate(each)[order] for each in zip(*parts, strict=True))
    several = elements.chosen(found[order])
    several = several._replace(area=areas, moment=moments, second=seconds)
    both = zip(elements.chosen(keep), several, strict=True)
    return Elements(*(np.concatenate(each) for each in both))  # type: ignore[arg-type]


def _normals(
    elements: Elements, normal: Reals, reach: Reals, some: Indices, plain: Indices
) -> tuple[Reals, Indices]:
    """Normals of the `plain` elements nearest to each of some, unlike each other, and how many.

    Returns (n, D, D) and (n,).
    """
    D, middle = normal.shape[1], elements.centroid
    found, count = np.zeros((len(some), D, D)), np.zeros(len(some), np.int64)
    away = _NEAR * reach[some]
    row, other = beside(elements.centre[some], away, elements.centre[plain])
    other = plain[other]
    square = ((middle[other] - middle[some[row]]) ** 2).sum(axis=1) / reach[some[row]] ** 2
    order = np.lexsort((np.round(square, 6), row))
    row, other = row[order], other[order]
    for k in range(D):
        first = np.flatnonzero(np.diff(row, prepend=-1))  # of each of those that have any left
        here = row[first]
        found[here, k], count[here] = normal[other[first]], k + 1
        unlike = (normal[other] * found[row, k]).sum(axis=1) < FLAT
        row, other = row[unlike], other[unlike]
    return found, count
