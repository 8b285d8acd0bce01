"""Velocity fields of bodies by a greedy colouring, from their bounding boxes."""

from pgimp.jit.kernel import inner_kernel, kernel


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


@kernel
def colour_bodies(boxes, reach, fewest, most, stamps, fields):
    """Set the fields: each body gets the lowest one not used by any body it may touch soon.

    Parameters
    ----------
    boxes : (2, bodies, D) float64
        Least and greatest coordinates by body, in cells; infinite without particles.
    reach : float
        Distance in cells from which two particles have no common vertex along a direction.
    fewest, most : int
        Least number of steps without contact for bodies of one field, and the most that count.
    stamps : (bodies + 1,) int64
        Scratch, zeros.
    fields : (bodies,) int64
        Set here.

    Returns
    -------
    int
        Steps in which bodies of one field have no common vertex, at most `most`.
    """
    steps = most
    for b in range(len(fields)):
        for a in range(b):
            if _steps_apart(boxes, reach, a, b) < fewest:
                stamps[fields[a]] = b + 1
        own = 0
        while stamps[own] == b + 1:
            own += 1
        fields[b] = own
        for a in range(b):
            if fields[a] == own:
                alone = _steps_apart(boxes, reach, a, b)
                if alone < steps:
                    steps = int(alone)
    return steps


@kernel
def find_intervals(boxes, fields, wide, ends):
    """Find intervals along x in which bodies of different fields may have common vertices.

    Parameters
    ----------
    boxes, fields
        See `colour_bodies`.
    wide : float
        Cells by which boxes may be apart.
    ends : (n, 2) float64
        Filled with the intervals' ends, as far as there is room.

    Returns
    -------
    int
        Number of intervals.
    """
    found = 0
    for a in range(len(fields)):
        for b in range(a + 1, len(fields)):
            if fields[a] == fields[b] or not _distance(boxes, a, b) < wide:
                continue
            if found < len(ends):
                ends[found, 0] = max(boxes[0, a, 0], boxes[0, b, 0]) - 0.5 * wide
                ends[found, 1] = min(boxes[1, a, 0], boxes[1, b, 0]) + 0.5 * wide
            found += 1
    return found
