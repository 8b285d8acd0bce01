"""The part of the grid that is stored: where it must grow, and where it must not."""

import numpy as np
import pytest

from pgimp.kernels.jit import kernel
from pgimp.kernels.place import first_vertex
from pgimp.parallel.slabs import Slab
from pgimp.shapes.gimp import GimpParameters
from pgimp.shapes.mpm import MpmParameters
from pgimp.solver.grid import MARGIN, Grid
from pgimp.solver.particles import Frame


@kernel
def first_vertices(shape, frame, y, found):
    for i in range(len(y)):
        found[i] = first_vertex(frame, 1, shape.half[1], y[i])


def plane_grid(origin, cell, cells, vertices):
    frame = Frame(
        (0.0, origin), (1.0, cell), (1.0, 1.0 / cell), (4, cells), vertices - 1
    )
    return Grid(frame, vertices, Slab(0, 4 + 2 * vertices, None, None))


def reach(low, high):
    return np.array([[low, 0], [high, 0]])


@pytest.mark.parametrize(("shape", "vertices"), [(MpmParameters((0.0, 0.0)), 2),
                                                 (GimpParameters((0.5, 0.5)), 3)])  # fmt: skip
@pytest.mark.parametrize("origin", [0.0, -3.7, 4.0e6, 1.0e9, -6.2e5])
@pytest.mark.parametrize("cell", [0.1, 1.0, 1.0 / 3.0])
def test_a_particle_within_the_bounds_has_its_support_in_the_window(shape, vertices, origin, cell):
    """Also far from the origin, where coordinates are coarse: Numba checks no index."""
    grid = plane_grid(origin, cell, 2000, vertices)
    for low in range(MARGIN + 3, 1900, 37):
        grid.cover(reach(low, low + 5))
        least, most = grid.bounds[1]
        y = np.array([least, most])
        for _ in range(3):  # the bounds themselves and what lies next to them
            y = np.concatenate([y, np.nextafter(y[-2:], least / 2 + most / 2)])
        found = np.empty(len(y), np.int64)
        first_vertices(shape, grid.frame, y, found)
        assert grid.base[0, 0] <= found.min()
        assert found.max() <= grid.base[1, 0]


def test_only_the_side_that_is_reached_grows():
    grid = plane_grid(0.0, 1.0, 1000, 3)
    grid.cover(reach(100, 110))
    assert grid.base[:, 0].tolist() == [100 - MARGIN, 110 + MARGIN]
    grid.extend(reach(100 - MARGIN, 111 + MARGIN))
    assert grid.base[:, 0].tolist() == [100 - MARGIN, 111 + 2 * MARGIN]
    grid.extend(reach(5, 120))
    assert grid.base[:, 0].tolist() == [5 - MARGIN, 120 + MARGIN]


def test_the_window_ends_with_the_grid():
    grid = plane_grid(0.0, 1.0, 10, 3)
    grid.cover(reach(0, 12))
    assert grid.base[:, 0].tolist() == [0, 12]
    assert grid.window.extent[1] == grid.frame.vertices[1] == 15
