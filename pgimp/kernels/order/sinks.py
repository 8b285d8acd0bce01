"""Particles in a box, for sinks: few of many, found before their regions are asked."""

from pgimp.jit.kernel import kernel


@kernel
def find_in_box(order, x, low, high, found):
    """Find the particles with their centre in a box.

    Parameters
    ----------
    order : (n,) int32
        Rows in canonical order.
    x : (c, D) float64
        Positions.
    low, high : (D,) float64
        Ends of the box, which may be infinite.
    found : (n,) int32
        Filled with offsets in `order`, ascending.

    Returns
    -------
    int
        Their number.
    """
    count, D = 0, x.shape[1]
    for k in range(len(order)):
        p = order[k]
        inside = True
        for d in range(D):
            if not low[d] <= x[p, d] <= high[d]:
                inside = False
        if inside:
            found[count] = k
            count += 1
    return count
