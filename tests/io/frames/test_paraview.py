"""A real ParaView: the XDMF file through each of its three readers, and cases/in_paraview.py."""

import json
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from paraview_reader import READERS, probe
from particle_source import make_case, make_sim
from PIL import Image

from pgimp.io.results.reader import Frame
from pgimp.mpi.comm import Serial
from pgimp.physics.columns import SURFACE
from pgimp.physics.fields import FIELDS
from pgimp.running.frames import Frames
from pgimp.utilities.plot.units import kind_of_field, unit

pytestmark = pytest.mark.slow(30)

COUNT, GONE = 23, ((), (), range(9, 14))
COUNTS = [COUNT - len(gone) for gone in GONE]


@pytest.fixture(scope="module", params=["as-usual", "small"])
def run(request, tmp_path_factory):
    """Three frames in 3D with every field; values change, and some particles leave at the end."""
    small = {"precision": "float32", "compression": "gzip"} if request.param == "small" else {}
    directory = tmp_path_factory.mktemp("paraview")
    (directory / "frames").mkdir()
    sim, _ = make_sim(Serial(), COUNT, 3)
    frames = Frames(directory, make_case(**small), sim)
    for number, gone in enumerate(GONE):
        sim, _ = make_sim(Serial(), COUNT, 3, gone=gone)
        sim.step, sim.time = 10 * number, 0.1 * number
        sim.particles.sigma *= 1.5**number
        sim.particles.x += 0.25 * number
        frames.write(sim)
    frames.finish()
    return directory


@pytest.fixture(scope="module")
def seen(pvpython, run):
    return probe(pvpython, run / "particles.xdmf", 1)


@pytest.mark.parametrize("reader", READERS)
def test_times_points_cells_and_ids(seen, reader):
    result = seen[reader]
    assert result["times"] == [0.0, 0.1, 0.2]
    for shown, count in zip(result["shown"], COUNTS, strict=True):
        assert shown["kind"] == "vtkUnstructuredGrid"
        assert len(shown["arrays"]["points"]) == count
        assert shown["cells"] == count
        assert shown["global ids"] == "id"


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("number", range(3))
def test_every_field_of_every_frame_arrives(run, seen, reader, number):
    frame = Frame(run / "frames" / f"particles-{number:06d}.h5")
    arrays = seen[reader]["shown"][number]["arrays"]
    assert set(arrays) == {"points", *frame.fields} - {"position"}
    for name in frame.fields:
        values = np.array(arrays["points" if name == "position" else name])
        np.testing.assert_array_equal(values, frame[name].reshape(len(frame), -1), err_msg=name)


@pytest.mark.parametrize("reader", READERS)
def test_the_six_stress_components_stay_apart(run, seen, reader):
    stress = np.array(seen[reader]["shown"][0]["arrays"]["stress"])
    assert stress.shape == (COUNT, 6)
    assert len(np.unique(stress)) == 6 * COUNT


@pytest.mark.parametrize("reader", READERS)
def test_threshold_by_body(run, seen, reader):
    bodies = Frame(run / "frames" / "particles-000002.h5")["body"]
    there = seen[reader]["threshold"]
    assert 0 < there["cells"] == np.count_nonzero(bodies == 1) < len(bodies) == COUNTS[2]
    assert np.unique(there["arrays"]["body"]) == [1]


SCRIPT = Path(__file__).resolve().parents[3] / "cases" / "in_paraview.py"
RADII = np.array([0.3, 0.45, 0.2, 0.4])
CENTRES = np.array([[0.0, 0.0], [3.0, 0.2], [0.1, 2.0], [3.0, 2.0]])


@pytest.fixture(scope="module")
def discs(tmp_path_factory):
    """Two frames of four discs in 2D, apart from each other, of stress 1 to 4 and 2 to 8."""
    directory = tmp_path_factory.mktemp("discs") / "discs.out"
    (directory / "frames").mkdir(parents=True)
    sim, _ = make_sim(Serial(), 4, 2)
    frames = Frames(directory, make_case(), sim)
    particles, rows = sim.particles, sim.live()
    rows = rows[np.argsort(particles.id[rows])]
    particles.x[rows] = CENTRES
    particles.V[rows] = (2.0 * RADII) ** 2
    for number in range(2):
        sim.step, sim.time = number, 0.5 * number
        particles.sigma[rows] = 0.0
        particles.sigma[rows, 1] = (1 + number) * np.arange(1, 5)
        frames.write(sim)
    frames.finish()
    return directory


def colours(path):
    """The discs of a picture from its left and lower end: columns, rows and colours of each."""
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)[::-1]
    inside = pixels[:, : int(0.81 * pixels.shape[1])]  # beside it is the bar of colours
    coloured = np.ptp(inside, axis=2) > 30
    middle = 0.5 * (CENTRES.min(axis=0) + CENTRES.max(axis=0))
    rows, columns = np.nonzero(coloured)
    cut = 0.5 * (columns.min() + columns.max()), 0.5 * (rows.min() + rows.max())
    found = []
    for centre in CENTRES:
        mine = ((columns > cut[0]) == (centre[0] > middle[0])) & (
            (rows > cut[1]) == (centre[1] > middle[1])
        )
        found.append((columns[mine], rows[mine], inside[rows[mine], columns[mine]]))
    return found


@pytest.fixture(scope="module")
def drawn(pvpython, discs):
    """A picture, pictures of all frames and a movie, by the script of cases/."""
    words = ["--field", "stress.yy", "-o", "last.png", "--frames", "all", "--movie", "discs.avi"]
    done = pvpython(SCRIPT, discs, *words, "--size", "900x600", cwd=discs.parent)
    assert done.returncode == 0, done.stderr
    assert "wrote last.png" in done.stdout
    return discs.parent


