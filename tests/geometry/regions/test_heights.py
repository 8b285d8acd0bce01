"""Ground below grids of heights: volumes against quadrature, files, and what cannot be used."""

from time import process_time

import numpy as np
import pytest
from height_maps import heights, hills
from meshes import case, filled

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.scene.geometry import share
from pgimp.scene.scene import Scene


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
