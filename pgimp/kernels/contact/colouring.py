"""Velocity fields of bodies by a greedy colouring, from their bounding boxes.

Close bodies are found by a sweep: in the order of their lower ends along an axis, each is compared
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
def _steps_apart(boxes, reach, a, b):
    """Steps until two bodies may have a common vertex, if both move by a cell in each."""
    return 0.5 * max(_distance(boxes, a, b) - reach, 0.0)


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
def find_neighbours(boxes, reach, fewest, axis, order, pairs):
    """Find the pairs of bodies that may touch within the fewest steps.

    Parameters
    ----------
    boxes, reach, fewest
        See `colour_bodies`.
    axis, order : int, (bodies,) int64
        Axis of the sweep, and the bodies in the order of their lower ends along it.
    pairs : (n, 2) int64
        Filled with the pairs, the lower number first, as far as there is room.

    Returns
    -------
    int
        Number of pairs.
    """
    found, wide = 0, 2.0 * fewest + reach
    for n in range(len(order)):
        for m in range(n + 1, _end(boxes, axis, order, n, wide)):
            a, b = min(order[n], order[m]), max(order[n], order[m])
            if _are_within(boxes, a, b, wide) and _steps_apart(boxes, reach, a, b) < fewest:
                if found < len(pairs):
                    pairs[found, 0], pairs[found, 1] = a, b
                found += 1
    return found


@kernel
def colour_bodies(boxes, reach, most, axis, order, pairs, scratch, fields):
    """Set the fields: each body gets the lowest one not used by any body it may touch soon.

    Parameters
    ----------
    boxes : (2, bodies, D) float64
        Least and greatest coordinates by body, in cells; infinite without particles.
    reach : float
        Distance in cells from which two particles have no common vertex along a direction.
    most : int
        Most steps without contact that count.
    axis, order, pairs
        See `find_neighbours`.
    scratch : (2 * bodies + len(pairs) + 2,) int64
        Scratch, zeros.
    fields : (bodies,) int64
        Set here.

    Returns
    -------
    int
        Steps in which bodies of one field have no common vertex, at most `most`.
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
    steps = most
    for n in range(len(order)):
        for m in range(n + 1, _end(boxes, axis, order, n, 2.0 * steps + reach)):
            if fields[order[n]] == fields[order[m]] and _are_within(
                boxes, order[n], order[m], 2.0 * steps + reach
            ):
                alone = _steps_apart(boxes, reach, order[n], order[m])
                if alone < steps:
                    steps = int(alone)
    return steps


@kernel
def find_intervals(boxes, fields, wide, axis, order, ends):
    """Find intervals along x in which bodies of different fields may have common vertices.

    Parameters
    ----------
    boxes, fields
        See `colour_bodies`.
    wide : float
        Cells by which boxes may be apart.
    axis, order
        See `find_neighbours`.
    ends : (n, 2) float64
        Filled with the intervals' ends, as far as there is room.

    Returns
    -------
    int
        Number of intervals.
    """
    found = 0
    for n in range(len(order)):
        for m in range(n + 1, _end(boxes, axis, order, n, wide)):
            a, b = order[n], order[m]
            if fields[a] == fields[b] or not _are_within(boxes, a, b, wide):
                continue
            if not _distance(boxes, a, b) < wide:
                continue
            if found < len(ends):
                ends[found, 0] = max(boxes[0, a, 0], boxes[0, b, 0]) - 0.5 * wide
                ends[found, 1] = min(boxes[1, a, 0], boxes[1, b, 0]) + 0.5 * wide
            found += 1
    return found


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
