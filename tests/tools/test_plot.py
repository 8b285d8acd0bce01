"""``pgimp plot``: what it draws is what the frames and the history hold."""

import csv
import io
import json
import os
import re
import shutil
import sys
import xml.etree.ElementTree as ElementTree
import zlib
from itertools import pairwise

import h5py
import numpy as np
import pytest
from processes import run as run_program
from scenes import box, scene, write_case

from pgimp import cli
from pgimp.io.results.reader import Frame
from pgimp.tools.plot import picture, visible
from pgimp.tools.plot.camera import camera
from pgimp.tools.plot.quantity import Quantity, quantity
from pgimp.tools.plot.runs import open_runs, snapshots
from pgimp.tools.plot.selection import Selection
from pgimp.tools.plot.style import log_ticks
from pgimp.tools.plot.units import kind_of_column, kind_of_field, unit

FIELDS = ["velocity", "stress", "pressure", "von-mises"]


def make(folder, name, dimension, fields=FIELDS, **parts):
    """Run a small case in a folder."""
    parts = {
        "output": {"every": 0.05, "fields": fields},
        "history": {"every": {"steps": 1}},
    } | parts
    write_case(folder / f"{name}.yaml", scene(dimension, end=0.1, **parts))
    assert (
        cli.main([str(folder / f"{name}.yaml"), "-o", str(folder / f"{name}.out"), "--quiet"]) == 0
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A bar that is pulled, two plates of which one falls, the same with other fields, a block."""
    folder = tmp_path_factory.mktemp("plot")
    held = {"box": {"min": [1], "max": [3]}}, {"box": {"min": [5], "max": [7]}}
    pull = {"table": [[0.0, 0.0], [0.06, 0.3], [0.1, 0.0]]}
    ends = {"wall": (held[0], 0.0), "grip": (held[1], pull)}
    constraints = {
        name: {"body": "body", "region": region, "velocity": [velocity]}
        for name, (region, velocity) in ends.items()
    }
    probes = {
        "tip": {"body": "body", "at": [5.8]},
        "slow": {"body": "body", "at": [4], "every": {"steps": 3}},
        "place": {"place": [4]},
    }
    bar = {"constraints": constraints, "probes": probes, "history": {"every": {"steps": 2}}}
    make(folder, "bar", 1, body=box([2], [6], [0.5]), units="mm, t, s", **bar)
    plates = {"low": box([1, 1], [4, 3], [0.3, -0.2]), "high": box([4.5, 4], [7, 7])}
    sides = {"y-min": "separating"}
    make(folder, "plates", 2, body=plates, gravity=[0, -9], units="m, kg, s", boundaries=sides)
    make(folder, "other", 2, ["stress"], body=plates, gravity=[0, -5], units="m, kg, s")
    make(folder, "block", 3, body=box([2, 2, 2], [6, 5, 4], [0.2, 0.1, 0.3]), gravity=[0, 0, -9])
    return folder


@pytest.fixture
def plot(runs, tmp_path, monkeypatch, capsys):
    """``plot("bar.out", ...)`` in a folder of its own: status, output and errors."""
    for path in runs.iterdir():
        (tmp_path / path.name).symlink_to(path)
    monkeypatch.chdir(tmp_path)

    def call(*words):
        status = cli.main(["plot", *map(str, words)])
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        return status, said.out, said.err

    return call


def table(path):
    """A CSV as columns of text by name."""
    rows = list(csv.reader(path.read_text().splitlines()))
    return dict(zip(rows[0], zip(*rows[1:], strict=True), strict=True))


def numbers(columns, name):
    return np.array(columns[name], dtype=float)


def hdf5(runs, name, number=-1):
    """The fields of a frame, by h5py alone."""
    path = sorted((runs / name / "frames").glob("particles-*.h5"))[number]
    with h5py.File(path) as file:
        return {key: file[key][:] for key in file}


def history(runs, name):
    return np.genfromtxt(runs / name / "history.csv", delimiter=",", names=True, deletechars="")


def test_history_of_two_runs(runs, plot, tmp_path):
    columns = "kinetic-energy,body.low.centre-y"
    status, said, _ = plot("plates.out", "other.out", "--columns", columns, "--csv", "drawn.csv")
    assert status == 0
    assert "wrote plates-other-history.png and drawn.csv" in said
    drawn = table(tmp_path / "drawn.csv")
    assert list(drawn) == ["run", "time", "kinetic-energy", "body.low.centre-y"]
    for name in ("plates", "other"):
        mine = np.array(drawn["run"]) == name
        there = history(runs, f"{name}.out")
        assert mine.sum() == len(there) > 5
        for column in list(drawn)[1:]:
            np.testing.assert_array_equal(numbers(drawn, column)[mine], there[column])


def test_history_columns_by_default_and_by_pattern(plot, tmp_path):
    assert plot("plates.out", "--csv", "a.csv")[0] == 0
    there = list(table(tmp_path / "a.csv"))
    assert there[:4] == ["run", "time", "kinetic-energy", "strain-energy"]
    assert "external-work" in there
    assert plot("plates.out", "--columns", "body.*.centre-?", "--x", "step", "-o", "b.csv")[0] == 0
    centres = [f"body.{body}.centre-{axis}" for body in ("low", "high") for axis in "xy"]
    assert list(table(tmp_path / "b.csv")) == ["run", "step", *centres]


def drawn_and_files(runs, plot, tmp_path, *words):
    """The table of a figure of bar.out, its columns, the history and the probes, all by step."""
    status, said, _ = plot("bar.out", *words, "-o", "a.csv")
    assert status == 0
    names = ("history", "probes/tip", "probes/slow")
    files = [
        np.genfromtxt(runs / "bar.out" / f"{name}.csv", delimiter=",", names=True, deletechars="")
        for name in names
    ]
    return table(tmp_path / "a.csv"), files, said


def test_probes_beside_the_history(runs, plot, tmp_path):
    words = ("--probe", "tip", "--columns", "displacement-x,strain-energy")
    drawn, (history, tip, _), said = drawn_and_files(runs, plot, tmp_path, *words)
    assert list(drawn) == ["run", "probe", "time", "displacement-x", "strain-energy"]
    assert set(drawn["probe"]) == {"tip"}
    assert len(history) > 4 and tip["displacement-x"].max() > 0.0
    np.testing.assert_array_equal(numbers(drawn, "displacement-x"), tip["displacement-x"])
    np.testing.assert_array_equal(numbers(drawn, "strain-energy"), history["strain-energy"])
    assert "left out" not in said

    words = ("--probe", "slow", "--x", "displacement.grip-x", "--y", "displacement-x")
    drawn, (history, _, slow), said = drawn_and_files(runs, plot, tmp_path, *words)
    both = sorted({*history["step"]} & {*slow["step"]})
    assert 2 <= len(both) < min(len(history), len(slow))
    for name, file in (("displacement.grip-x", history), ("displacement-x", slow)):
        values = [file[name][list(file["step"]).index(step)] for step in both]
        np.testing.assert_array_equal(numbers(drawn, name), values)
    assert f"{max(len(history), len(slow)) - len(both)} lines left out" in said

    words = ("--probe", "tip,slow", "--columns", "velocity-*")
    drawn, (_, tip, slow), _ = drawn_and_files(runs, plot, tmp_path, *words)
    expected = np.concatenate([tip["velocity-x"], slow["velocity-x"]])
    np.testing.assert_array_equal(numbers(drawn, "velocity-x"), expected)
    assert drawn["probe"] == ("tip",) * len(tip) + ("slow",) * len(slow)
    assert plot("bar.out", "--probe", "tip,slow")[0] == 0
    assert (tmp_path / "bar-tip-slow.png").exists()
    assert plot("bar.out", "--probe", "place")[0] == 0


def test_force_against_displacement_in_one_command(runs, plot, tmp_path):
    words = ("--x", "displacement.grip-x", "--y", "constraint.grip-x")
    drawn, (history, *_), _ = drawn_and_files(runs, plot, tmp_path, *words)
    assert list(drawn) == ["run", "displacement.grip-x", "constraint.grip-x"]
    t = history["time"]
    up, down = np.minimum(t, 0.06), np.maximum(t - 0.06, 0.0)
    way = 2.5 * up**2 + 0.3 * down - 3.75 * down**2
    np.testing.assert_allclose(numbers(drawn, "displacement.grip-x"), way, rtol=1e-12, atol=1e-17)
    assert np.abs(numbers(drawn, "constraint.grip-x")).max() > 0.0


def invented(runs, folder, name, **columns):
    """A run directory with a history of one's own."""
    directory = folder / f"{name}.out"
    directory.mkdir()
    for file in ("case.yaml", "run.json"):
        shutil.copy(runs / "plates.out" / file, directory)
    columns = {"time": [0.0, 0.5, 1.0], "step": [0, 1, 2]} | columns
    rows = [columns, *zip(*columns.values(), strict=True)]
    (directory / "history.csv").write_text("".join(f"{','.join(map(str, r))}\n" for r in rows))


def test_the_greatest_component_of_each_force_by_default(runs, plot, tmp_path):
    """Of all runs together; signs do not matter, nor lines without a value."""
    names = [f"{name}-{axis}" for name in ("reaction.y-min", "constraint.a") for axis in "xy"]
    none = [0.0] * 3
    for run, values in {
        "one": ([0, 5, 1], [0, 2, 3], none, [0, "nan", -3]),
        "two": ([0, -8, 0], [7, 0, 0], [0, 2, 0], none),
    }.items():
        forces = dict(zip(names, values, strict=True)) | {"reaction.x-min-x": none}
        invented(runs, tmp_path, run, **{"kinetic-energy": none}, **forces)
    assert plot("one.out", "two.out", "--csv", "a.csv")[0] == 0
    expected = ["run", "time", "kinetic-energy", "reaction.y-min-x", "constraint.a-y"]
    assert list(table(tmp_path / "a.csv")) == expected


def drawn_texts(figure):
    """What is written into the panels of a figure, and how many points its lines show."""
    axes = [axis for axis in figure.axes if axis.get_visible()]
    marked = [line for axis in axes for line in axis.lines if line.get_marker() != "None"]
    return [text.get_text() for axis in axes for text in axis.texts], marked


def test_single_lines_and_columns_without_a_value(runs, tmp_path):
    """A single line is a point, which a curve alone would not show."""
    from pgimp.tools.plot.curves import curves

    nothing = ["nan"] * 3
    invented(runs, tmp_path, "a", **{"mass": [1, 2, 3], "body.low.centre-x": nothing})
    shown = open_runs([str(tmp_path / "a.out")])
    for logarithmic, text in ((False, "no value"), (True, "no positive value")):
        figure, _, _ = curves(shown, [], ["mass", "body.low.centre-x"], "time", logarithmic)
        assert drawn_texts(figure)[0] == [text]
    one = tmp_path / "a.out" / "history.csv"
    one.write_text("".join(one.read_text().splitlines(keepends=True)[:2]))
    figure, _, _ = curves(open_runs([str(tmp_path / "a.out")]), [], ["mass"], "time", False)
    texts, marked = drawn_texts(figure)
    assert texts == [] and len(marked) == 1


def test_runs_in_different_units_are_noted(plot):
    status, said, _ = plot("bar.out", "plates.out", "--columns", "mass")
    assert status == 0
    assert "note: the runs have different units; those shown are of bar.out" in said


def test_names_may_have_dollars(runs, plot, tmp_path):
    """They would be read as mathematics, which this is not."""
    shutil.copytree(runs / "plates.out", tmp_path / r"a$\x_$.out")
    for words in ((), ("--field", "body"), ("--along", "x")):
        assert plot("other.out", r"a$\x_$.out", *words, "-o", "a.png")[0] == 0


@pytest.mark.parametrize("low", [1.0, 1.3e-9, 4.7e5])
@pytest.mark.parametrize("over", [1.02, 1.5, 4.0, 30.0, 1e3, 1e7])
def test_logarithmic_axes_have_labels_apart_from_each_other(low, over):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.0, 2.5))
    canvas = FigureCanvasAgg(figure)
    axis = figure.subplots()
    axis.set_yscale("log")
    axis.set_ylim(low, over * low)
    log_ticks(axis.yaxis)
    canvas.draw()
    boxes = [
        tick.label1.get_window_extent()
        for tick in axis.yaxis.get_major_ticks() + axis.yaxis.get_minor_ticks()
        if low <= tick.get_loc() <= over * low and tick.label1.get_text()
    ]
    boxes.sort(key=lambda one: one.y0)
    assert len(boxes) >= 2
    assert all(one.y1 < two.y0 for one, two in pairwise(boxes))


