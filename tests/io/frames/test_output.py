"""Frames, read back with h5py against the arrays that they were written from."""

import os
import sys
import xml.etree.ElementTree
from pathlib import Path
from threading import Event
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from frame_sets import COUNTS, GONE, frame_digests
from particle_source import SAME, Lines, expected, make_case, make_sim, write_frames
from processes import HERE
from tiers import wide

from pgimp.errors import RunError
from pgimp.io.frames import particlefile
from pgimp.io.results.history import History, read
from pgimp.io.results.reader import Frame
from pgimp.mpi.comm import Serial, world
from pgimp.physics.derived import DERIVED, eigen
from pgimp.physics.fields import ALWAYS, FIELDS, Source
from pgimp.running.frames import Frames
from pgimp.storage import framefile
from pgimp.storage.rows import Rows


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_frame_holds_the_particles_by_id(tmp_path, dimension):
    _, values = write_frames(tmp_path, Serial(), 57, dimension, fields=SAME)
    wanted = expected(values, dimension)
    with h5py.File(tmp_path / "frames" / "particles-000001.h5") as file:
        assert set(file) - {"VTKHDF"} == set(wanted) == {"connectivity", *SAME, *ALWAYS}
        for name, array in wanted.items():
            exact = name not in ("radius", "pressure", "von-mises", "strain")
            assert file[name].shape == array.shape
            rtol, atol = (0 if exact else 1e-13), (1e-14 if name == "strain" else 0)
            if name in DERIVED:  # in 1D the Lode angle is that of cos = 1, of half the digits
                rtol, atol = 1e-10, 2e-6 if name == "lode-angle" else 1e-11
            np.testing.assert_allclose(file[name][:], array, rtol=rtol, atol=atol, err_msg=name)
        for name in ("body", "material"):
            assert file[name].dtype == np.int32
        assert file["id"].dtype == np.int64
        assert file.attrs["time"] == 0.1 and file.attrs["step"] == 3
        assert file.attrs["title"] == "a test" and file.attrs["units"] == "none"
        assert list(file.attrs["bodies"]) == list(file["body"].attrs["names"]) == ["left", "right"]
        assert list(file["material"].attrs["names"]) == ["soft", "hard"]


def strained(F):
    """Strain of one particle, by the name of the component."""
    F = np.array(F, float)
    particles = SimpleNamespace(F=F.reshape(1, -1))
    values = FIELDS["strain"].values(Source(particles, np.array([0]), len(F), (0,)))
    return dict(zip(FIELDS["strain"].components.split(), values[0].tolist(), strict=True))


def test_strain_of_stretch_shear_and_rotation():
    """Exact: of a stretch (s^2 - 1)/2, of a simple shear by g, g/2 along and g^2/2 across."""
    none = dict.fromkeys(["xx", "yy", "zz", "xy", "yz", "xz"], 0.0)
    assert strained([[1.5]]) == none | {"xx": 0.625}
    assert strained([[1.0, 0.5], [0.0, 1.0]]) == none | {"xy": 0.25, "yy": 0.125}
    shear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.25], [0.0, 0.0, 1.0]]
    assert strained(shear) == none | {"yz": 0.125, "zz": 0.03125}
    assert strained([[1.0, 0.0, 0.25], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]) == none | {
        "yy": 1.5, "xz": 0.125, "zz": 0.03125,
    }  # fmt: skip
    assert strained([[0.6, -0.8], [0.8, 0.6]]) == pytest.approx(none, abs=1e-15)


@pytest.mark.parametrize(
    "values", [(3.0, 3.0, 1.0), (1.0, 1.0, 1.0), (1e8, 1e8 - 1e-4, -1.0), (0, 0, 0)]
)
def test_principal_values_that_are_close(values):
    """Eigenvectors stay orthogonal, and give the tensor back, where values are equal."""
    turned = np.linalg.qr(np.random.default_rng(5).normal(size=(9, 3, 3)))[0]
    tensor = (turned * np.array(values)) @ np.swapaxes(turned, 1, 2)
    found, vectors = eigen(tensor.reshape(-1, 9)[:, [0, 4, 8, 1, 5, 2]])
    size = max(1e-300, abs(values[0]))
    np.testing.assert_allclose(found, np.tile(values, (9, 1)), rtol=0, atol=4e-15 * size)
    np.testing.assert_allclose(vectors @ np.swapaxes(vectors, 1, 2), [np.eye(3)] * 9, atol=1e-14)
    back = np.swapaxes(vectors, 1, 2) @ (found[:, :, None] * vectors)
    np.testing.assert_allclose(back, tensor, rtol=0, atol=4e-15 * size)


def test_the_rank_is_that_of_the_writer(tmp_path):
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), 5, 2)
    particles, rows = sim.particles, sim.live()
    assert FIELDS["rank"].values(Source(particles, rows, 2, (1, 0), 3)).tolist() == [3] * 5
    frames = Frames(tmp_path, make_case(["rank"]), sim)
    frames.write(sim)
    frames.finish()
    frame = Frame(tmp_path / "frames" / "particles-000000.h5")
    assert frame["rank"].dtype == np.int32 and frame["rank"].tolist() == [0] * 5


