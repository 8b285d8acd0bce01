"""Ground below grids of heights: volumes against quadrature, files, and what cannot be used."""

import tracemalloc
from time import process_time

import numpy as np
import pytest
from meshes import case, filled

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene.geometry import share
from pgimp.scene.scene import Scene

pytestmark = pytest.mark.slow(60)


def hills(n=9, m=7, low=-0.6, high=1.3, seed=3):
    """Heights by x and y."""
    return np.random.default_rng(seed).uniform(low, high, (n, m))


def bilinear(z, spacing, bottom):
    """Volume of the ground by Simpson's rule in each cell's interpolation."""
    weights, nodes = np.array([1.0, 4.0, 1.0]) / 6.0, np.array([0.0, 0.5, 1.0])
    volume = 0.0
    for i in range(z.shape[0] - 1):
        for j in range(z.shape[1] - 1):
            for a, u in zip(weights, nodes, strict=True):
                for b, v in zip(weights, nodes, strict=True):
                    height = (1 - u) * ((1 - v) * z[i, j] + v * z[i, j + 1])
                    height += u * ((1 - v) * z[i + 1, j] + v * z[i + 1, j + 1])
                    volume += a * b * (height - bottom)
    return volume * spacing[0] * spacing[1]


def esri(path, z, corner, cell, nodata=-9999, key="corner"):
    """Write heights by x and y as ESRI ASCII; nan is nodata."""
    rows = np.where(np.isnan(z), nodata, z).T[::-1]
    head = f"ncols {z.shape[0]}\nnrows {z.shape[1]}\nxll{key} {corner[0]}\nyll{key} {corner[1]}\n"
    head += f"cellsize {cell}\nNODATA_value {nodata}\n"
    path.write_text(head + "\n".join(" ".join(f"{x:.17g}" for x in row) for row in rows) + "\n")


def bordered(z, spacing, first):
    """Nodes and heights to the edges of cells, where the slope of the border goes on."""
    axes = []
    for d, (step, low) in enumerate(zip(spacing, first, strict=True)):
        count = z.shape[d]
        ends = np.array([-0.5, *range(count), count - 0.5])
        axes.append(low + step * ends)
        beyond = np.pad(z, [(1, 1) if k == d else (0, 0) for k in range(2)], "reflect",
                        reflect_type="odd")  # fmt: skip
        z = np.moveaxis(beyond, d, 0)
        z[0], z[-1] = 0.5 * (z[0] + z[1]), 0.5 * (z[-1] + z[-2])
        z = np.moveaxis(z, 0, d)
    return axes, z


def heights(path, **more):
    return {"heights": {"file": str(path), "bottom": -1.5, **more}}


def test_volume_of_an_array(tmp_path):
    """Exact on any lattice, also where the lattice's planes are not the nodes'."""
    z = hills()
    np.save(tmp_path / "z.npy", z)
    nodes = {"origin": [-1.9, -1.7], "spacing": [0.45, 0.55]}
    region = heights(tmp_path / "z.npy", nodes=nodes)
    exact = bilinear(z, nodes["spacing"], -1.5)
    for cell in (0.5, 0.4):
        total, _, number, notes, found = filled(region, cell=cell)
        assert total == pytest.approx(exact, rel=1e-12)
        assert number > 100 and not notes
    low, high = found.bounds()
    np.testing.assert_allclose(low, [-1.9, -1.7, -1.5])
    np.testing.assert_allclose(high, [-1.9 + 8 * 0.45, -1.7 + 6 * 0.55, z.max()])
    at = np.array([[-1.45, -1.15, z[1, 1] + d] for d in (-1e-6, 1e-6)])
    inside = found.contains(at)
    assert inside.tolist() == [True, False]