def von_mises(stress):
    deviator = stress.copy()
    deviator[:, :3] -= stress[:, :3].mean(axis=1, keepdims=True)
    return np.sqrt(1.5 * (deviator**2 @ [1, 1, 1, 2, 2, 2]))


@pytest.mark.parametrize(
    ("name", "field", "expected"),
    [
        ("plates", "von-mises", lambda f: f["von-mises"]),
        ("plates", "velocity", lambda f: np.linalg.norm(f["velocity"], axis=1)),
        ("plates", "velocity.y", lambda f: f["velocity"][:, 1]),
        ("plates", "stress.xy", lambda f: f["stress"][:, 3]),
        ("plates", "body", lambda f: f["body"]),
        ("other", "von-mises", lambda f: von_mises(f["stress"])),
        ("other", "pressure", lambda f: -f["stress"][:, :3].mean(axis=1)),
    ],
)
def test_values_of_a_frame(runs, plot, tmp_path, name, field, expected):
    assert plot(f"{name}.out", "--field", field, "-o", "a.csv")[0] == 0
    drawn, frame = table(tmp_path / "a.csv"), hdf5(runs, f"{name}.out")
    np.testing.assert_array_equal(numbers(drawn, "id"), frame["id"])
    for i, axis in enumerate("xy"):
        np.testing.assert_array_equal(numbers(drawn, axis), frame["position"][:, i])
    np.testing.assert_array_equal(numbers(drawn, "radius"), frame["radius"])
    np.testing.assert_allclose(numbers(drawn, field), expected(frame), rtol=1e-14, atol=1e-13)


