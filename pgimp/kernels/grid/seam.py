"""The seam of periodic faces across y or z: two copies of its vertices, with one sum.

A rank stores the vertices on the high face and beyond it, where supports at the seam end, besides
those that they are: the ones on the low face and inside. Before the momentum update the sums of
both are added, those from below the seam first. The vertices beyond then have no mass, so that
books count every vertex once. After it they get the velocity of the others, for G2P.

Across x the same is done by the exchange between ranks (`pgimp.decomposition.halo`).
"""

from typing import NamedTuple

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.data.record import ACCELERATION, FORCE, HELD, MASS, RECORD, VELOCITY
from pgimp.kernels.data.used_rows import is_used, note_range, use
from pgimp.kernels.data.velocity_fields import field_count, field_size

#: In place of the mass of a vertex beyond the seam: this less the axis. Mirrors have -1 to -6.
_BEYOND = -7.0


class Seam(NamedTuple):
    """The seam of a periodic direction.

    Attributes
    ----------
    axis : int
        The direction, 1 or 2.
    """

    axis: int


@kernel
def join_seam(frame, field, seam):
    """Add the sums beyond a seam to the same vertices inside.

    Parameters
    ----------
    frame, field
        See `Frame`, `Field`.
    seam : Seam
        The seam.
    """
    window, G = field.window, field.G
    for i in range(len(field.active)):
        for f in range(field_count(window)):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            for n in range(_count(frame, window, seam)):
                g, r = _copies(frame, field, seam, i, f, n)
                if not G[g + MASS] > 0.0:  # beyond two seams: its sums are at the other one
                    continue
                low = r - i * window.stride[0]
                use(field, i, low, low + RECORD)
                for d in range(RECORD):
                    G[r + d] = G[g + d] + G[r + d]
                    G[g + d] = 0.0
                G[g + MASS] = _BEYOND - seam.axis


@kernel
def join_volumes(frame, field, volumes, used, seam):
    """Add the `VolumeSums` beyond a seam to the same vertices inside, after `join_seam`.

    Parameters
    ----------
    frame, field, seam
        As in `join_seam`.
    volumes, used
        As in `pgimp.kernels.grid.mirror.fold_volumes`.
    """
    window, G = field.window, field.G
    for i in range(len(field.active)):
        for f in range(field_count(window)):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            for n in range(_count(frame, window, seam)):
                g, r = _copies(frame, field, seam, i, f, n)
                if G[g + MASS] != _BEYOND - seam.axis:
                    continue
                for d in range(RECORD):
                    volumes[r + d] = volumes[g + d] + volumes[r + d]
                low = r - i * window.stride[0]
                note_range(window, used[i], low, low + RECORD)


@kernel
def part_seam(frame, field, seam):
    """Give the vertices beyond a seam mass, velocity and acceleration of the same ones inside.

    Of two seams the one that was joined last comes first.
    """
    window, G = field.window, field.G
    for i in range(len(field.active)):
        for f in range(field_count(window)):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            for n in range(_count(frame, window, seam)):
                g, r = _copies(frame, field, seam, i, f, n)
                if G[g + MASS] != _BEYOND - seam.axis:
                    continue
                G[g + MASS], G[g + HELD] = G[r + MASS], G[r + HELD]
                for d in range(3):
                    G[g + VELOCITY + d] = G[r + VELOCITY + d]
                    G[g + ACCELERATION + d] = G[r + ACCELERATION + d]


@kernel
def part_accelerations(frame, field, seam, A, reach):
    """Give the vertices beyond a seam the accelerations of the same ones inside.

    Parameters
    ----------
    frame, field, seam
        As in `join_seam`, after it.
    A, reach
        Accelerations, see `pgimp.kernels.lagrangian.averaged_mass.find_accelerations`.
    """
    window, G = field.window, field.G
    half = window.stride[0] // 2
    for i in range(len(field.active)):
        for f in range(field_count(window)):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            for n in range(_count(frame, window, seam)):
                g, r = _copies(frame, field, seam, i, f, n)
                if G[g + MASS] != _BEYOND - seam.axis:
                    continue
                to, source = reach * half + g // 2, reach * half + r // 2
                for d in range(3):
                    A[to + 1 + d] = A[source + 1 + d]


@kernel
def join_forces(frame, field, seam):
    """Add forces beyond a seam, found since `join_seam`, to those of the same vertices inside."""
    window, G = field.window, field.G
    for i in range(len(field.active)):
        for f in range(field_count(window)):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            for n in range(_count(frame, window, seam)):
                g, r = _copies(frame, field, seam, i, f, n)
                if G[g + MASS] != _BEYOND - seam.axis:
                    continue
                for d in range(3):
                    G[r + FORCE + d] = G[g + FORCE + d] + G[r + FORCE + d]
                    G[g + FORCE + d] = 0.0


@kernel
def join_records(frame, field, seam):
    """Give all copies of the vertices of a seam the sum of both, as of the filling of flows."""
    window, G = field.window, field.G
    for i in range(len(field.active)):
        for f in range(field_count(window)):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            use(field, i, f * field_size(window), (f + 1) * field_size(window))
            for n in range(_count(frame, window, seam)):
                g, r = _copies(frame, field, seam, i, f, n)
                for d in range(RECORD):
                    G[r + d] = G[g + d] + G[r + d]
                    G[g + d] = G[r + d]


@inner_kernel
def _first(frame, window, seam):
    """First row of a window, along the seam's axis, on the high face; 0 for the low face's rows."""
    return max(0, frame.ghost + frame.cells[seam.axis] - window.lower[seam.axis])


@inner_kernel
def _count(frame, window, seam):
    """Number of the window's vertices on the high face of a seam or beyond it, in a plane."""
    beyond = max(0, window.extent[seam.axis] - _first(frame, window, seam))
    return beyond * window.extent[3 - seam.axis]


@inner_kernel
def _copies(frame, field, seam, i, f, n):
    """Offsets of the `n`-th vertex beyond the seam, in plane `i`, and of the same one inside."""
    window, axis = field.window, seam.axis
    across = window.extent[3 - axis]
    beyond = i * window.stride[0] + f * field_size(window)
    beyond += (_first(frame, window, seam) + n // across) * window.stride[axis]
    beyond += n % across * window.stride[3 - axis]
    return beyond, beyond - frame.cells[axis] * window.stride[axis]
