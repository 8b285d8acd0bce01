"""Frames in single precision and compressed: the same particles, in fewer bytes."""

import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from frame_sets import COUNTS, GONE, frame_digests
from particle_source import fill_up, make_case, make_sim, small_disk, write_frames
from processes import HERE
from tiers import wide

from pgimp.errors import RunError
from pgimp.io.results.reader import Frame
from pgimp.mpi.comm import Serial, world
from pgimp.running.frames import Frames
from pgimp.storage import chunks, framefile

FORMS = {
    "single": {"precision": "float32"},
    "packed": {"compression": "gzip"},
    "both": {"precision": "float32", "compression": "gzip"},
}
#: Rows of a chunk here, so that a few thousand particles take several.
ROWS = 500


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch):
    monkeypatch.setattr(chunks, "ROWS", ROWS)


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("form", FORMS)
def test_a_frame_holds_the_same_but_for_rounding(tmp_path, form, dimension):
    whole, other = (
        write_frames(tmp_path / name, Serial(), 1203, dimension, number=1, **output)[0].folder
        / "particles-000000.h5"
        for name, output in (("whole", {}), (form, FORMS[form]))
    )
    single = "precision" in FORMS[form]
    with h5py.File(whole) as one, h5py.File(other) as two:
        assert list(one) == list(two) and one.attrs.keys() == two.attrs.keys()
        for name in [name for name in one if name != "VTKHDF"]:
            exact = one[name][()]
            rounded = exact.astype(np.float32) if single and exact.dtype == float else exact
            assert two[name].dtype == rounded.dtype
            assert two[name][()].tobytes() == rounded.tobytes()
            assert dict(two[name].attrs).keys() == dict(one[name].attrs).keys()
            packed = (two[name].compression, two[name].shuffle, two[name].chunks)
            tail = exact.shape[1:]
            assert packed == (
                ("gzip", True, (ROWS, *tail)) if form != "single" else (None, False, None)
            )
    assert other.stat().st_size < whole.stat().st_size
    frame = Frame(other)
    assert frame["stress"].dtype == (np.float32 if single else np.float64)
    np.testing.assert_array_equal(frame.rows("id", 499, 501), [499, 500])


@pytest.mark.parametrize("ranks", [wide(2), 3])
def test_every_number_of_ranks_writes_the_same_file(tmp_path, mpirun, ranks):
    job = mpirun(ranks, [__file__, tmp_path], env=HERE)
    assert job.returncode == 0, job.stdout + job.stderr
    for kind, count in COUNTS.items():
        for form in FORMS:
            serial = tmp_path / f"serial-{form}-{kind}"
            write_frames(serial, Serial(), count, 3, gone=GONE.get(kind, ()), **FORMS[form])
            directory = tmp_path / f"{form}-{kind}"
            assert frame_digests(directory) == frame_digests(serial), (form, kind)
            for name in ("particles.xdmf", "particles.vtkhdf"):
                assert (directory / name).read_bytes() == (serial / name).read_bytes()


@pytest.mark.parametrize("form", ["packed", "both"])
def test_any_amount_of_free_space_is_handled(tmp_path, form):
    sim, _ = make_sim(Serial(), 1100, 3)
    with small_disk(tmp_path / "disk") as disk:
        (disk / "frames").mkdir()
        frames = Frames(disk, make_case(**FORMS[form]), sim)
        frames.write(sim)
        frames.finish()
        path = disk / "frames" / "particles-000000.h5"
        before = path.read_bytes()
        for free in range(0, len(before), 1 << 14):
            ballast = fill_up(disk, but=free)
            with pytest.raises(RunError, match=r"particles-000001\.h5 at step 3: No space left"):
                frames.write(sim)
            ballast.unlink()
            assert [path] == list(path.parent.iterdir()) and path.read_bytes() == before
        frames.write(sim)
        frames.finish()
        again = path.with_name("particles-000001.h5").read_bytes()
        assert again == before


def test_what_float32_cannot_hold_is_refused(tmp_path):
    (tmp_path / "frames").mkdir()
    sim, _ = make_sim(Serial(), 30, 2)
    frames = Frames(tmp_path, make_case(precision="float32"), sim)
    # Too small for normal numbers, and no fault.
    sim.particles.V[:] = sim.particles.m[:] = 1e-50
    frames.write(sim)
    sim.particles.sigma[sim.live()[7], 1] = 1e39
    frames.write(sim)
    with pytest.raises(RunError, match=r"the stress of a particle is beyond .* float32.*--resume"):
        frames.finish()
    assert len(list((tmp_path / "frames").iterdir())) == 1


if __name__ == "__main__":
    chunks.ROWS, framefile._ROWS = ROWS, 70
    for kind, count in COUNTS.items():
        for form, output in FORMS.items():
            directory = Path(sys.argv[1]) / f"{form}-{kind}"
            write_frames(directory, world(), count, 3, (1,), gone=GONE.get(kind, ()), **output)
