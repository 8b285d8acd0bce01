"""Files of particles that are damaged, that lie or that lead elsewhere: refused, without harm."""

import os

import h5py
import numpy as np
import pytest
from clouds import cloud, points
from meshes import case
from point_files import write_hdf5
from scenes import field, start

from pgimp.errors import CaseError


def damaged():
    good = "x,y,volume\n0,0,0.1\n"
    return {
        "nan.csv": (good + "nan,0,0.1\n", "line 3: the position is not finite"),
        "inf.csv": (good + "0,0,inf\n", "line 3: the volume is not finite"),
        "zero.csv": (good + "\n0,1,0\n", "line 4: the volume must be above zero, is 0"),
        "word.csv": (good + "0,one,0.1\n", "line 3, column y: 'one' is no number"),
        "short.csv": (good + "0,0.1\n", "line 3: 2 values, expected 3"),
        "head.csv": ("0,0,0.1\n", "missing x, y, volume; unknown '0', '0.1'; '0' more than once"),
        "key.csv": ("x,y,volume,mass\n0,0,1,1\n", "unknown 'mass'. Expected x,y,volume and, if"),
        "half.csv": ("x,y,volume,velocity-x\n0,0,1,1\n", "columns: missing velocity-y. Expected"),
        "all.csv": (
            "# by a test\nx,z,velocity-y,stress-xx,stress-yz,\x1b[31mred,x\n",
            r"line 2, .*: missing y, volume, velocity-x, stress-yy, stress-zz, stress-xy; z, "
            r"stress-yz, which a case in 2D does not have: leave them out; unknown "
            r"'\\x1b\[31mred'; 'x' more than once\. Expected x,y,volume and, if wanted, "
            r"velocity-x,velocity-y; stress-xx,stress-yy,stress-zz,stress-xy; velocity-grad",
        ),
        "escape.csv": (
            good + "0,\x1b]0;title\x07,0.1\n",
            r"line 3, column y: '\\x1b\]0;title\\x07' is no",
        ),
        "none.csv": ("x,y,volume\n", "holds no particle"),
        "out.csv": (
            good + "\n0,7,0.1\n",
            r"reaches 5 beyond the domain at y-max: to 7 with the particle at \(0, 7\), line 4 of ",
        ),
        "noise.csv": (np.random.default_rng(2).bytes(3000), "cannot"),
        "noise.h5": (np.random.default_rng(2).bytes(3000), "cannot read the particles"),
        "empty.h5": (b"", "it is empty"),
        "what.dat": (good, "must end in .h5, .hdf5, .csv, .vtu or .vtp"),
    }


