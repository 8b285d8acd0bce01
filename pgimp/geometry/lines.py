"""Lines through boxes: where a region's surface cuts them, and sums over their stretches.

Products and sums are rounded one by one, so that no bit depends on what a kernel has beside them.
"""

from pgimp.jit.kernel import exact, inner_kernel, kernel


@exact
def _times(a, b):
    """A product."""
    return a * b


@exact
def _plus(a, b, c):
    """The sum a + b c."""
    return a + b * c


@inner_kernel
def _insert(x, a, b, count, ends):
    """Insert x between a and b into ascending numbers; returns their number."""
    if not a < x < b:
        return count
    place = count
    while ends[place - 1] > x:
        ends[place] = ends[place - 1]
        place -= 1
    ends[place] = x
    return count + 1


@kernel
def cut_lines(boxes, row, axis, crossings, more, ends, found) -> tuple[int, int]:
    """Cut lines along an axis at their crossings with a surface.

    Parameters
    ----------
    boxes : ((m, D) float64, (m, D) float64, (m, D) float64)
        Low and high corners of boxes, in which the lines end, and points to which moments refer.
    row : (n,) int64
        The box of each line.
    crossings : (n, k) float64
        Places on them, in any order; those beyond the ends, and NaN, do not count.
    more : ((m,) int64, (m,) float64)
        Lines, ascending, and further places on these.
    ends : (2 + k + m,) float64
        Scratch.
    found : ((s,) int64, (s,) float64, (s,) float64)
        Filled: the line of each stretch, ascending, and its ends; s is n (1 + k) + m.

    Returns
    -------
    tuple of 2 int
        Number of stretches; the most of a line.
    """
    most, count, extra, (of, left, right), (low, high, _) = 0, 0, 0, found, boxes
    for i in range(len(row)):
        a, b, first, places = low[row[i], axis], high[row[i], axis], count, 1
        ends[0] = a
        for k in range(crossings.shape[1]):
            places = _insert(crossings[i, k], a, b, places, ends)
        while extra < len(more[0]) and more[0][extra] == i:
            places = _insert(more[1][extra], a, b, places, ends)
            extra += 1
        if not a < b:
            continue
        ends[places] = b
        for k in range(places):
            if ends[k] < ends[k + 1]:
                of[count], left[count], right[count] = i, ends[k], ends[k + 1]
                count += 1
        most = max(most, count - first)
    return count, most


@kernel
def set_nodes(points, of, left, right, axis, nodes, at):
    """Set points of a rule on stretches of lines along an axis, (s * nodes, D), stretch by stretch.

    `points` are one of each line.
    """
    n = 0
    for s in range(len(of)):
        for node in nodes:
            for d in range(points.shape[1]):
                at[n, d] = points[of[s], d]
            at[n, axis] = _plus(left[s], node, right[s] - left[s])
            n += 1


@kernel
def add_stretches(stretches, inside, at, lines, columns, total):
    """Add integrals over stretches of lines to those of the lines.

    Parameters
    ----------
    stretches : ((s,) int64, (s,) float64, (s,) float64)
        As `cut_lines` returns them.
    inside : (s,) bool
        Which count.
    at : (s, D) float64
        The stretches' middles.
    lines : ((n,) int64, (m, D) float64, int)
        The box of each line, points to which moments refer, the lines' direction.
    columns : (int, int)
        Columns of the first moment along the lines, and of the second or -1.
    total : (n, columns) float64
        Changed in place.
    """
    (of, left, right), (row, centre, axis), (first, second) = stretches, lines, columns
    for s in range(len(of)):
        if not inside[s]:
            continue
        i, width = of[s], right[s] - left[s]
        arm = at[s, axis] - centre[row[i], axis]
        total[i, 0] += width
        total[i, first] = _plus(total[i, first], width, arm)
        if second >= 0:
            inner = _plus(_times(width, width) / 12.0, arm, arm)
            total[i, second] = _plus(total[i, second], width, inner)


@kernel
def add_nodes(stretches, weights, at, lines, columns, parts, total):
    """Add integrals at points of a rule on stretches of lines to those of the lines.

    Parameters
    ----------
    weights : (nodes,) float64
        Of the rule's points.
    at : (s * nodes, D) float64
        The points.
    lines
        As of `add_stretches`.
    columns : ((k,) int64, (k,) int64)
        Power of the lines' direction in each column, and the column without it.
    parts : (s * nodes, k) float64
        Integrals across the lines; changed in place.
    total : (n, k) float64
        Likewise.
    """
    n, (of, left, right), (row, centre, axis), (powers, others) = 0, stretches, lines, columns
    for s in range(len(of)):
        i, width = of[s], right[s] - left[s]
        for weight in weights:
            arm, factor = at[n, axis] - centre[row[i], axis], _times(weight, width)
            square = _times(arm, arm)
            for k in range(parts.shape[1]):
                parts[n, k] = _times(parts[n, k], factor)
            for k in range(parts.shape[1]):
                if powers[k] > 0:
                    by = arm if powers[k] == 1 else square
                    parts[n, k] = _plus(parts[n, k], parts[n, others[k]], by)
            for k in range(parts.shape[1]):
                total[i, k] += parts[n, k]
            n += 1