def test_picture_has_discs_of_the_particles_size(drawn):
    """In pixels; their unit is the distance of two centres, which knows nothing of radii."""
    found = colours(drawn / "last.png")
    centres = np.array([(columns.mean(), rows.mean()) for columns, rows, _ in found])
    pixel = (CENTRES[1, 0] - CENTRES[0, 0]) / (centres[1, 0] - centres[0, 0])
    np.testing.assert_allclose((centres - centres[0]) * pixel, CENTRES - CENTRES[0], atol=0.02)
    areas = np.array([len(rows) for _, rows, _ in found]) * pixel**2
    np.testing.assert_allclose(areas, np.pi * RADII**2, rtol=0.05)


def test_colours_follow_the_field_with_one_range_for_all_times(drawn):
    from matplotlib import colormaps

    assert sorted(path.name for path in (drawn / "all").iterdir()) == [
        f"frame-{number:06d}.png" for number in range(2)
    ]
    for number in range(2):
        found = colours(drawn / "all" / f"frame-{number:06d}.png")
        for disc, (_, _, seen) in enumerate(found):
            value = (1 + number) * (1 + disc)
            expected = 255 * np.array(colormaps["viridis"]((value - 1) / 7)[:3])
            assert np.abs(np.median(seen, axis=0) - expected).max() < 12
    assert (drawn / "last.png").read_bytes() == (drawn / "all/frame-000001.png").read_bytes()


def test_colours_leave_a_few_particles_out(pvpython, tmp_path):
    """One particle of a thousand times the stress of the others leaves them their colours."""
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), 400, 2)
    particles, rows = sim.particles, sim.live()
    particles.x[rows] = np.stack(np.divmod(np.arange(400), 20), axis=1)
    particles.V[rows] = 1.0
    particles.sigma[rows] = 0.0
    particles.sigma[rows, 1] = np.append(1e6, np.arange(1.0, 400.0))
    frames = Frames(tmp_path, make_case(), sim)
    frames.write(sim)
    frames.finish()
    words = ["--field", "stress.yy", "-o", "a.png", "--size", "600x400"]
    done = pvpython(SCRIPT, tmp_path, *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    pixels = np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).astype(int)[:, :480]
    green = pixels[np.ptp(pixels, axis=2) > 30][:, 1]  # rises along the map from 1 to 231
    assert np.percentile(green, 10) < 80 < 180 < np.percentile(green, 90)


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize(
    "units", ["m, kg, s", "mm, t, s", "mm,g,ms", "mm, kg, ms", "cm, g, us", "ft, slug, s", "none"]
)
def test_units_are_those_of_plot(monkeypatch, tmp_path, dimension, units):
    """Of every field that has one; the script itself knows no pgimp."""
    modules = ("paraview", "paraview.simple", "paraview.servermanager")
    for name in modules:
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    for name in modules[1:]:
        setattr(sys.modules["paraview"], name.rpartition(".")[2], sys.modules[name])
    spec = spec_from_file_location("script", SCRIPT)
    script = module_from_spec(spec)
    monkeypatch.setattr(sys, "path", [*sys.path])
    spec.loader.exec_module(script)
    (tmp_path / "case.yaml").write_text(f"dimensions: {dimension}\nunits: {json.dumps(units)}\n")
    found = script._units(str(tmp_path))
    for name in {*FIELDS, *SURFACE} - {"position"}:
        wanted = unit(kind_of_field(name), units, dimension)
        wanted = wanted.replace("$^2$", "\u00b2").replace("$^3$", "\u00b3")
        assert found.get(script.KINDS.get(name), "") == wanted, name


def test_movie_is_one(drawn):
    content = (drawn / "discs.avi").read_bytes()
    assert content[:4] == b"RIFF"
    assert content[8:12] == b"AVI "
    assert content.count(b"00dc") >= 2
    assert not list(drawn.glob(".paraview-*"))


@pytest.mark.parametrize("run", ["as-usual"], indirect=True)
def test_three_dimensions_from_a_corner(pvpython, run, tmp_path):
    """Spheres, shaded; a component, a body, a range, from the corner."""
    words = ["--field", "stress.xx", "--body", "1", "--range", "-1", "1", "--size", "600x400"]
    done = pvpython(SCRIPT, run, *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (path,) = tmp_path.glob("*-stress.xx.png")
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    inside = pixels[:, :480]
    coloured = np.ptp(inside, axis=2) > 30
    assert 0.02 < coloured.mean() < 0.9
    assert len(np.unique(inside[coloured] // 16, axis=0)) > 20


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nix.out"], "there is no run directory nix.out"),
        (["."], "has no particles.xdmf"),
        (["discs.out", "--field", "von-mieses", "-o", "a.png"], "no field von-mieses; it has body"),
        (["discs.out", "--frame", "2"], "there is no frame 2: there are 2, from 0, or -1"),
        (["discs.out", "--movie", "film.gif"], "a movie ends in .avi, .ogv, .mp4"),
    ],
)
def test_script_says_what_is_wrong(pvpython, discs, words, message):
    before = sorted(discs.parent.iterdir())
    done = pvpython(SCRIPT, *words, cwd=discs.parent)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert sorted(discs.parent.iterdir()) == before


def test_another_python_says_where_the_script_belongs(python):
    done = python(["-S", SCRIPT, "run.out"])
    assert done.returncode == 1
    assert "Run it with pvpython" in done.stderr