@pytest.mark.parametrize("key", ["corner", "center"])
def test_an_esri_grid_has_its_heights_at_the_centres_of_cells(tmp_path, key):
    """Its first row is the north; survey's coordinates are moved to the case's."""
    z = hills(5, 6)
    corner = [500_000.0, 4_100_000.0]
    esri(tmp_path / "dem.asc", z, corner, 2.5, key=key)
    half = 1.25 if key == "corner" else 0.0
    move = [-0.2 * (corner[0] + half) - 1.0, -0.2 * (corner[1] + half) - 1.2, 0.3]
    region = heights(tmp_path / "dem.asc", scale=0.2, translate=move)
    model = Case.model_validate(case(region))
    share(model, Serial())
    surface = model.bodies["body"].region.surface
    (x, y), whole = bordered(0.2 * z + 0.3, [0.5, 0.5], [-1.0, -1.2])
    np.testing.assert_allclose(surface.bounds[0], [-1.25, -1.45, -1.5], atol=1e-9)
    np.testing.assert_allclose(surface.bounds[1], [1.25, 1.55, whole.max()], atol=1e-9)
    exact = np.trapezoid(np.trapezoid(whole + 1.5, y, axis=1), x)
    assert surface.volume == pytest.approx(exact, rel=1e-8)
    at = np.array([[-1.0 + 0.5 * 3, -1.2 + 0.5 * 1, 0.2 * z[3, 1] + 0.3]])
    assert surface.distance(at)[0] == pytest.approx(0.0, abs=1e-8)


def test_a_part_is_cut_between_nodes(tmp_path):
    """Of linear heights the part is exact; elsewhere nodata does not matter."""
    x, y = np.meshgrid(np.arange(9.0), np.arange(9.0), indexing="ij")
    z = 0.1 * x - 0.05 * y
    z[0, 0] = np.nan
    esri(tmp_path / "dem.asc", z, [-0.5, -0.5], 1.0)
    part = {"min": [1.25, 1.5], "max": [3.5, 3.0]}
    region = heights(tmp_path / "dem.asc", part=part, translate=[-2.0, -2.0, 0.0])
    region["heights"]["part"] = {"min": [-0.75, -0.5], "max": [1.5, 1.0]}
    total, *_ = filled(region)
    middle = 0.1 * (1.25 + 3.5) / 2 - 0.05 * (1.5 + 3.0) / 2
    assert total == pytest.approx(2.25 * 1.5 * (middle + 1.5), rel=1e-12)


@pytest.mark.parametrize("kind", ["array", "rows", "asc"])
def test_a_profile_in_two_dimensions(tmp_path, kind):
    z = hills(9, 1)[:, 0]
    x = -1.8 + 0.45 * np.arange(9)
    more = {}
    if kind == "array":
        more = {"nodes": {"origin": [-1.8], "spacing": [0.45]}}
        np.save(tmp_path / "z.npy", z)
    elif kind == "rows":
        np.save(tmp_path / "z.npy", np.column_stack([x, z]))
    else:
        esri(tmp_path / "z.asc", z[:, None], [-1.8, 0.0], 0.45, key="center")
        more = {"part": {"min": [-1.8], "max": [1.8]}}  # without half a cell beyond
    path = next(tmp_path.glob("z.*"))
    total, centre, *_ = filled(heights(path, **more), dimension=2)
    assert total == pytest.approx(np.trapezoid(z + 1.5, x), rel=1e-12)
    moments = (z[1:] ** 2 + z[1:] * z[:-1] + z[:-1] ** 2) / 6 - 1.5**2 / 2
    assert centre[1] == pytest.approx(0.45 * moments.sum() / total, rel=1e-10)


def brute(T, points):
    """Distances of points from triangles, sampled densely."""
    u = np.linspace(0.0, 1.0, 25)
    a, b = (each.ravel() for each in np.meshgrid(u, u))
    a, b = a[a + b <= 1.0], b[a + b <= 1.0]
    samples = (
        T[:, :1]
        + a[None, :, None] * (T[:, 1:2] - T[:, :1])
        + b[None, :, None] * (T[:, 2:] - T[:, :1])
    ).reshape(-1, 3)
    return np.array([np.linalg.norm(samples - p, axis=1).min() for p in points])


