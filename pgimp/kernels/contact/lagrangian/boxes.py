"""Boxes round the particles of each body."""

from pgimp.jit.kernel import kernel


@kernel
def grow_boxes(frame, particles, rows, boxes):
    """Grow the bodies' boxes so that they contain the particles in `rows`.

    Parameters
    ----------
    boxes : (2, bodies, D) float64
        Least and greatest coordinates by body, in cells from the grid's origin.
    """
    for p in rows:
        body = particles.body[p]
        for d in range(len(frame.origin)):
            x = (particles.x[p, d] - frame.origin[d]) * frame.inverse[d]
            if x < boxes[0, body, d]:  # rarely true: avoids stores and their latency
                boxes[0, body, d] = x
            if x > boxes[1, body, d]:
                boxes[1, body, d] = x