def test_frames_by_place_and_time(runs, plot, tmp_path):
    assert plot("plates.out", "other.out", "--time", "0.049,0.1", "-o", "a.csv")[0] == 0
    drawn = table(tmp_path / "a.csv")
    chosen = dict.fromkeys(zip(drawn["run"], drawn["frame"], drawn["time"], strict=True))
    assert [(name, int(n), float(t)) for name, n, t in chosen] == [
        (name, n, t) for name in ("plates", "other") for n, t in ((1, 0.05), (2, 0.1))
    ]
    assert plot("plates.out", "--frame=-1,0", "--body", "high", "-o", "b.csv")[0] == 0
    drawn = table(tmp_path / "b.csv")
    assert list(dict.fromkeys(drawn["frame"])) == ["2", "0"]
    high = np.flatnonzero(hdf5(runs, "plates.out")["body"] == 1)
    np.testing.assert_array_equal(numbers(drawn, "id"), np.tile(high, 2))


def test_slice_and_line_take_what_they_cut(runs, plot, tmp_path):
    frame = hdf5(runs, "block.out")
    x, r = frame["position"], frame["radius"]
    cut = np.abs(x[:, 1] - 3.2) <= r
    assert 0 < cut.sum() < len(r)
    assert plot("block.out", "--field", "stress.zz", "--slice", "y=3.2", "-o", "a.csv")[0] == 0
    np.testing.assert_array_equal(numbers(table(tmp_path / "a.csv"), "id"), np.flatnonzero(cut))
    line = cut & (np.abs(x[:, 2] - 2.8) <= r)
    words = ("--field", "stress.zz", "--along", "x", "--at", "y=3.2,z=2.8", "-o", "b.csv")
    assert plot("block.out", *words)[0] == 0
    drawn = table(tmp_path / "b.csv")
    order = np.flatnonzero(line)[np.argsort(x[line, 0], kind="stable")]
    np.testing.assert_array_equal(numbers(drawn, "id"), order)
    np.testing.assert_array_equal(numbers(drawn, "x"), x[order, 0])
    np.testing.assert_array_equal(numbers(drawn, "stress.zz"), frame["stress"][order, 2])


