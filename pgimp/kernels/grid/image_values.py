"""Values of vertices beyond a face, added to those of their images, and copied from them.

Here nothing is booked; `mirror.py` has momentum and forces at faces, which bear impulses. At the
seam of a periodic direction the sums of both copies are added before the momentum update. The
vertices beyond then have no mass, so that books count every vertex once.
"""

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.data.images import (
    beyond_count,
    box_beyond,
    image_at,
    image_of,
    mark_of,
    offset_of,
    reverses,
)
from pgimp.kernels.data.record import FORCE, MASS, RECORD
from pgimp.kernels.data.used_rows import is_used, note_range, use
from pgimp.kernels.data.velocity_fields import field_count, field_size

#: All entries of a record, as the bits of `fold_values` and `copy_values`.
ALL = (1 << RECORD) - 1


@kernel
def fold_values(frame, field, images, entries, marks):
    """Add entries of the records beyond a face to those of their images; they become 0.

    Parameters
    ----------
    frame, field
        See `Frame`, `Field`.
    images : Images
        The face.
    entries : int
        The entries of a record, as bits.
    marks : bool
        Whether only vertices with mass are folded, and marked, see `mark_of`.
    """
    window, G = field.window, field.G
    (i0, x), (j0, y), (k0, z) = box_beyond(frame, window, images)
    for f in range(field_count(window)):
        begin = f * field_size(window)
        for i in range(i0, i0 + x):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            for j in range(j0, j0 + y):
                for k in range(k0, k0 + z):
                    # Beyond two seams a vertex has no mass: its sums are at the other one.
                    if not marks or G[offset_of(window, begin, i, j, k) + MASS] > 0.0:
                        image = image_at(frame, field, images, begin, i, j, k)
                        _fold_entries(field, images, image, f, entries, marks)


@inner_kernel
def _fold_entries(field, images, image, f, entries, marks):
    """Add entries of the record of a vertex of field `f` to those of its image."""
    G, (i, g, r, _) = field.G, image
    plane = r // field.window.stride[0]
    if r < 0 or (plane != i and not is_used(field, plane, f)):
        return
    if images.period > 0:
        low = r - plane * field.window.stride[0]
        use(field, plane, low, low + RECORD)
    for d in range(RECORD):
        if entries >> d & 1:
            G[r + d] = G[g + d] + G[r + d]
            G[g + d] = 0.0
    if marks:
        G[g + MASS] = mark_of(images)


@kernel
def fold_volumes(frame, field, volumes, used, images):
    """Add the `VolumeSums` beyond a face to the sums of the images.

    Parameters
    ----------
    frame, field, images
        As in `fold_values`, after it or after `mirror.fold`; vertices that are not marked stay.
    volumes : (planes * plane,) float64
        The sums.
    used : (planes + 1, fields) int64
        Their used rows, see `Field`.
    """
    window, G = field.window, field.G
    for f in range(field_count(window)):
        begin = f * field_size(window)
        for n in range(beyond_count(frame, window, images)):
            _, g, r, _ = image_of(frame, field, images, begin, n)
            if r < 0 or G[g + MASS] != mark_of(images):
                continue
            for d in range(RECORD):
                sign = -1.0 if d == FORCE + images.axis and not images.follows else 1.0
                volumes[r + d] += sign * volumes[g + d]
            plane = r // window.stride[0]
            low = r - plane * window.stride[0]
            note_range(window, used[plane], low, low + RECORD)


@kernel
def copy_values(frame, field, images, entries):
    """Set entries of the records beyond a face from those of their images.

    Parameters
    ----------
    frame, field, images, entries
        As in `fold_values`.
    """
    window, G = field.window, field.G
    (i0, x), (j0, y), (k0, z) = box_beyond(frame, window, images)
    for f in range(field_count(window)):
        begin = f * field_size(window)
        for i in range(i0, i0 + x):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            for j in range(j0, j0 + y):
                for k in range(k0, k0 + z):
                    _, g, r, _ = image_at(frame, field, images, begin, i, j, k)
                    plane = r // window.stride[0]
                    if r < 0 or (plane != i and not is_used(field, plane, f)):
                        continue
                    if images.period > 0:
                        low = g - i * window.stride[0]
                        use(field, i, low, low + RECORD)
                    for d in range(RECORD):
                        if entries >> d & 1:
                            G[g + d] = G[r + d]


@kernel
def copy_accelerations(frame, field, images, A, reach):
    """Set accelerations beyond a face from those of the images, before the momentum update.

    Parameters
    ----------
    frame, field, images
        As in `fold_values`, after it or after `mirror.fold`.
    A, reach
        Accelerations, see `pgimp.kernels.lagrangian.averaged_mass.average_forces`.
    """
    window, G = field.window, field.G
    half = window.stride[0] // 2
    for f in range(field_count(window)):
        begin = f * field_size(window)
        for n in range(beyond_count(frame, window, images)):
            i, g, r, _ = image_of(frame, field, images, begin, n)
            if r < 0 or not is_used(field, i, f) or G[g + MASS] != mark_of(images):
                continue
            to, source = reach * half + g // 2, reach * half + r // 2
            for d in range(3):
                sign = -1.0 if reverses(images, d) else 1.0
                A[to + 1 + d] = sign * A[source + 1 + d]