def test_the_ground_is_closed_by_construction(tmp_path):
    """Sides and bottom too: inside is below the heights, also at nodes and on edges of cells."""
    z = hills(6, 5)
    np.save(tmp_path / "z.npy", z)
    nodes = {"origin": [-1.5, -1.25], "spacing": [0.5, 0.5]}
    region = (
        Case.model_validate(case(heights(tmp_path / "z.npy", nodes=nodes))).bodies["body"].region
    )
    x, y = -1.5 + 0.5 * np.arange(6), -1.25 + 0.5 * np.arange(5)
    rng = np.random.default_rng(5)
    points = rng.uniform([-1.8, -1.6, -1.8], [1.3, 1.1, 1.5], (3000, 3))
    points[:300, 0], points[300:600, 1] = rng.choice(x, 300), rng.choice(y, 300)
    points[600:700, 2] = -1.5
    inner = (points[:, :2] > [x[0], y[0]]).all(axis=1) & (points[:, :2] < [x[-1], y[-1]]).all(
        axis=1
    )
    i = np.clip(((points[:, 0] - x[0]) / 0.5).astype(int), 0, 4)
    j = np.clip(((points[:, 1] - y[0]) / 0.5).astype(int), 0, 3)
    low = np.minimum.reduce([z[i, j], z[i + 1, j], z[i, j + 1], z[i + 1, j + 1]])
    high = np.maximum.reduce([z[i, j], z[i + 1, j], z[i, j + 1], z[i + 1, j + 1]])
    found = region.contains(points)
    assert found[inner & (points[:, 2] < low) & (points[:, 2] > -1.5)].all()
    beyond = ((points[:, :2] < [x[0], y[0]]) | (points[:, :2] > [x[-1], y[-1]])).any(axis=1)
    above = inner & (points[:, 2] > high)
    assert not found[beyond | above | (points[:, 2] < -1.5)].any()
    for axis in range(3):
        assert (np.isfinite(region.crossings(points[:500], axis)).sum(axis=1) % 2 == 0).all()
    some = points[:60]
    near = brute(region.surface.triangles, some)
    np.testing.assert_allclose(np.abs(region.distance(some)), near, atol=0.05)


def sorted_triangles(z, step):
    """Corners of two triangles a cell in NumPy, in the order of their middles: a plain pass."""
    n = np.arange(len(z)) * step
    x = np.stack([*np.meshgrid(n, n, indexing="ij"), z], axis=-1)
    low, high = [x[:-1, :-1], x[1:, :-1], x[1:, 1:]], [x[:-1, :-1], x[1:, 1:], x[:-1, 1:]]
    corners = np.concatenate([np.stack(each, axis=2).reshape(-1, 3, 3) for each in (low, high)])
    return corners[np.lexsort(corners.mean(axis=1).T)]


def test_a_raster_of_a_million_costs_some_passes_over_it(tmp_path):
    """Also its distances: a bottom of long triangles made each of them a search through all.

    Against sorting its triangles in NumPy, by the same clock: 1.3 and 1.1 times; it was 28 times
    and more.
    """
    n = 1000
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    z = 0.1 * np.sin(0.03 * x) * np.cos(0.02 * y)
    np.save(tmp_path / "z.npy", z)
    step = 4.0 / (n - 1)
    nodes = {"origin": [-2.0, -2.0], "spacing": [step, step]}
    small = heights(tmp_path / "z.npy", nodes=nodes, part={"min": [0.0, 0.0], "max": [0.1, 0.1]})
    at = np.random.default_rng(1).uniform([-2.0, -2.0, -1.9], [2.0, 2.0, 1.0], (50_000, 3))
    times = []
    for region in (small, heights(tmp_path / "z.npy", nodes=nodes)):  # the first compiles
        made = Case.model_validate(case(region)).bodies["body"].region
        began = process_time()
        assert made.surface.facets > 0
        read = process_time()
        made.distance(at)
        times.append((read - began, process_time() - read))
    began = process_time()
    assert len(sorted_triangles(z, step)) == 2 * (n - 1) ** 2
    one = process_time() - began
    assert max(times[1]) < 6.0 * one


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
        ({"part": {"min": [0.0, 0.0], "max": [1.0]}}, "part.max"),
    ):
        with pytest.raises(ValueError, match=f"heights.{key}"):
            Case.model_validate(case(heights(tmp_path / "z.npy", **more)))


def test_ground_may_be_rigid(tmp_path):
    """Its distance field is that of the profile; a ball lies on it."""
    x = np.linspace(-2.0, 2.0, 9)
    np.save(tmp_path / "z.npy", np.column_stack([x, 0.25 * x]))
    model = case({"ball": {"center": [0.0, 1.2], "radius": 0.6}}, 2)
    model["bodies"]["ground"] = {"rigid": {}, "region": heights(tmp_path / "z.npy", bottom=-3.0)}
    model["contact"] = [{"bodies": ["body", "ground"]}]
    checked = Case.model_validate(model)
    share(checked, Serial())
    region = checked.rigid_bodies["ground"].region
    line = Scene(checked).interaction.rigid_bodies
    assert line.names == ["ground"]
    up = region.distance(np.array([[0.0, 1.0]]))[0]
    assert up == pytest.approx(1.0 / np.hypot(1.0, 0.25), rel=1e-9)
