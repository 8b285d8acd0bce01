"""Velocity fields of bodies by a greedy colouring, from their bounding boxes.

Close bodies are found by a sweep in the order of their lower ends along an axis. Each is compared
with those after it up to its upper end and the distance asked for.
"""

from pgimp.jit.kernel import inner_kernel, kernel

#: Added to the distance up to which a sweep compares bodies, in cells: exact tests follow.
_SLACK = 1e-9


@inner_kernel
def _distance(boxes, a, b):
    """Greatest gap between two bodies along a direction, in cells; infinite for empty ones."""
    apart = -1e300
    for d in range(boxes.shape[2]):
        apart = max(apart, boxes[0, a, d] - boxes[1, b, d], boxes[0, b, d] - boxes[1, a, d])
    return apart


@inner_kernel
def _end(boxes, axis, order, n, wide):
    """Offset behind the last body, in the order, that may be within a distance of the `n`-th."""
    most, end = boxes[1, order[n], axis] + wide + _SLACK, n + 1
    while end < len(order) and boxes[0, order[end], axis] < most:
        end += 1
    return end


@inner_kernel
def _are_within(boxes, a, b, wide):
    """Whether two bodies are within a distance, or by a rounding beyond it."""
    for d in range(boxes.shape[2]):
        if max(boxes[0, a, d] - boxes[1, b, d], boxes[0, b, d] - boxes[1, a, d]) > wide + _SLACK:
            return False
    return True


@kernel
def find_neighbours(boxes, wide, axis, order, pairs):
    """Find the pairs of bodies whose boxes are less than a distance apart.

    Parameters
    ----------
    boxes : (2, bodies, D) float64
        Least and greatest coordinates by body, in cells; infinite without particles.
    wide : float
        The distance in cells, along each direction.
    axis, order : int, (bodies,) int64
        Axis of the sweep, and the bodies in the order of their lower ends along it.
    pairs : (n, 2) int64
        Filled with the pairs, the lower number first, as far as there is room.

    Returns
    -------
    int
        Number of pairs.
    """
    found = 0
    for n in range(len(order)):
        for m in range(n + 1, _end(boxes, axis, order, n, wide)):
            a, b = min(order[n], order[m]), max(order[n], order[m])
            if _are_within(boxes, a, b, wide) and _distance(boxes, a, b) < wide:
                if found < len(pairs):
                    pairs[found, 0], pairs[found, 1] = a, b
                found += 1
    return found


@kernel
def find_margin(boxes, reach, most, axis, order, fields):
    """Half of what is between bodies of one field beyond a distance, in cells.

    Parameters
    ----------
    boxes, axis, order
        See `find_neighbours`.
    reach, most : float
        The distance; the greatest margin that counts.
    fields : (bodies,) int64
        The bodies' fields.
    """
    margin = most
    for n in range(len(order)):
        for m in range(n + 1, _end(boxes, axis, order, n, 2.0 * margin + reach)):
            if fields[order[n]] == fields[order[m]]:
                margin = min(margin, 0.5 * (_distance(boxes, order[n], order[m]) - reach))
    return margin


@kernel
def colour_bodies(pairs, scratch, fields):
    """Set the fields: each body gets the lowest one that no body near it with a lower number has.

    Parameters
    ----------
    pairs : (n, 2) int64
        The bodies near each other, see `find_neighbours`.
    scratch : (2 * bodies + n + 2,) int64
        Scratch, zeros.
    fields : (bodies,) int64
        Set here.
    """
    count = len(fields)
    stamps, start = scratch[: count + 1], scratch[count + 1 : 2 * count + 2]
    lower = scratch[2 * count + 2 :]
    for n in range(len(pairs)):
        start[pairs[n, 1]] += 1
    for b in range(count):  # then the ends of the bodies' lists in `lower`, to be filled from there
        start[b + 1] += start[b]
    for n in range(len(pairs)):
        start[pairs[n, 1]] -= 1
        lower[start[pairs[n, 1]]] = pairs[n, 0]
    for b in range(count):
        for k in range(start[b], start[b + 1]):
            stamps[fields[lower[k]]] = b + 1
        own = 0
        while stamps[own] == b + 1:
            own += 1
        fields[b] = own


@kernel
def find_excursion(frame, x, body, rows, boxes):
    """Greatest distance, in cells along a direction, of particles outside of their bodies' boxes.

    Parameters
    ----------
    x, body : (n, D) float64, (n,) int
        Coordinates and bodies of particles.
    rows : (k,) int32
        The particles to look at.
    boxes : (2, bodies, D) float64
        As of `find_neighbours`.

    Returns
    -------
    float
        0 if all are inside.
    """
    most = 0.0
    for p in rows:
        b = body[p]
        for d in range(len(frame.cell)):
            at = (x[p, d] - frame.origin[d]) * frame.inverse[d]
            out = max(boxes[0, b, d] - at, at - boxes[1, b, d])
            if out > most:  # rarely true: avoids the latency of a chain
                most = out
    return most


@kernel
def bound_bodies(x, body, rows, boxes):
    """Grow the bodies' boxes, (2, bodies, D), to contain the coordinates x of particles.

    Cells are counted afterwards: rounding keeps the order of coordinates.
    """
    for p in rows:
        b = body[p]
        for d in range(boxes.shape[2]):
            if x[p, d] < boxes[0, b, d]:  # rarely true: avoids stores and their latency
                boxes[0, b, d] = x[p, d]
            if x[p, d] > boxes[1, b, d]:
                boxes[1, b, d] = x[p, d]
