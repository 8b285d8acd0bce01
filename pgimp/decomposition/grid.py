"""A rank's part of the grid: storage for its planes, only as wide as its particles need."""

from collections.abc import Sequence

import numpy as np

from pgimp.decomposition.slabs import Slab
from pgimp.kernels.data.arguments import Field
from pgimp.kernels.data.frame import Frame, Window
from pgimp.kernels.data.motion import VertexMotion
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.used_rows import clear_planes

#: Cells by which the window reaches beyond the particles, so that it seldom has to grow.
MARGIN = 2

#: Further cells where ranks receive each other's bounds one step late. In a step a particle moves
#: by a cell at most, and its support may grow by another.
LAG = 2

#: How the arrays of `Grid.marks` of two copies of a vertex are united: bits, and whole numbers.
UNITE = np.bitwise_or, np.add


def aligned(size: int) -> FloatArray:
    """Zeros at an address that vector loads accept; untouched pages cost no memory."""
    raw = np.zeros(size + 8)
    offset = (-raw.ctypes.data // 8) % 8
    return raw[offset : offset + size]


def _common_end(one: Window, other: Window) -> np.ndarray:
    """Ends of the vertices that two windows have in common."""
    return np.minimum(np.add(one.lower, one.extent), np.add(other.lower, other.extent))


class Grid:
    """Planes of vertices `first` to ``first + planes - 1``, cut to a window in y and z.

    All ranks have one window in y and z, so that both sides of a message agree on its size.

    Parameters
    ----------
    frame : Frame
        Position of the grid.
    vertices : int
        Vertices in one direction of a particle's support.
    slab : Slab
        The rank's layers; it stores ``vertices - 1`` planes more, shared with other ranks.
    lag : int
        Cells by which a particle may be beyond the common bounds.
    fields : sequence of int
        Number of each body's velocity field; () if all bodies share one.
    bounds : tuple of D pairs of float, optional
        Bounds on the particles' coordinates, in the initial configuration, where they do not follow
        from the grid.
    lagrangian : (bodies,) bool, optional
        Bodies in the initial configuration, whose vertices keep their motion.
    periodic : sequence of bool, optional
        Directions in which the domain is periodic; the window has all of those across.

    Attributes
    ----------
    shared_lower : int
        Planes shared with the lower neighbour; 0 without one.
    owned : int
        Planes of this rank; planes above belong to the upper neighbour.
    window : Window
        The stored range.
    field : Field
        The stored records, for kernels.
    G : (planes * plane,) float64
        Records of the vertices, see `pgimp.kernels.data.record`; only active planes are defined.
    active : (planes,) uint8
        Mask of the planes that take part in this step.
    scratch, deferred : float64
        See `particles_to_grid`.
    partial : float64
        The part of `deferred` for planes shared with the lower neighbour.
    marks : tuple of 1 or 2 (planes * plane / 8,) int64
        See `pgimp.kernels.grid.constrained_vertices`; made at first use.
    weighs : bool
        Whether there are two: constraints hold vertices by their part of the mass.
    base : (2, 2) int64
        Bounds of the first vertices (least, greatest; y, z) of supports in the window.
    motion : VertexMotion or ()
        Motion that the vertices keep; it stays when the window changes.
    inner_bounds : (2, 2) int64
        Bounds that ranks need not report: `lag` cells less, except at the ends of the grid.
    """

    def __init__(
        self,
        frame: Frame,
        vertices: int,
        slab: Slab,
        lag: int = 0,
        fields: Sequence[int] = (),
        bounds: tuple[tuple[float, float], ...] | None = None,
        lagrangian: np.ndarray | None = None,
        periodic: Sequence[bool] = (),
    ) -> None:
        self.frame = frame
        self.lag = lag
        self._fixed_bounds = bounds
        self._lagrangian = lagrangian
        self._periodic = tuple(periodic) or (False,) * len(frame.cells)
        self.fields = tuple(fields)
        self.vertices = vertices
        self.slab = slab
        self.planes = slab.layers + vertices - 1 if slab.layers else 0
        self.shared_lower = vertices - 1 if slab.lower is not None else 0
        self.owned = slab.layers if slab.upper is not None else self.planes
        self.active = np.zeros(self.planes, np.uint8)
        self.base = np.zeros((2, 2), np.int64)
        self.inner_bounds = np.zeros((2, 2), np.int64)
        self.motion: VertexMotion | tuple[()] = ()
        self.weighs = False
        self._stored = Window.over((0, 0, 0), (0, 0, 0))
        self._room: dict[str, FloatArray] = {}

    def cover(self, bounds: np.ndarray) -> None:
        """Store the vertices for supports with first vertices within `bounds`, and a margin."""
        margin = MARGIN + self.lag
        self.store(bounds + np.array([[-margin], [margin]]))

    def extend(self, bounds: np.ndarray) -> None:
        """Widen the window, by a margin, on the sides where `bounds` exceeds `inner_bounds`."""
        base, margin = self.base.copy(), MARGIN + self.lag
        base[0] = np.where(bounds[0] < self.inner_bounds[0], bounds[0] - margin, base[0])
        base[1] = np.where(bounds[1] > self.inner_bounds[1], bounds[1] + margin, base[1])
        self.store(base)

    def covers(self, bounds: np.ndarray) -> bool:
        """Whether supports with first vertices within `bounds` lie in the window, with `lag`."""
        (low, high), (least, greatest) = bounds.tolist(), self.inner_bounds.tolist()
        return (  # in Python: NumPy would take a fifth of the step of a tiny scene
            low[0] >= least[0]
            and low[1] >= least[1]
            and high[0] <= greatest[0]
            and high[1] <= greatest[1]
        )

    def store(self, base: np.ndarray) -> None:
        """Allocate for the supports with first vertices within `base`, cut to the grid."""
        lower, extent = [self.slab.first, 0, 0], [self.planes, 1, 1]
        self.base, self.inner_bounds = np.zeros_like(base), np.zeros_like(base)
        for d in range(1, len(self.frame.cells)):
            last = self.frame.vertices[d] - self.vertices
            low, high = max(0, int(base[0, d - 1])), min(last, int(base[1, d - 1]))
            inner = min(low + self.lag, last) if low else 0, max(high - self.lag, 0)
            if self._periodic[d]:
                low, high = inner = self.frame.ghost, self.frame.ghost + self.frame.cells[d] - 1
            self.base[:, d - 1] = low, high
            self.inner_bounds[:, d - 1] = inner[0], inner[1] if high < last else last
            lower[d], extent[d] = low, high - low + self.vertices
        self._room.clear()
        self._arrange((lower[0], lower[1], lower[2]), (extent[0], extent[1], extent[2]))

    def regroup(self, fields: Sequence[int]) -> None:
        """Change the bodies' velocity fields; sums are lost, and arrays stay where they fit."""
        clear_planes(self.field)
        self.fields = tuple(fields)
        self._arrange(self.window.lower, self.window.extent)

    def _arrange(self, lower: tuple[int, int, int], extent: tuple[int, int, int]) -> None:
        """Lay out the fields of the planes in a window."""
        self.window = Window.over(lower, extent, self.fields)
        plane = self.window.stride[0]
        self.G = self._zeros("G", self.planes * plane)
        self.scratch = self._zeros("scratch", self.vertices * plane)
        half = self.shared_lower * (self.shared_lower + 1) // 2 * plane
        shared_upper = self.vertices - 1 if self.slab.upper is not None else 0
        deferred = half + shared_upper * (shared_upper + 1) // 2 * plane
        self.deferred = self._zeros("deferred", deferred)
        self.partial = self.deferred[:half]
        self.bounds = self._bounds() if self._fixed_bounds is None else self._fixed_bounds
        count = 1 + max(self.fields, default=0)
        flags = np.zeros((self.planes + 1, count), np.int64) if self.fields else ()
        arrays = self.G, self.active, self.scratch, self.deferred
        counts = self.shared_lower, self.owned
        self.field = Field(self.window, *arrays, *counts, self.bounds, flags, self._motion())
        self._marks: tuple[np.ndarray, ...] = ()

    def _zeros(self, name: str, size: int) -> FloatArray:
        """An array of zeros, by its name: the one there is, if all its users have left zeros."""
        room = self._room.get(name)
        if room is None:
            room = self._room[name] = aligned(size)
        elif len(room) < size:  # further fields: with some to spare
            room = self._room[name] = aligned(size * 5 // 4)
        return room[:size]

    def _motion(self) -> VertexMotion | tuple[()]:
        """Room for the vertices' motion, with what there is of it; () in other scenes."""
        if self._lagrangian is None:
            return ()
        count = 1 + max(self.fields, default=0)
        mask = np.ones(count, bool)
        if self.fields:
            mask[:] = False
            mask[np.array(self.fields)[self._lagrangian]] = True
        motion = VertexMotion(aligned(len(self.G)), mask)
        if self.motion:  # the window has changed
            was = self._stored
            old = self.by_vertex(self.kept.values, was)
            new, now = self.by_vertex(motion.values), self.window
            if old.shape[1] == count:
                low, high = np.maximum(was.lower, now.lower), _common_end(was, now)
                y, z = (
                    [slice(low[d] - each.lower[d], high[d] - each.lower[d]) for each in (was, now)]
                    for d in (1, 2)
                )
                new[:, :, y[1], z[1]] = old[:, :, y[0], z[0]]
        self.motion, self._stored = motion, self.window
        return motion

    @property
    def kept(self) -> VertexMotion:
        """The vertices' motion, in scenes where they keep it."""
        assert isinstance(self.motion, VertexMotion)
        return self.motion

    @property
    def motion_field(self) -> Field:
        """The field with the records of the vertices' motion in place of their sums."""
        return self.field._replace(G=self.kept.values)

    def owned_motion(self) -> tuple[FloatArray, ...]:
        """Motion of the planes that the rank owns, by plane; () where no vertex keeps it."""
        return (self.by_vertex(self.kept.values)[: self.owned],) if self.motion else ()

    def by_vertex(self, values: FloatArray, window: Window | None = None) -> FloatArray:
        """Records of a window as (planes, fields, y, z, numbers), without a copy."""
        window = window or self.window
        size = RECORD * window.extent[1] * window.extent[2]
        return values.reshape(self.planes, window.stride[0] // size, *window.extent[1:], RECORD)

    def clear(self, i: int) -> None:
        """Set a plane to zero."""
        plane = self.window.stride[0]
        self.G[i * plane : (i + 1) * plane] = 0.0

    @property
    def marks(self) -> tuple[np.ndarray, ...]:
        """Constraints of each vertex, as bits; and the mass that they hold, if that matters."""
        if not self._marks:
            size = len(self.G) // RECORD
            self._marks = tuple(np.zeros(size, np.int64) for _ in range(1 + self.weighs))
        return self._marks

    def join_marks(self, axis: int) -> None:
        """Unite the constraints of both copies of the vertices at a seam across y or z."""
        if not self.planes:
            return
        for values, unite in zip(self.marks, UNITE, strict=False):
            marks = values.reshape(self.planes, -1, *self.window.extent[1:])
            inside, beyond = self.copies(marks, axis)
            unite(inside, beyond, out=inside)

    def copies(self, values: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
        """Views on both copies of the vertices at a seam across y or z: inside, and beyond it.

        Parameters
        ----------
        values : (planes, fields, y, z, ...)
            Values at the vertices.
        axis : int
            The direction across the seam; it comes first in the views.
        """
        rows, cells = np.moveaxis(values, axis + 1, 0), self.frame.cells[axis]
        first = self.frame.ghost + cells - self.window.lower[axis]
        beyond = rows[first:]
        return rows[first - cells :][: len(beyond)], beyond

    def _bounds(self) -> tuple[tuple[float, float], ...]:
        """Coordinates within which a particle is certainly in the domain and within `inner_bounds`.

        They are inside by a billionth of a cell and by many times the rounding of coordinates and
        cell numbers of this size.
        """
        bounds = []
        for d, cells in enumerate(self.frame.cells):
            low, high = 0.0, float(cells)
            if d == 0 and self._periodic[0]:  # the layer tells whether it is within
                low, high = -2.0, cells + 2.0
            if d > 0:
                # A support has its first vertex between floor(xi - 1) and floor(xi).
                low = max(low, float(self.inner_bounds[0, d - 1] - self.frame.ghost) + 1.0)
                high = min(high, float(self.inner_bounds[1, d - 1] - self.frame.ghost) + 1.0)
            origin, cell = self.frame.origin[d], self.frame.cell[d]
            least, most = origin + low * cell, origin + high * cell
            eps = np.finfo(float).eps
            margin = (1e-9 + 8.0 * eps * cells) * cell + 8.0 * eps * max(abs(least), abs(most))
            bounds.append((float(least + margin), float(most - margin)))
        return tuple(bounds)
