"""``pgimp plot`` for papers: sheared particles, mirrored halves, looks, changes of curves."""

import csv
import io

import numpy as np
import pytest
from scenes import box, scene

import pgimp
from pgimp.utilities.plot.camera import camera, upright
from pgimp.utilities.plot.curves.changes import Changes, axis_label, moving_mean
from pgimp.utilities.plot.look import pieces
from pgimp.utilities.plot.picture import columns_of
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.runs import PlotRun
from pgimp.utilities.plot.selection import Block, Selection
from pgimp.utilities.plot.visible import draw, extent

RUNS = ("bar", "plates", "block")


class Made:
    """A frame of particles with a deformation each; boxes of 0.5 x 0.25 at the start."""

    bodies = ("body",)
    path = "made"

    def __init__(self, *deformations):
        F = np.array(deformations)
        self.count = len(F)
        volume = 0.125 * np.linalg.det(F)
        x = np.zeros((self.count, 3))
        x[:, 0] = np.arange(self.count)
        self.fields = {
            "id": np.arange(self.count),
            "position": x,
            "radius": 0.5 * np.sqrt(volume),
            "volume": volume,
            "deformation": F.reshape(-1, 9),
            "body": np.zeros(self.count, int),
        }

    def __len__(self):
        return self.count

    def __contains__(self, name):
        return name in self.fields

    def rows(self, name, first, last):
        return self.fields[name][first:last]