@pytest.mark.parametrize("name", damaged())
def test_damaged_files_are_refused(tmp_path, name):
    text, message = damaged()[name]
    (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(CaseError, match=message):
        start(case(points(tmp_path / name), dimension=2))


def test_a_row_outside_of_the_grid_is_named(tmp_path):
    data = cloud()
    data["position"][41] = [-2.5, 1.0]
    write_hdf5(tmp_path / "p.h5", data)
    with pytest.raises(CaseError, match=r"x-min: .* \(-2\.5, 1\), row 41 \(from 0\) of ") as error:
        start(case(points(tmp_path / "p.h5"), dimension=2))
    assert "unit" not in str(error.value)
    data["position"] *= 1000.0
    data["position"][41] *= 0.5  # in 4 x 4
    write_hdf5(tmp_path / "p.h5", data)
    with pytest.raises(
        CaseError, match=r"as mm for m\? Times 0\.001, and volumes times 1e-06, its"
    ):
        start(case(points(tmp_path / "p.h5"), dimension=2))


def test_wrong_datasets_are_refused(tmp_path):
    for change, message in (
        ({"volume": None}, "no dataset 'volume'"),
        ({"volume": np.ones(59)}, "59 rows of volume, but 60"),
        ({"position": np.ones((60, 4))}, "'position' has the shape \\(60, 4\\)"),
        ({"position": np.ones((60, 3))}, "row 0 \\(from 0\\): position has a part along"),
        (
            {"stress": np.eye(60, 6)[::-1]},
            r"row 54 \(from 0\): stress has a part along a direction that the case, 2D",
        ),
        (
            {"velocity-gradient": np.ones((60, 9))},
            r"row 0 \(from 0\): velocity-gradient has a part along a direction",
        ),
        ({"velocity-gradient": np.ones((60, 6))}, "'velocity-gradient' has the shape"),
        ({"velocity-gradient": np.ones((60, 4)), "velocity": None}, "gradient, but no velocity"),
        ({"volume": np.full(60, b"x")}, "'volume' is no dataset of numbers"),
    ):
        data = {k: v for k, v in (cloud() | change).items() if v is not None}
        write_hdf5(tmp_path / "p.h5", data)
        with pytest.raises(CaseError, match=message):
            start(case(points(tmp_path / "p.h5"), dimension=2))


def test_a_promise_of_more_particles_than_memory_holds_is_refused_at_once(tmp_path, monkeypatch):
    """Also where reading would find nothing wrong for hours: all rows are sound."""
    with h5py.File(tmp_path / "p.h5", "w") as file:
        more = {"chunks": True, "compression": "gzip", "fillvalue": 1.0}
        file.create_dataset("position", (10**12, 2), "f8", **more)
        file.create_dataset("volume", (10**12,), "f8", **more)
    message = r"cannot use .*p\.h5: it claims 1,000,000,000,000 particles, but the memory that is"
    read = []
    monkeypatch.setattr(h5py.Dataset, "__getitem__", lambda *words: read.append(words))
    with pytest.raises(CaseError, match=message):
        start(case(points(tmp_path / "p.h5"), dimension=2))
    assert not read


def linked():
    """What makes of an HDF5 file, by a name, one whose velocity is elsewhere; and the refusal."""

    def replaced(file, link):
        del file["velocity"]
        file["velocity"] = link

    def raw(file, name):
        del file["velocity"]
        file.create_dataset("velocity", (60, 2), "f8", external=[(name, 0, 960)])

    def view(file):
        layout = h5py.VirtualLayout((60, 2), "f8")
        layout[:] = h5py.VirtualSource("fifo", "velocity", (60, 2))
        del file["velocity"]
        file.create_virtual_dataset("velocity", layout)

    def through(file):
        file["other"] = h5py.ExternalLink("fifo", "/")
        replaced(file, h5py.SoftLink("/other/velocity"))

    def circle(file):
        file["there"] = h5py.SoftLink("/velocity")
        replaced(file, h5py.SoftLink("/there"))

    return {
        "external": (
            lambda f: replaced(f, h5py.ExternalLink("fi\x1bfo", "velocity")),
            r"'velocity' is a link into the file fi\\x1bfo; copy",
        ),
        "nowhere": (
            lambda f: replaced(f, h5py.SoftLink("/nowhere")),
            "'velocity' is a link to nowhere",
        ),
        "circle": (circle, "'velocity' is a link that leads in a circle"),
        "through": (through, "'velocity' is a link into the file fifo"),
        "raw": (lambda f: raw(f, "fifo"), "the data of 'velocity' are in another file, fifo"),
        "device": (lambda f: raw(f, "/dev/zero"), "are in another file, /dev/zero"),
        "view": (view, "'velocity' is a view of other datasets"),
    }


@pytest.mark.parametrize("kind", linked())
def test_data_that_lie_in_other_files_are_refused_and_not_opened(tmp_path, monkeypatch, kind):
    """Nobody writes to the pipe: whoever opened it would wait for ever."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("fifo")
    os.mkfifo("fi\x1bfo")
    write_hdf5(tmp_path / "p.h5", cloud())
    change, message = linked()[kind]
    with h5py.File("p.h5", "r+") as file:
        change(file)
    with pytest.raises(CaseError, match=message):
        start(case(points(tmp_path / "p.h5"), dimension=2))


def test_links_within_the_file_are_followed(tmp_path):
    data = cloud()
    write_hdf5(tmp_path / "p.h5", data)
    with h5py.File(tmp_path / "p.h5", "r+") as file:
        file["a/b/speeds"] = file["velocity"]
        del file["velocity"]
        file["velocity"] = h5py.SoftLink("a/link")
        file["a/link"] = h5py.SoftLink("b/./speeds")
    sim = start(case(points(tmp_path / "p.h5"), dimension=2))
    assert (field(sim, "v") == data["velocity"]).all()


@pytest.mark.parametrize("ending", ["csv", "h5"])
@pytest.mark.parametrize("kind", ["fifo", "device", "folder", "dangling"])
def test_what_is_no_file_is_refused_at_once(tmp_path, kind, ending):
    path = tmp_path / f"p.{ending}"
    if kind == "fifo":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/zero" if kind == "device" else "nowhere")
    with pytest.raises(CaseError, match=r"cannot read the particles .*p\.(csv|h5): "):
        start(case(points(path), dimension=2))