def test_means_across(runs, plot, tmp_path):
    """Strips of half a cell; in the first frame each is a plane of the lattice."""
    for number in (0, -1):
        words = (f"--frame={number}", "--field", "velocity.z", "--along", "z", "-o", "a.csv")
        assert plot("block.out", *words)[0] == 0
        drawn, frame = table(tmp_path / "a.csv"), hdf5(runs, "block.out", number)
        strips = np.floor(frame["position"][:, 2] / 0.5)
        for i, strip in enumerate(np.unique(strips)):
            mine = strips == strip
            weights = frame["volume"][mine]
            for name, values in (("z", frame["position"]), ("velocity.z", frame["velocity"])):
                mean = np.average(values[mine, 2], weights=weights)
                assert numbers(drawn, name)[i] == pytest.approx(mean, rel=1e-12, abs=1e-15)
            assert int(drawn["particles"][i]) == mine.sum()
        assert len(drawn["z"]) == len(np.unique(strips))


def test_a_bar_is_drawn_over_x(runs, plot, tmp_path):
    assert plot("bar.out", "--field", "stress.xx", "--frame", "1,2", "-o", "a.csv")[0] == 0
    drawn = table(tmp_path / "a.csv")
    frames = [hdf5(runs, "bar.out", number) for number in (1, 2)]
    expected = np.concatenate([frame["stress"][:, 0] for frame in frames])
    np.testing.assert_array_equal(numbers(drawn, "stress.xx"), expected)


