"""A rank's particles in canonical order, as they arrive, leave and change layers."""

from math import prod

import numpy as np

from pgimp.decomposition.pages import give_back
from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.particles import Columns, IntArray, Particles
from pgimp.kernels.lagrangian.displace import Displaced
from pgimp.kernels.order.layer_changes import sort_rows
from pgimp.kernels.order.order import grow_vertex_bounds, locate, merge


def with_capacity(array: np.ndarray, size: int, used: int = 0) -> np.ndarray:
    """Return the array, or a longer one with its `used` first numbers if it is too short."""
    if len(array) >= size:
        return array
    longer = np.empty(size + size // 8 + 16, array.dtype)
    longer[:used] = array[:used]
    return longer


def _nothing(near: np.ndarray | None = None) -> None:
    pass


class Population:
    """Particles of the layers `first` to ``first + layers - 1``.

    The rows of `columns` do not move between two re-sorts. `order` lists the living ones in
    canonical order (current layer, cell at the last re-sort, id). A particle that changes its layer
    only moves in that list; the row of a leaving particle is a hole until the next re-sort.

    Parameters
    ----------
    particles, count
        The rows, of which the first `count` are alive.
    slab : Slab
        The layers.
    start : (layers + 1,) int64, optional
        Beginning of each layer, for rows in canonical order by their cells; without it they are
        sorted by their positions.

    Attributes
    ----------
    columns : Particles
        Structure of arrays; where bodies keep their motion at vertices, some may be out of date.
    order : (count,) int32
        Rows in canonical order.
    start : (layers + 1,) int64
        Beginning of each layer in `order`.
    """

    def __init__(
        self, particles: Particles, count: int, shape, frame: Frame, slab, start=None
    ) -> None:
        self.columns = particles
        #: Whether columns lag behind the vertices' motion, and the function that updates them.
        self.outdated, self.update = False, _nothing
        #: Whether these columns have no memory meanwhile, see `outdate`.
        self.released = False
        self.shape = shape
        self.frame = frame
        self.first, self.layers = slab.first, slab.layers
        self.order = np.arange(count, dtype=np.int32)
        self._spare = np.empty_like(self.order)
        self.start = np.zeros(self.layers + 1, np.int64)
        self._spare_start = np.zeros_like(self.start)
        self._used = count
        # Rows: unused ones, and rows freed in this step; with space for more.
        self._holes, self._holes_count = np.empty(0, np.int32), 0
        self._left, self._left_count = np.empty(0, np.int32), 0
        self._offsets = np.empty(0, np.int32)
        self._scratch = np.empty(0)
        self._layout: tuple[Particles, Columns] | None = None
        self._call = Bound()
        if start is None:
            self.sort()
        else:
            self.start[:] = start

    def up_to_date(self) -> Particles:
        """Return the columns, updated where they lag behind the vertices' motion."""
        if self.outdated:
            self.outdated = self.released = False
            self.update()
        return self.columns

    def replace(self, particles: Particles) -> None:
        """Take other columns, of the same particles."""
        self.columns, self.released = particles, False

    def outdate(self, all_displaced: bool) -> None:
        """Note that the vertices have moved in a step, so that columns lag behind.

        Columns for which nothing has asked since the step before give their memory back, until
        something asks for `up_to_date`. So scenes that ask in each step keep them.

        Parameters
        ----------
        all_displaced : bool
            Whether `update` sets the columns of `Displaced` of all particles: the old values are of
            no use.
        """
        if self.outdated and all_displaced and not self.released:
            self.released, self._scratch = True, np.empty(0)
            for name in Displaced._fields:
                give_back(getattr(self.columns, name))
        self.outdated = True

    @property
    def changed(self) -> np.ndarray:
        """Scratch for as many rows as particles, between two changes of the order."""
        return self._spare

    def layout(self) -> Columns:
        """Return `Particles.columns`, kept until the arrays change."""
        if self._layout is None or self._layout[0] is not self.columns:
            self._layout = (self.columns, self.columns.columns())
        return self._layout[1]

    @property
    def ordered(self) -> Order:
        """Rows and beginnings of the layers, for kernels."""
        return Order(self.order, self.start)

    def sort(self) -> None:
        """Sort the rows themselves by (layer, cell, id), closing the holes.

        Parts of cells come before all others: what steps take one by one is then not scattered.
        """
        p, rows = self.columns, self.order
        locate(self.shape, self.frame, p, rows, self.frame.vertices)
        rows = rows[self._sorting(p.cell[rows], p.id[rows])]
        edges = np.arange(self.first, self.first + self.layers + 1)
        self.start[:] = np.searchsorted(p.layer[rows], edges)
        places = np.arange(len(rows))
        if hasattr(self.shape, "products") and len(rows):
            whole = p.V0[rows] > (1.0 - 1e-9) * p.V0[rows].max()
            places = np.argsort(whole, kind="stable")
        for array in p:
            if array.size:
                self._permute(array, rows[places])
        self.order[places] = np.arange(len(rows))
        self._used, self._holes_count, self._left_count = len(rows), 0, 0
        self.released = False

    def _permute(self, array: np.ndarray, rows: np.ndarray) -> None:
        """Move the given rows of an array to its beginning, in their order."""
        size = len(rows) * prod(array.shape[1:])
        scratch = self.scratch(size, max(each.size for each in self.columns))
        taken = scratch.view(array.dtype)[:size].reshape(len(rows), *array.shape[1:])
        np.take(array, rows, axis=0, out=taken, mode="clip")
        array[: len(rows)] = taken

    def scratch(self, size: int, most: int = 0) -> np.ndarray:
        """Return memory for so many numbers, with room for `most`: kept, as pages cost time."""
        if len(self._scratch) < size:
            self._scratch = np.empty(max(size, most))
        return self._scratch

    @staticmethod
    def _sorting(cell: IntArray, number: IntArray) -> IntArray:
        """Permutation that sorts by (cell, number); both arrays are overwritten."""
        if not len(cell):
            return np.arange(0)
        cell -= cell.min()
        numbers = int(number.max()) + 1
        if (int(cell.max()) + 1) * numbers >= 2**63:
            return np.lexsort((number, cell))
        # Both in one key: several times faster than sorting by two.
        cell *= numbers
        cell += number
        return np.argsort(cell)

    def vertex_bounds(self) -> np.ndarray:
        """First vertices of the supports, (least, greatest; y, z)."""
        bounds = np.array([[2**62] * 2, [-(2**62)] * 2])
        grow_vertex_bounds(self.shape, self.frame, self.columns, self.order, bounds)
        return bounds

    def free_later(self, rows: np.ndarray) -> None:
        """Free the rows of particles that have left, to another rank or for good, later.

        `restore_order` frees them: it finds offsets by the keys of the old order's rows.
        """
        count = self._left_count + len(rows)
        self._left = with_capacity(self._left, count, self._left_count)
        self._left[self._left_count : count] = rows
        self._left_count = count

    def free(self, rows: np.ndarray) -> None:
        """Free rows between two steps: newcomers may have them at once.

        They stay in the old order until `set_layers`.
        """
        count = self._holes_count + len(rows)
        self._holes = with_capacity(self._holes, count, self._holes_count)
        self._holes[self._holes_count : count] = rows
        self._holes_count = count

    def set_layers(self, slab, order: np.ndarray, start: IntArray) -> None:
        """Replace the layers by the layers of `slab`, with `order` as rows in canonical order."""
        self.first, self.layers = slab.first, slab.layers
        self.order, self._spare = order, np.empty_like(order)
        self.start, self._spare_start = start, np.empty_like(start)

    def insert(self, count: int, rows: np.ndarray | None = None) -> np.ndarray:
        """Rows for `count` newcomers: holes first, then new ones; in `rows` if that is given."""
        if self._used + count - self._holes_count > self.columns.capacity:
            self._grow(max(count, self.columns.capacity // 8))
        rows = np.empty(count, np.int32) if rows is None else rows
        reused = min(count, self._holes_count)
        self._holes_count -= reused
        rows[:reused] = self._holes[self._holes_count : self._holes_count + reused]
        rows[reused:] = np.arange(self._used, self._used + count - reused)
        self._used += count - reused
        return rows

    def _grow(self, rows: int) -> None:
        arrays: list[np.ndarray] = list(self.columns)
        self._layout = None
        del self.columns  # so that no more than one array is there twice
        for i, array in enumerate(arrays):
            arrays[i] = np.zeros((len(array) + rows, *array.shape[1:]), array.dtype)
            arrays[i][: len(array)] = array
        self.replace(Particles._make(arrays))

    def restore_order(self, left: np.ndarray, arrivals: np.ndarray) -> None:
        """Restore the canonical order.

        Parameters
        ----------
        left : (k,) int32
            Offsets in `order` of the particles that have left their layer, ascending.
        arrivals : (l,) int32
            Rows of the particles that have entered a layer; sorted here.
        """
        p = self.columns
        self._offsets = with_capacity(self._offsets, max(len(left), len(arrivals)))
        self._call(sort_rows, p.layer, p.cell, p.id, arrivals, self._offsets)
        offsets = self._offsets[: len(left)]
        offsets[:] = left  # its memory may overlap the new order's
        count = len(self.order) - len(left) + len(arrivals)
        self._spare = with_capacity(self._spare, count)
        self._call(
            merge, p, self.order, self.start, offsets, self.first, arrivals, self._spare,
            self._spare_start,
        )  # fmt: skip
        # The spare array is long enough for all particles, too, see `changed`.
        old, self.order = self._whole(self.order), self._spare[:count]
        self._spare = with_capacity(old, count)
        self.start, self._spare_start = self._spare_start, self.start
        if self._left_count:
            self.free(self._left[: self._left_count])
            self._left_count = 0

    @staticmethod
    def _whole(order: np.ndarray) -> np.ndarray:
        """The array that begins with `order`."""
        return order if order.base is None else order.base
