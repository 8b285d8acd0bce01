"""``pgimp plot``: what it writes of frames is what they hold; formats, messages, units."""

import io
import json
import os
import re
import shutil
import sys
import xml.etree.ElementTree as ElementTree
import zlib

import numpy as np
import pytest
from mentioned import mentions
from plotted import hdf5, numbers, table
from processes import run as run_program
from scenes import box, scene

import pgimp
from pgimp.errors import RunError
from pgimp.utilities.plot.units import kind_of_column, kind_of_field, unit

pytestmark = pytest.mark.slow(20)

RUNS = ("bar", "plates", "other", "block")


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
        ("plates.out -o fig.jpg", "the name must end in .png, .pdf, .svg, .gif, .mp4, .csv"),
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
    assert status == 2
    mentions(said, "pgimp: ", pipe.name, "no regular file")
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
    for words, missing in (([], "no line of history"), (["--field", "body"], "no frames")):
        status, _, said = plot("young.out", *words)
        assert status == 2
        mentions(said, "young.out", missing)
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


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ("failed", "from 0 to 0.7; the run failed at t = 0.77"),
        ("stopped", "from 0 to 0.7; the run stopped at t = 0.77"),
        ("running", "from 0 to 0.7; the run goes on, or was killed"),
    ],
)
def test_times_beyond_the_end_of_a_run_that_is_not_done(plot, tmp_path, state, words):
    """A bar that flies out of the domain."""
    bar = scene(1, box([2], [4], [7.9]), cells=[20], cell=0.5, output={"every": 0.1})
    with pytest.raises(RunError, match="left the domain"):
        pgimp.run(bar, output=tmp_path / "run", quiet=True)
    about = tmp_path / "run" / "run.json"
    about.write_text(about.read_text().replace('"failed"', f'"{state}"'))
    status, _, error = plot(str(tmp_path / "run"), "--field", "velocity", "--time", "0.99")
    assert status == 2 and f"no frame at time 0.99: its frames go {words}\n" in error