def drawn_frame(runs, name, field, view=None, limits=None, place=None, number=-1):
    """The picture of a frame as pixels; pixels of points in the picture's plane; the map."""
    from matplotlib import colormaps, rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from pgimp.tools.plot.style import STYLE

    (snapshot,) = snapshots(open_runs([str(runs / name)]), [number], [])
    dimension = snapshot.shown.dimension
    what = quantity(field, snapshot.frame, dimension)
    eye = camera(view, dimension, None)
    with rc_context(STYLE):
        figure, _, _ = picture.picture([snapshot], [what], Selection((), place or {}), eye, limits)
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
    monkeypatch.setattr("pgimp.tools.plot.selection._BLOCK_ROWS", 37)
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
    lightest = colours(np.zeros(1))[0]
    assert np.abs(seen[2] - lightest).max() <= 2
    lightness = seen.sum(axis=1) / lightest.sum()
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


def test_pdf_svg_and_png_are_whole_and_the_same_again(plot, tmp_path):
    for kind in ("pdf", "svg", "png"):
        for name in ("a", "b"):
            assert plot("plates.out", "--field", "von-mises", "-o", f"{name}.{kind}")[0] == 0
        first = (tmp_path / f"a.{kind}").read_bytes()
        assert first == (tmp_path / f"b.{kind}").read_bytes()
    pdf = (tmp_path / "a.pdf").read_bytes()
    assert pdf.startswith(b"%PDF-1.")
    table_of_objects = int(re.search(rb"startxref\s+(\d+)\s+%%EOF\s*$", pdf)[1])
    assert pdf[table_of_objects:].startswith(b"xref")
    assert len(re.findall(rb"/Type /Page\b", pdf)) == 1
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    assert max(len(zlib.decompress(one)) for one in streams if one[:1] == b"x") > 1000
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    assert root.tag.endswith("svg")
    from PIL import Image

    Image.open(io.BytesIO((tmp_path / "a.png").read_bytes())).load()
    assert not list(tmp_path.glob(".*.part"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("nix.out", "there is no run directory nix.out"),
        ("bar.yaml", "there is no run directory bar.yaml"),
        ("plates.out plates.out/", "plates.out is named twice"),
        ("plates.out --columns kinetic-enrgy", "did you mean 'kinetic-energy'?"),
        ("plates.out --columns nothing.*", "unknown column 'nothing.*'"),
        ("plates.out --x tiem", "did you mean 'time'?"),
        ("bar.out --probe top", "did you mean 'tip'? it has: place, slow, tip"),
        ("bar.out --probe tip --y disp", "unknown column 'disp'"),
        ("bar.out --probe tip --frame 1", "--probe is for curves"),
        ("plates.out --probe tip", "plates.out has no probes"),
        ("plates.out --field von-mieses", "did you mean 'von-mises'?"),
        ("plates.out --field stress", "stress has 6 components; draw one of stress.xx"),
        ("plates.out --field stress.xq", "stress has no component 'xq'; it has xx, yy"),
        ("plates.out --field volume.x", "volume has no components"),
        ("other.out --field velocity", "name it in the case's output.fields"),
        ("plates.out --frame 3", "has no frame 3: it has 3, 0 to 2"),
        ("plates.out --frame one", "--frame one: whole numbers"),
        ("plates.out --time 0.2", "no frame at time 0.2: its frames go from 0 to 0.1"),
        ("plates.out --frame 1 --time 0.1", "--frame and --time do not go together"),
        ("plates.out --frame 1 --columns mass", "--columns is for curves"),
        ("plates.out --body hi", "did you mean 'high'?"),
        ("plates.out --camera y-min", "--camera is for three dimensions"),
        ("plates.out --slice y=1", "--slice is for three dimensions"),
        ("plates.out --along z", "the axes are x, y"),
        ("plates.out --along x --at x=1", "axes: y"),
        ("plates.out --along x --at y=no", "the coordinate of y is no number"),
        ("plates.out --along x --at y=9", "no particle at y = 9; its particles reach y from"),
        ("plates.out --at y=1", "--at is for a line: give --along too"),
        ("plates.out --range 2,1", "two numbers, the lower one first"),
        ("plates.out --field body --log", "--log is for curves"),
        ("block.out --camera front", "--camera: unknown camera 'front'"),
        ("block.out --camera 0,0,0", "not all zero"),
        ("block.out --slice y=1,z=2", "one plane"),
        ("block.out --slice y=7", "no particle at y = 7"),
        ("block.out plates.out --frame 0", "different dimensions"),
        ("plates.out -o fig.jpg", "the name must end in .png, .pdf, .svg, .csv"),
        ("plates.out -o nowhere/fig.png", "there is no folder nowhere"),
        ("plates.out --csv fig.png", "the name must end in .csv"),
        ("plates.out -o a.csv --csv a.csv", "name the same file"),
        ("plates.out -o notes.png", "notes.png exists and is no PNG file"),
        ("plates.out --csv plates.out/history.csv", "is no table of pgimp plot"),
    ],
)
def test_messages(plot, tmp_path, words, message):
    (tmp_path / "notes.png").write_text("my notes")
    before = sorted(tmp_path.iterdir())
    content = (tmp_path / "plates.out" / "history.csv").read_bytes()
    status, _, said = plot(*words.split())
    assert status == 2
    assert message in said
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "notes.png").read_text() == "my notes"
    assert (tmp_path / "plates.out" / "history.csv").read_bytes() == content


