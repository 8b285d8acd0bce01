"""Files of heights that cannot be used: refused in words, and soon."""

import tracemalloc
from time import process_time

import numpy as np
import pytest
from height_maps import heights, hills
from meshes import case

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene.geometry import share

pytestmark = pytest.mark.slow(40)


def test_a_file_is_read_by_rows_and_refused_by_its_header(tmp_path):
    """Neither needs the memory of the whole."""
    path = tmp_path / "z.asc"
    with path.open("wb") as file:
        file.write(b"ncols 4000\nnrows 3000\nxllcorner -2\nyllcorner -2\ncellsize 0.001\n")
        for row in range(3000):
            file.write(b"%d " % (row % 7) * 4000 + b"\n")
    part = {"min": [-1.5, -1.2], "max": [-1.49, -1.19]}
    began = process_time()
    refused(heights(path))
    since = process_time()
    assert len(path.read_bytes().split()) == 12_000_010
    assert since - began < 0.5 * (process_time() - since)
    tracemalloc.start()
    text = refused(heights(path))
    assert "has 11,965,025 nodes in this part, more than 2,000,000; take a smaller part" in text
    region = heights(path, part=part, bottom=-7.0)
    surface = Case.model_validate(case(region)).bodies["body"].region.surface
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 120e6, most  # of text alone 24 MB, as words 800 MB
    assert surface.bounds[0] == (-1.5, -1.2, -7.0)
    rows = 2999 - np.floor((np.array([-1.2, -1.19]) + 2.0) / 0.001 - 0.5)
    assert surface.bounds[1][2] == max(row % 7 for row in range(int(rows[1]) - 1, int(rows[0]) + 1))


def refused(region, dimension=3):
    with pytest.raises(CaseError) as error:
        model = Case.model_validate(case(region, dimension))
        share(model, Serial())
    return str(error.value)


def test_a_node_without_height_next_to_an_end_of_a_part_is_named_as_in_the_file(tmp_path):
    """The end of the part lies between nodes, the second of which has none."""
    z = np.array([2.0, np.nan, 1.0, 1.0, 1.0, np.nan])
    np.save(tmp_path / "z.npy", z)
    nodes = {"origin": [-1.0], "spacing": [0.4]}
    text = refused(heights(tmp_path / "z.npy", nodes=nodes, part={"min": [-0.5], "max": [0.2]}), 2)
    assert "no height at 1 of 3 nodes, first at x = -0.6: fill them, or " in text
    assert text.endswith("take a part without them (part: {min: .., max: ..})")
    text = refused(heights(tmp_path / "z.npy", nodes=nodes, part={"min": [-0.1], "max": [0.9]}), 2)
    assert "no height at 1 of 4 nodes, first at x = 1:" in text
    region = heights(tmp_path / "z.npy", nodes=nodes, part={"min": [-0.1], "max": [0.5]})
    share(Case.model_validate(case(region, 2)), Serial())


def test_what_heights_cannot_be(tmp_path):
    z = hills(5, 4)
    z[2, 1] = np.nan
    np.save(tmp_path / "z.npy", z)
    nodes = {"origin": [-1.0, -1.0], "spacing": [0.5, 0.5]}
    path = tmp_path / "z.npy"
    text = refused(heights(path, nodes=nodes))
    assert "bodies.body.region: the heights" in text
    assert "no height at 1 of 20 nodes, first at x = 0, y = -0.5" in text
    text = refused(heights(path, nodes=nodes, part={"min": [-1.0, 0.0], "max": [1.5, 0.5]}))
    assert "covers x from -1 to 1 (its nodes, of an .asc the edges of its cells)" in text
    assert "goes from -1 to 1.5" in text
    assert "say nodes" in refused(heights(path))
    assert "dimensions, expected 1" in refused(
        heights(path, nodes={"origin": [0.0], "spacing": [1.0]}), 2
    )
    np.save(path, np.full((3, 3), -2.0))
    assert "at or below the bottom, -1.5, at 9 of 9 nodes" in refused(heights(path, nodes=nodes))
    np.save(path, hills(9, 9))
    assert "beyond the domain" in refused(heights(path, nodes=nodes))
    grid = tmp_path / "z.asc"
    grid.write_text("ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4 5\n")
    assert "has 5 heights, but ncols x nrows are 6" in refused(heights(grid))
    grid.write_text("nrows 2\n1 2 3 4 5\n")
    assert "has no ncols" in refused(heights(grid))
    grid.write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 x 4\n")
    assert "a height that is no number" in refused(heights(grid))
    grid.write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 1_0 4\n")
    assert "a height that is no number: '1_0'" in refused(heights(grid))
    grid.write_text("ncols 2\nnrows 2\nxllcorner 1_0\nyllcorner 0\ncellsize 1\n1 2 3 4\n")
    assert "has xllcorner '1_0', which is no number" in refused(heights(grid))
    assert "neither .asc" in refused(heights(tmp_path / "z.tif")) or "cannot read" in refused(
        heights(tmp_path / "z.tif")
    )
    path.write_bytes(b"nothing")
    assert "is no array of NumPy" in refused(heights(path, nodes=nodes))


@pytest.mark.parametrize(
    ("head", "text"),
    [
        ("ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize inf", "no cellsize above zero"),
        ("ncols 3\nnrows 1\nxllcorner nan\nyllcorner 0\ncellsize 1", "not finite or not apart"),
        ("ncols 3\nnrows 1\nxllcorner 1e17\nyllcorner 0\ncellsize 1", "not finite or not apart"),
        ("ncols 1e300\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1", "above a billion"),
    ],
)
def test_places_that_cannot_be(tmp_path, head, text):
    grid = tmp_path / "z.asc"
    grid.write_text(f"\ufeff{head}\n0 0 0\n", encoding="utf-8")  # with a mark of Windows
    assert text in refused(heights(grid), 2)


def test_damaged_headers_of_arrays(tmp_path):
    """One that NumPy fails to parse, and one of more numbers than memory holds."""
    path, nodes = tmp_path / "z.npy", {"origin": [0.0], "spacing": [1.0]}
    path.write_bytes(b"\x93NUMPY\x01\x00\x20\x00{'descr': '<f8', 'shape': ((((  \n")
    assert "is no array of NumPy" in refused(heights(path, nodes=nodes), 2)
    with path.open("wb") as file:
        large = {"descr": "<f8", "fortran_order": False, "shape": (10**14,)}
        np.lib.format.write_array_header_1_0(file, large)
    assert "is no array of NumPy" in refused(heights(path, nodes=nodes), 2)
    assert refused(heights(tmp_path / "no.npy", nodes=nodes), 2).count("no.npy") == 1


def test_keys_that_do_not_fit_the_dimensions(tmp_path):
    np.save(tmp_path / "z.npy", hills())
    for more, key in (
        ({"nodes": {"origin": [0.0], "spacing": [1.0, 1.0]}}, "nodes.origin"),
        ({"window": {"min": [0.0, 0.0], "max": [1.0]}}, "window.max"),
    ):
        with pytest.raises(ValueError, match=f"heights.{key}"):
            Case.model_validate(case(heights(tmp_path / "z.npy", **more)))
