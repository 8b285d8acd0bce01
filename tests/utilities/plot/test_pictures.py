"""``pgimp plot``: pictures of frames: place, size and colour of particles, what is in front."""

import numpy as np
import pytest
from plotted import hdf5, table

from pgimp.io.results.reader import Frame
from pgimp.utilities.plot import picture, visible
from pgimp.utilities.plot.camera import camera
from pgimp.utilities.plot.look import Look
from pgimp.utilities.plot.quantity import Quantity, quantity
from pgimp.utilities.plot.runs import open_runs, snapshots
from pgimp.utilities.plot.selection import Selection

RUNS = ("plates", "block")


def drawn_frame(runs, name, field, view=None, limits=None, place=None, number=-1):
    """The picture of a frame as pixels; pixels of points in the picture's plane; the map."""
    from matplotlib import colormaps, rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from pgimp.utilities.plot.style import STYLE

    (snapshot,) = snapshots(open_runs([str(runs / name)]), [number], [])
    dimension = snapshot.shown.dimension
    what = quantity(field, snapshot.frame, dimension)
    eye = camera(view, dimension, None)
    with rc_context(STYLE):
        chosen = Selection((), place or {})
        figure, _, _ = picture.picture([snapshot], [what], chosen, eye, Look(limits))
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[::-1, :, :3]
    axis = figure.axes[0]

    def at(points):
        column, row = np.floor(axis.transData.transform(points)).astype(int).T
        return pixels[row, column]

    def colours(values):
        norm = figure.axes[-1]._colorbar.norm
        return np.round(255.0 * colormaps["viridis"](norm(values))[:, :3])

    (left, low), (right, high) = axis.get_window_extent().get_points().astype(int)
    scale = np.diff(axis.transData.transform([[0.0, 0.0], [1.0, 0.0]])[:, 0])[0]
    return at, colours, pixels[low + 2 : high - 2, left + 2 : right - 2], scale


def test_particles_have_their_place_size_and_colour(runs):
    frame = hdf5(runs, "plates.out")
    at, colours, inside, scale = drawn_frame(runs, "plates.out", "von-mises")
    difference = at(frame["position"][:, :2]) - colours(frame["von-mises"])
    assert np.abs(difference).max() <= 2
    assert len(np.unique(at(frame["position"][:, :2]), axis=0)) > 10
    coloured = np.count_nonzero((inside < 250).any(axis=2))
    area = frame["volume"].sum() * scale**2
    assert coloured == pytest.approx(area, rel=0.03)
    assert (inside[-3:, :3] == 255).all()


@pytest.mark.parametrize(("view", "axis", "front"), [("y-min", 1, -1), ("x-max", 0, 1)])
@pytest.mark.parametrize("few", [10**9, 0])
def test_the_foremost_are_seen(runs, monkeypatch, view, axis, front, few):
    monkeypatch.setattr(visible, "FEW", few)
    frame = hdf5(runs, "block.out")
    across = front * frame["position"][:, axis]
    # Each row of particles across the picture, by the numbers of the lattice.
    first = hdf5(runs, "block.out", 0)["position"]
    rows = {}
    for number, row in enumerate(map(tuple, np.delete(first, axis, axis=1).round(6))):
        if row not in rows or across[number] > across[rows[row]]:
            rows[row] = number
    nearest = np.array(list(rows.values()))
    at, colours, _, _ = drawn_frame(runs, "block.out", "id", view)
    seen = at(np.delete(frame["position"][nearest], axis, axis=1))
    expected = colours(nearest)
    assert (np.abs(seen - expected).max(axis=1) <= 3).mean() > 0.99
    behind = colours(np.argsort(across)[: len(nearest)])
    assert np.abs(behind - expected).max() > 20


