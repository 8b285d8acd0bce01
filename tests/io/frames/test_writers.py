"""A further format of frames is one class and one entry: it sees each frame as the others do."""

from types import SimpleNamespace

import h5py
import pytest
from particle_source import make_case, make_sim

from pgimp.io.frames import writers
from pgimp.io.frames.mesh import described
from pgimp.io.frames.writer import Writer
from pgimp.mpi.comm import Serial
from pgimp.running.frames import Frames


class Names(Writer):
    """Lists the frames' names and fields, one a line."""

    suffix = ".txt"

    def __init__(self, path):
        super().__init__(path)
        self.lines = []

    @classmethod
    def begin(cls, file):
        """Note in the frame how many datasets it has."""
        file.attrs["datasets"] = len([name for name in file if name != "VTKHDF"])

    def add(self, mesh):
        self.lines.append(f"{mesh.relative} {mesh.step} {mesh.points} {','.join(mesh.fields)}\n")

    def finish(self, last=False):
        self.path.write_text("".join(self.lines))

    restart = finish


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Two frames, in the three formats, and the simulation."""
    monkeypatch.setattr(writers, "WRITERS", (*writers.WRITERS, Names))
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), 20, 2)
    frames = Frames(tmp_path, make_case(["stress"]), sim)
    for step in (3, 8):
        sim.step, sim.time = step, 0.1 * step
        frames.write(sim)
        frames.finish()
    frames.close()
    return SimpleNamespace(path=tmp_path, sim=sim)


FIELDS = "id,body,material,position,volume,radius,stress"


def test_it_lists_each_frame_beside_the_others(written):
    lines = (written.path / "particles.txt").read_text().splitlines()
    assert lines == [f"frames/particles-00000{n}.h5 {s} 20 {FIELDS}" for n, s in ((0, 3), (1, 8))]
    assert {path.suffix for path in written.path.iterdir()} == {".xdmf", ".vtkhdf", ".txt", ""}
    with h5py.File(written.path / "frames" / "particles-000001.h5") as file:
        assert file.attrs["datasets"] == 1 + len(FIELDS.split(","))


def test_a_resumed_run_lists_the_same(written):
    """Fields are in the order in which the run wrote them, in each format."""
    before = {p.name: p.read_bytes() for p in written.path.iterdir() if p.is_file()}
    frames = Frames(written.path, make_case(["stress"]), written.sim)
    assert frames.resume(2) == []
    assert {p.name: p.read_bytes() for p in written.path.iterdir() if p.is_file()} == before


def test_fields_of_an_earlier_stage_stay_listed(written):
    """As a run lists them that has not been stopped meanwhile."""
    frames = Frames(written.path, make_case(["velocity"]), written.sim)
    frames.resume(2)
    assert 'Name="stress"' in (written.path / "particles.xdmf").read_text()


def test_kinds_of_fields_follow_from_their_columns(written):
    file = written.path / "frames" / "particles-000000.h5"
    fields = described(file, FIELDS.split(",")).fields
    assert {name: field.kind for name, field in fields.items()} == {
        "id": "GlobalId", "body": "Scalar", "material": "Scalar", "position": "Vector",
        "volume": "Scalar", "radius": "Scalar", "stress": "Matrix",
    }  # fmt: skip
