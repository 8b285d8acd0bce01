"""The part of the grid that is stored: where it must grow, and where it must not."""

import numpy as np
import pytest

from pgimp.decomposition.grid import LAG, MARGIN, Grid
from pgimp.decomposition.slabs import Slab
from pgimp.jit.kernel import kernel
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.transfer.first_vertex import first_vertex
from pgimp.physics.shapes.gimp import GimpParameters
from pgimp.physics.shapes.mpm import MpmParameters


@kernel
def first_vertices(shape, frame, y, found):
    for i in range(len(y)):
        found[i] = first_vertex(frame, 1, shape.half[1], y[i])


def plane_grid(origin, cell, cells, vertices, lag=0):
    frame = Frame((0.0, origin), (1.0, cell), (1.0, 1.0 / cell), (4, cells), vertices - 1)
    return Grid(frame, vertices, Slab(0, 4 + 2 * vertices, None, None), lag)


def bounds(low, high):
    return np.array([[low, 0], [high, 0]])


@pytest.mark.parametrize(("shape", "vertices"), [(MpmParameters((0.0, 0.0)), 2),
                                                 (GimpParameters((0.5, 0.5)), 3)])  # fmt: skip
@pytest.mark.parametrize("origin", [0.0, -3.7, 4.0e6, 1.0e9, -6.2e5])
@pytest.mark.parametrize("cell", [0.1, 1.0, 1.0 / 3.0])
def test_a_particle_within_the_bounds_has_its_support_in_the_window(shape, vertices, origin, cell):
    """Also far from the origin, where coordinates are coarse: Numba checks no index."""
    grid = plane_grid(origin, cell, 2000, vertices)
    for low in range(MARGIN + 3, 1900, 37):
        grid.cover(bounds(low, low + 5))
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
    grid.cover(bounds(100, 110))
    assert grid.base[:, 0].tolist() == [100 - MARGIN, 110 + MARGIN]
    grid.extend(bounds(100 - MARGIN, 111 + MARGIN))
    assert grid.base[:, 0].tolist() == [100 - MARGIN, 111 + 2 * MARGIN]
    grid.extend(bounds(5, 120))
    assert grid.base[:, 0].tolist() == [5 - MARGIN, 120 + MARGIN]


def test_the_window_ends_with_the_grid():
    grid = plane_grid(0.0, 1.0, 10, 3)
    grid.cover(bounds(0, 12))
    assert grid.base[:, 0].tolist() == [0, 12]
    assert grid.window.extent[1] == grid.frame.vertices[1] == 15


@pytest.mark.parametrize("cells", [1, 4, 10, 200])
def test_what_is_known_a_step_late_is_in_the_window_all_the_same(cells):
    """In a step a particle moves by up to a cell, and its support may become as large as can be."""
    random = np.random.default_rng(cells)
    grid = plane_grid(0.0, 1.0, cells, 3, LAG)
    last = grid.frame.vertices[1] - 3
    y = random.uniform(0.0, cells)
    grid.cover(bounds(*2 * [int(y) + grid.frame.ghost]))
    mine, reported, grown, drift = grid.inner_bounds.copy(), None, 0, 1.0
    for _ in range(2000):
        drift *= -1.0 if random.random() < 0.01 else 1.0
        y = min(max(0.0, y + random.choice([drift, random.uniform(-1.0, 1.0)])), float(cells))
        first = int(np.floor(y - random.choice([0.0, 0.5, 1.0]))) + grid.frame.ghost
        low, high = grid.bounds[1]
        if not low <= y <= high:
            mine[:, 0] = min(mine[0, 0], first), max(mine[1, 0], first)
        if reported is not None and not grid.covers(reported):
            grid.extend(reported)  # what was said after the step before
            grown += 1
        reported = mine.copy()
        assert grid.base[0, 0] <= first <= grid.base[1, 0]
    assert grown > 1 or cells < 200
    assert grid.base[0, 0] >= 0 and grid.base[1, 0] <= last