@pytest.mark.parametrize("words", ["-o fig.png", "-o fig.csv", "--csv fig.csv"])
def test_pipes_are_refused(plot, tmp_path, words):
    """Opening one would wait for ever for who writes into it, renaming would replace it."""
    pipe = tmp_path / words.split()[-1]
    os.mkfifo(pipe)
    status, _, said = plot("plates.out", *words.split())
    assert (status, said) == (2, f"pgimp: cannot read {pipe.name}: it is no regular file\n")
    assert pipe.is_fifo()


def test_a_run_that_has_only_begun(runs, plot, tmp_path):
    """No frames, no history, then a line that is not whole: what is there is drawn."""
    young = tmp_path / "young.out"
    young.mkdir()
    for name in ("case.yaml", "run.json"):
        shutil.copy(runs / "plates.out" / name, young)
    info = json.loads((young / "run.json").read_text())
    info["starts"][-1]["state"] = "running"
    (young / "run.json").write_text(json.dumps(info))
    assert plot("young.out")[::2] == (2, "pgimp: young.out has no line of history yet\n")
    assert plot("young.out", "--field", "body")[::2] == (2, "pgimp: young.out has no frames yet\n")
    lines = (runs / "plates.out" / "history.csv").read_text().splitlines(keepends=True)
    (young / "history.csv").write_text("".join(lines[:3]) + lines[3][:20])
    assert plot("young.out", "-o", "young.csv")[0] == 0
    assert len(table(tmp_path / "young.csv")["time"]) == 2
    (young / "frames").mkdir()
    shutil.copy(runs / "plates.out/frames/particles-000000.h5", young / "frames")
    assert plot("young.out", "--field", "body", "-o", "young.png")[0] == 0