def test_only_what_is_asked_for_is_written(tmp_path):
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), 5, 2)
    frames = Frames(tmp_path, make_case(["stress"]), sim)
    frames.write(sim)
    frames.finish()
    frame = Frame(tmp_path / "frames" / "particles-000000.h5")
    assert set(frame.fields) == {*ALWAYS, "stress"}
    attributes = xml.etree.ElementTree.parse(tmp_path / "particles.xdmf").iter("Attribute")
    shown = {attribute.get("Name") for attribute in attributes}
    assert shown == {*ALWAYS, "stress"} - {"position"}


@pytest.mark.parametrize(
    "name", [name for name in FIELDS if name not in {"strain-energy-density", "recovered-stress"}]
)
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_field_values_do_not_depend_on_the_neighbours(name, dimension):
    """The bits of a particle may not change with where in an array it is processed."""
    sim, _ = make_sim(Serial(), 40, dimension)
    rows = sim.live()

    def values(some):
        periods = ((-1.0, 3.0),) * dimension
        source = Source(sim.particles, some, dimension, (1, 0), periods=periods)
        return FIELDS[name].values(source)

    whole = values(rows)
    for start in range(9):
        for length in (1, 2, 3, 4, 5, 8, 13, 31):
            part = values(rows[start : start + length])
            assert part.tobytes() == whole[start : start + length].tobytes()


WAYS = ("at-once", "in-small-blocks")


@pytest.mark.parametrize("ranks", [3, *(wide(n) for n in (2, 4))])
def test_every_number_of_ranks_writes_the_same_file(tmp_path, mpirun, ranks):
    job = mpirun(ranks, [__file__, tmp_path], env=HERE)
    assert job.returncode == 0, job.stdout + job.stderr
    for kind, count in COUNTS.items():
        serial = tmp_path / f"serial-{kind}"
        _, values = write_frames(serial, Serial(), count, 3, gone=GONE.get(kind, ()))
        assert len(values["id"]) == count - len(GONE.get(kind, ()))
        wanted = frame_digests(serial)
        assert set(wanted) == {"particles-000000.h5", "particles-000001.h5"}
        for way in WAYS:
            directory = tmp_path / f"{way}-{kind}"
            assert frame_digests(directory) == wanted, (kind, way)
            for name in ("particles.xdmf", "particles.vtkhdf"):
                assert (directory / name).read_bytes() == (serial / name).read_bytes()
            with h5py.File(directory / "frames" / "particles-000001.h5") as file:
                for name in ("id", "stress"):
                    np.testing.assert_array_equal(file[name][:], expected(values, 3)[name])


@pytest.mark.parametrize("ids", [[0, 1, 3, 3], [0, 1, 3], [0, 1, 2, 4]])
def test_a_lost_particle_is_noticed(ids):
    ids = np.array(ids)
    for complete in (True, False):
        if complete or len(ids) > 3:
            with pytest.raises(RunError, match="an id is missing or there twice"):
                Rows(Serial(), ids, np.arange(len(ids)), 4, complete)
        else:
            assert Rows(Serial(), ids, np.arange(len(ids)), 4, complete).count == 3


def test_a_frame_appears_only_when_the_disk_has_it(tmp_path, monkeypatch):
    """Until then it has no name and the series does not list it; an error of the disk is told."""
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), 5, 2)
    frames, disk = Frames(tmp_path, make_case(), sim), Event()
    monkeypatch.setattr(os, "fdatasync", lambda descriptor: disk.wait(60))
    frames.write(sim)
    assert frames.waiting and not frames.ready and frames.written == 0
    assert [path.suffix for path in (tmp_path / "frames").iterdir()] == [".part"]
    disk.set()
    frames.sync()
    assert not frames.waiting and frames.ready and frames.written == 1
    before = sorted(path.name for path in tmp_path.rglob("*"))
    assert before == ["frames", "particles-000000.h5", "particles.vtkhdf", "particles.xdmf"]

    def broken(descriptor):
        raise OSError(5, "the text does not matter")

    monkeypatch.setattr(os, "fdatasync", broken)
    frames.write(sim)
    with pytest.raises(RunError, match=r"frame .*particles-000001\.h5 .* Input/output error"):
        frames.write(sim)
    assert sorted(path.name for path in tmp_path.rglob("*")) == before


def test_history_lines_hold_every_bit(tmp_path):
    sim, history = Lines(), History(tmp_path / "history.csv")
    for step in range(3):
        sim.step, sim.time = step, step * 0.1
        history.write(sim)
        history.write(sim)  # a second line for the same step is not wanted
        assert len((tmp_path / "history.csv").read_text().splitlines()) == step + 2
    history.close()
    with open(tmp_path / "history.csv", "a") as stream:
        stream.write("0.30000000000000004,3,0.3")  # a line that is just being written
    table = read(tmp_path / "history.csv")
    assert table.dtype.names == tuple(sim.diagnostics())
    assert len(table) == 3
    for name, value in sim.diagnostics().items():
        assert table[name][-1].tobytes() == np.float64(value).tobytes()
    assert "0.30000000000000004" in (tmp_path / "history.csv").read_text()


if __name__ == "__main__":
    comm = world()
    for kind, count in COUNTS.items():
        for way in WAYS:
            framefile._ROWS = 50 if way == WAYS[1] else 1 << 14
            particlefile._TOGETHER = 1 << (12 if way == WAYS[1] else 22)
            directory = Path(sys.argv[1]) / f"{way}-{kind}"
            gone = GONE.get(kind, ())
            write_frames(directory, comm, count, 3, (1,), gone=gone)