def test_many_particles_are_thinned_to_those_in_front(runs, monkeypatch):
    """By spots as brute force finds them, in blocks of any size; and the picture is the same."""
    frame = Frame(sorted((runs / "block.out" / "frames").glob("*.h5"))[-1])
    eye = camera("corner", 3, None)
    everything = Selection()
    what = quantity("id", frame, 3)
    inside = visible.extent(frame, everything, eye)
    monkeypatch.setattr(visible, "FEW", 0)
    monkeypatch.setattr(visible, "SPOTS", 20)
    monkeypatch.setattr("pgimp.utilities.plot.selection._BLOCK_ROWS", 37)
    seen, total = visible.visible(frame, everything, what, eye, inside)
    place = eye.project(frame["position"])
    spot = (inside[1] - inside[0]).max() / 20
    spots = [tuple(spot) for spot in np.floor((place[:, :2] - inside[0]) / spot).astype(int)]
    best = {}
    for number, spot in enumerate(spots):
        if spot not in best or place[number, 2] >= place[best[spot], 2]:
            best[spot] = number
    assert sorted(seen.id) == sorted(best.values())
    assert len(best) < total == len(frame)
    monkeypatch.setattr(visible, "SPOTS", 400)
    _, _, thinned, _ = drawn_frame(runs, "block.out", "id")
    monkeypatch.setattr(visible, "FEW", 10**9)
    _, _, whole, _ = drawn_frame(runs, "block.out", "id")
    same = (np.abs(thinned.astype(int) - whole) < 16).all(axis=2)
    assert same.mean() > 0.97


def test_thinning_is_said(plot, monkeypatch, tmp_path):
    monkeypatch.setattr(visible, "FEW", 0)
    monkeypatch.setattr(visible, "SPOTS", 10)
    status, said, _ = plot("block.out", "--camera=-1,-2,1.5", "--csv", "a.csv")
    drawn = len(table(tmp_path / "a.csv")["id"])
    assert status == 0
    assert f"{drawn:,} of 192 particles drawn" in said


def test_faces_of_boxes_are_told_apart(runs):
    """In one colour, lightest above; the default view shows the faces at x-max, y-min and z-max."""
    x = hdf5(runs, "block.out", 0)["position"]
    low, high = x.min(axis=0), x.max(axis=0)
    middle = 0.5 * (low + high)
    points = np.tile(middle, (3, 1))
    points[0, 0], points[1, 1], points[2, 2] = high[0], low[1], high[2]
    at, colours, _, _ = drawn_frame(runs, "block.out", "body", number=0)
    seen = at(camera(None, 3, None).project(points)[:, :2]).astype(int)
    mass_cutoff = colours(np.zeros(1))[0]
    assert np.abs(seen[2] - mass_cutoff).max() <= 2
    lightness = seen.sum(axis=1) / mass_cutoff.sum()
    assert 0.7 < lightness[0] < lightness[1] - 0.05 < lightness[2] - 0.1


def test_values_that_are_no_numbers_are_grey(runs, monkeypatch):
    """With many particles too."""
    values = [np.arange(192.0), np.full(192, np.nan)]
    for few in (10**9, 0):
        monkeypatch.setattr(visible, "FEW", few)
        for there, grey in zip(values, (False, True), strict=True):
            monkeypatch.setattr(Quantity, "rows", lambda *_, there=there: there)
            _, _, inside, _ = drawn_frame(runs, "block.out", "id", "y-min")
            assert (inside == 200).all(axis=2).any() == grey


def test_scale_of_colours_leaves_a_few_outliers_out():
    values = np.append(np.linspace(0.0, 1.0, 1000), 50.0)
    low, high, beyond = picture.scale(values, None)
    assert low == 0.0
    assert 0.99 < high < 1.0
    assert beyond == "max"
    assert picture.scale(np.linspace(-3, 2, 50), None) == (-3.0, 2.0, "neither")
    assert picture.scale(np.zeros(3), None) == (0.0, 1.0, "neither")
    assert picture.scale(np.array([1.0, 5.0]), (2.0, 3.0)) == (2.0, 3.0, "both")