def test_a_material_from_elsewhere_is_no_matter(runs, plot, tmp_path):
    shutil.copytree(runs / "plates.out", tmp_path / "foreign.out")
    case = tmp_path / "foreign.out" / "case.yaml"
    case.write_text(case.read_text().replace("neo-hookean", "my-own"))
    assert plot("foreign.out", "--field", "von-mises")[0] == 0
    assert (tmp_path / "foreign-von-mises-2.png").exists()


def test_works_without_a_display(runs, tmp_path):
    words = ["plot", str(runs / "plates.out"), "-o", str(tmp_path / "a.png")]
    environment = {"DISPLAY": "", "WAYLAND_DISPLAY": "", "MPLBACKEND": "TkAgg"}
    done = run_program([sys.executable, "-m", "pgimp", *words], 60, tmp_path, environment)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_units():
    assert unit("stress", "m, kg, s", 3) == "Pa"
    assert unit("stress", "mm, t, s", 2) == "MPa"
    assert unit("energy", "m, kg, s", 2) == "J/m"
    assert unit("force", "m, kg, s", 1) == "N/m$^2$"
    assert unit("length/time", "mm, t, s", 3) == "mm/s"
    assert unit("length^dimensions", "m, kg, s", 2) == "m$^2$"
    for dimension in (1, 2, 3):
        assert unit("mass/length^dimensions", "m, kg, s", dimension) == "kg/m$^3$"
    assert unit("stress", "none", 3) == ""
    assert unit("stress", "ft, slug, s", 3) == "slug/(ft s$^2$)"
    assert kind_of_column("reaction.z-min-z") == "force"
    assert kind_of_column("body.block.centre-x") == "length"
    assert kind_of_column("momentum-x") == "mass length/time"
    assert kind_of_column("whatever") == ""
    assert kind_of_field("von-mises") == "stress"
