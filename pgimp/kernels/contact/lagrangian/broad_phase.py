"""Broad phase for particles: particles in cells near the particles of possible partners."""

from typing import NamedTuple

from numpy.typing import NDArray

from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.data.particles import FloatArray, IntArray

#: Marks of a block for each of a region's two groups: the first, the second.
MARKS = (1, 2)


class Regions(NamedTuple):
    """Regions of possible contact."""

    #: (n, 2, D) float64: Least and greatest coordinates, in cells from the grid's origin.
    ends: FloatArray
    #: (n, 2) int64: The two groups of bodies that may touch there; -1: any particle may touch a
    #: rigid body or a wall.
    groups: IntArray
    #: (n, D) int64: Number of blocks in a region by direction, where two groups may touch.
    blocks: IntArray
    size: IntArray  #: (n,) int64: Cells along the side of a block; 0 without blocks.
    first: IntArray  #: (n,) int64: Number of the region's first block.
    #: (blocks,) uint8: Groups in or near a block, see `MARKS`; the last direction innermost.
    marks: NDArray
    start: IntArray  #: (groups + 1,) int64: First item of each group in `of_group`.
    of_group: IntArray  #: (k,) int64: The regions of each group.


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


@kernel
def greatest_speed(frame, particles, rows):
    """Greatest speed along a direction of the particles in `rows`, in cells per unit of time."""
    fastest = 0.0
    for p in rows:
        for d in range(len(frame.origin)):
            fastest = max(fastest, abs(particles.v[p, d] * frame.inverse[d]))
    return fastest


@inner_kernel
def _block_of(frame, particles, p, regions, r):
    """Number of a particle's block in a region, 0 without blocks; -1 for a particle outside."""
    block = 0
    for d in range(len(frame.origin)):
        x = (particles.x[p, d] - frame.origin[d]) * frame.inverse[d]
        if not regions.ends[r, 0, d] <= x <= regions.ends[r, 1, d]:
            return -1
        if regions.size[r] > 0:
            away = int(x - regions.ends[r, 0, d]) // regions.size[r]
            block = block * regions.blocks[r, d] + min(away, regions.blocks[r, d] - 1)
    return block


@kernel
def mark_blocks(frame, particles, rows, groups, regions):
    """Mark the blocks that contain particles; `groups` has the group of each body."""
    for p in rows:
        group = groups[particles.body[p]]
        for n in range(regions.start[group], regions.start[group + 1]):
            r = regions.of_group[n]
            if regions.groups[r, 0] < 0:
                continue
            block = _block_of(frame, particles, p, regions, r)
            if block >= 0:
                end = 0 if regions.groups[r, 0] == group else 1
                regions.marks[regions.first[r] + block] |= MARKS[end]


@kernel
def widen_marks(regions, counts, line):
    """Mark blocks up to a number before or behind marked ones, along each direction in turn.

    Parameters
    ----------
    counts : (n, D) int64
        That number, for the regions with blocks.
    line : (blocks of the longest line,) uint8
        Scratch.
    """
    D = counts.shape[1]
    for r in range(len(counts)):
        whole, stride = 1, 1
        for d in range(D):
            whole *= regions.blocks[r, d]
        for axis in range(D - 1, -1, -1):
            length = regions.blocks[r, axis]
            for begin in range(whole):
                if (begin // stride) % length == 0:
                    first = regions.first[r] + begin
                    _widen_line(regions.marks, first, stride, length, counts[r, axis], line)
            stride *= length


@inner_kernel
def _widen_line(marks, first, stride, length, count, line):
    """Mark blocks along one line."""
    for i in range(length):
        line[i] = marks[first + i * stride]
    for mark in MARKS:
        last = -count - 1
        for i in range(length):
            last = i if line[i] & mark else last
            if i - last <= count:
                marks[first + i * stride] |= mark
        last = length + count
        for i in range(length - 1, -1, -1):
            last = i if line[i] & mark else last
            if last - i <= count:
                marks[first + i * stride] |= mark


@kernel
def find_near(frame, particles, rows, groups, regions, near):
    """Find the particles in possible contact.

    Parameters
    ----------
    rows : (n,) int
        The particles, in their order.
    groups : (bodies,) int64
        The groups of bodies.
    regions : Regions
        With the marks of groups near each block.
    near : (n,) int64
        Filled with offsets into `rows`.

    Returns
    -------
    int
        Number of particles found.
    """
    found = 0
    for i in range(len(rows)):
        group = groups[particles.body[rows[i]]]
        for n in range(regions.start[group], regions.start[group + 1]):
            r = regions.of_group[n]
            one = regions.groups[r, 0]
            block = _block_of(frame, particles, rows[i], regions, r)
            if block < 0:
                continue
            if one >= 0:
                seen = MARKS[1] if group == one else MARKS[0]
                if regions.marks[regions.first[r] + block] & seen == 0:
                    continue
            near[found] = i
            found += 1
            break
    return found