VOLUME = Quantity("volume", "volume", None)
SHEAR = np.array([[1.0, 0.8, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
SPACING = (0.5, 0.25)


def taken(frame, **options):
    (block,) = Selection(spacing=SPACING, **options).blocks(frame, VOLUME)
    return block


def test_particles_are_the_parallelograms_that_they_have_become():
    block = taken(Made(np.eye(3), SHEAR, np.diag([2.0, 0.5, 1.0])))
    np.testing.assert_allclose(block.edges[0, :2, :2], [[0.25, 0.0], [0.0, 0.125]])
    np.testing.assert_allclose(block.edges[1, :2, :2], [[0.25, 0.0], [0.1, 0.125]])
    areas = 4.0 * np.abs(np.linalg.det(block.edges[:, :2, :2]))
    np.testing.assert_allclose(areas, block.volume)


def test_cut_ones_have_their_size_and_exploded_ones_are_clipped():
    frame = Made(np.eye(3), 100.0 * np.eye(3))
    frame.fields["radius"][0] *= 0.5
    block = taken(frame)
    np.testing.assert_allclose(block.edges[0, 0, 0], 0.125)
    assert np.linalg.norm(block.edges[1], axis=1).max() < 4.0 * max(SPACING)
    wide = extent(frame, Selection(spacing=SPACING), camera(None, 2, None))
    assert wide[1, 0] < 1.0 + 4.0 * max(SPACING)


def test_without_deformation_they_are_squares():
    frame = Made(SHEAR)
    del frame.fields["deformation"]
    assert taken(frame).edges.size == 0
    (plain,) = Selection().blocks(Made(SHEAR), VOLUME)
    assert plain.edges.size == 0


def test_images_at_planes_of_symmetry():
    block = taken(Made(np.eye(3), SHEAR), mirrored=((0, -1.0), (1, 0.0)))
    assert sorted(block.position[:, 0]) == [-3.0, -3.0, -2.0, -2.0, 0.0, 0.0, 1.0, 1.0]
    np.testing.assert_allclose(np.linalg.det(block.edges[2:4]), -np.linalg.det(block.edges[:2]))
    np.testing.assert_array_equal(block.value, np.tile(block.value[:2], 4))


def test_rings_are_drawn_as_pieces_about_their_axis():
    """They have the rings' volume but for tan(a)/a, their place along y, and the drawn angle."""
    frame = Made(np.eye(3), SHEAR)
    frame.fields["position"] += [2.0, 3.0, 0.0]
    towards = upright("corner").towards
    angles = pieces("270", towards)
    block = taken(frame, angles=angles)
    assert len(angles) == 90 and len(block.id) == 180
    half = 0.5 * (angles[1] - angles[0])
    assert 180 * half == pytest.approx(1.5 * np.pi)
    for number, radius in ((0, 2.0), (1, 3.0)):
        mine = block.id == number
        place, sides = block.position[mine], block.edges[mine]
        np.testing.assert_allclose(np.hypot(place[:, 0], place[:, 2]), radius)
        np.testing.assert_array_equal(place[:, 1], 3.0)
        volume = 8.0 * np.abs(np.linalg.det(sides)).sum()
        exact = 1.5 * np.pi * radius * 0.125 * np.tan(half) / half
        assert volume == pytest.approx(exact)
    # The quarter that is left out is towards the eye.
    level = np.array([towards[0], 0.0, towards[2]]) / np.hypot(towards[0], towards[2])
    direction = block.position * [1.0, 0.0, 1.0]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    assert (direction @ level).max() == pytest.approx(np.cos(0.25 * np.pi + half))
    wide = extent(frame, Selection(spacing=SPACING, angles=angles), upright("y-max"))
    assert wide[1, 0] == pytest.approx(3.0, rel=0.2)


def test_a_body_of_revolution_is_drawn(plot, tmp_path):
    case = scene(2, box([1.0, 1.0], [3.0, 2.0]), cells=[5, 4], end=0.02, step=0.01)
    case |= {"geometry": "axisymmetric", "units": "m, kg, s"}
    case["output"] = {"every": 0.02, "fields": ["velocity", "deformation"]}
    pgimp.run(case, output=tmp_path / "disk.out", quiet=True)
    status, said, _ = plot(
        str(tmp_path / "disk.out"), "--revolve", "--field", "velocity", "-o", "a.png"
    )
    assert status == 0 and "wrote a.png" in said
    for words, message in (
        ("--mirror x-min", "--revolve and --mirror do not go together"),
        ("--contours", "--revolve and --contours do not go together"),
        ("--csv a.csv", "--revolve and --csv do not go together"),
        ("--along x", "--revolve is for a picture"),
        ("-o a.csv", "--revolve is for pictures"),
    ):
        status, _, said = plot(str(tmp_path / "disk.out"), "--revolve", "180", *words.split())
        assert status == 2 and message in said, said
    status, _, said = plot(str(tmp_path / "disk.out"), "--revolve", "5")
    assert status == 2 and "--revolve 5: a number from 10 to 360" in said
    # Totals are all round, not per thickness.
    assert PlotRun(tmp_path / "disk.out", "disk").unit("force") == "N"
    units = pgimp.open(tmp_path / "disk.out").history.units
    assert units["momentum-y"] == "kg m/s" and units["strain-energy"] == "J"


@pytest.mark.parametrize("view", [None, "corner", "y-min"])
def test_what_is_drawn_covers_the_parallelogram(view):
    """In 2D its points and nothing else; of a cube in 3D what a box covers."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2, 2), dpi=100)
    axis = figure.add_axes((0, 0, 1, 1), xlim=(-1, 1), ylim=(-1, 1))
    axis.set_axis_off()
    one = np.zeros(1)
    flat = view is None
    edges = (
        np.eye(3)[None] * 0.4 if not flat else np.array([[[0.5, 0, 0], [0.4, 0.3, 0], [0, 0, 1]]])
    )
    block = Block(one, np.zeros((1, 3)), one + 0.4, one, one, edges)
    draw(axis, camera(view, 2 if flat else 3, None), block, np.array([[1.0, 0, 0, 1]]), flat)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    red = np.asarray(canvas.buffer_rgba())[::-1, :, 1] < 128
    area = red.sum() / 1e4
    eye = camera(view, 3, None).towards
    expected = 4 * 0.15 if flat else 0.64 * np.abs(eye).sum()
    assert area == pytest.approx(expected, rel=0.04)
    if flat:
        assert red[100 + 25, 100 + 75] and not red[100 + 25, 100 - 45]


@pytest.mark.parametrize(
    ("count", "ratio", "expected"),
    [(3, 0.3, 1), (4, 1.0, 4), (3, 1.0, 3), (6, 0.3, 3), (1, 0.2, 1)],
)
def test_wide_pictures_are_below_each_other(count, ratio, expected):
    assert columns_of(count, np.array([1.0, ratio])) == expected


def test_looks_of_pictures(plot, tmp_path):
    style = tmp_path / "paper.mplstyle"
    style.write_text("axes.titlesize: 20\n")
    words = "--field von-mises --frame 0,1 --title Title --width 3 --letters 7 --font serif"
    words += f" --map magma --panels 1 --mirror x-min --style {style} -o fig.svg --csv drawn.csv"
    status, _, said = plot("plates.out", *words.split())
    assert status == 0, said
    text = (tmp_path / "fig.svg").read_text()
    assert float(text.partition('width="')[2].partition("pt")[0]) < 3.3 * 72
    rows = list(csv.DictReader(io.StringIO((tmp_path / "drawn.csv").read_text())))
    x = np.array([float(row["x"]) for row in rows])
    assert x.min() == pytest.approx(-x.max())


def test_changes_of_curves(plot, tmp_path):
    words = "--columns kinetic-energy,strain-energy --factor=-2 --factor-x 1e3 --title T --width 4"
    assert plot("plates.out", *words.split(), "-o", "a.csv")[0] == 0
    assert plot("plates.out", "--columns", "kinetic-energy,strain-energy", "-o", "b.csv")[0] == 0
    assert plot("plates.out", "--columns", "strain-energy", "--over", "mass", "-o", "c.csv")[0] == 0
    assert plot("plates.out", "--columns", "strain-energy", "--mean", "3", "-o", "d.png")[0] == 0
    read = {
        name: list(csv.DictReader(io.StringIO((tmp_path / f"{name}.csv").read_text())))
        for name in "abc"
    }
    heads = [*read["a"][0]]
    assert heads == ["run", "1000 x time", "-2 x kinetic-energy", "-2 x strain-energy"]
    for changed, one, over in zip(*read.values(), strict=True):
        assert float(changed["1000 x time"]) == pytest.approx(1e3 * float(one["time"]))
        energy = float(one["kinetic-energy"])
        assert float(changed["-2 x kinetic-energy"]) == pytest.approx(-2.0 * energy)
        assert float(over["strain-energy / mass"]) <= float(one["strain-energy"])


@pytest.mark.parametrize(
    ("factor", "before", "after"),
    [
        (1e-3, "N/m", "force [kN/m]"),
        (-1e-3, "N", "-force [kN]"),
        (1e-6, "Pa", "force [MPa]"),
        (1e3, "MPa", "force [kPa]"),
        (1e-3, "mJ/mm", "force [J/mm]"),
        (1e3, "m", "force [mm]"),
        (10.0, "cm", "force [mm]"),
        (1e6, "s", "force [us]"),
        (1e-3, "s", "0.001 x force [s]"),
        (10.0, "N", "10 x force [N]"),
        (4.0, "N", "4 x force [N]"),
        (1e3, "m$^2$", "1000 x force [m$^2$]"),
        (1e3, "mm", "force [um]"),
        (1e-3, "kg m/s", "0.001 x force [kg m/s]"),
        (1e-3, "m kg/s", "0.001 x force [m kg/s]"),
        (1e-3, "1e7 N", "0.001 x force [1e7 N]"),
        (-1.0, "N", "-force [N]"),
        (1e-3, "", "0.001 x force"),
    ],
)
def test_powers_of_ten_go_into_units(factor, before, after):
    assert axis_label(factor, "force", before) == after
    assert Changes(factor, over="mass").labelled("force", before).endswith("force / mass")


def test_moving_means():
    values = np.array([1.0, 2.0, np.nan, 4.0, 9.0])
    np.testing.assert_allclose(moving_mean(values, 3), [1.5, 1.5, 3.0, 6.5, 6.5])
    found = Changes(over="b").of({"t": values, "a": values, "b": 0.0 * values}, ["a"], "t")
    assert np.isnan(found["a"]).all()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("plates.out --map nothing", "matplotlib has none of this name"),
        ("plates.out --panels 0 --frame 0", "a whole number from 1 to 12"),
        ("plates.out --mirror z-min", "faces of the domain"),
        ("plates.out --revolve", "--revolve is for axisymmetric scenes"),
        ("plates.out --width wide", "--width wide: a number from"),
        ("plates.out --style nowhere", "--style nowhere"),
        ("plates.out --mean 4", "an odd number of lines"),
        ("plates.out --factor 0", "a number other than 0"),
        ("plates.out --over mas", "did you mean 'mass'?"),
        ("plates.out --factor 2 --frame 0", "--factor is for curves"),
        ("bar.out --frame 0 --map magma", "--map is for a picture"),
        ("plates.out --rate 5", "--rate is for a movie"),
        ("plates.out -o run.gif --frame 0", "leave --frame out"),
        ("bar.out -o run.gif", "in 1D there are none"),
    ],
)
def test_messages_of_looks(plot, words, message):
    status, _, said = plot(*words.split())
    assert status == 2 and message in said
